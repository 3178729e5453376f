"""A car that slips: single track, combined tyre slip, rear-wheel or all-wheel drive."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, Literal

import numpy as np

from subgoal._kernels.car import GRAVITY, Build, advance, derivatives
from subgoal.dynamics.protocol import paired
from subgoal.runtime.checks import Floats, frozen, positive
from subgoal.runtime.errors import InputError
from subgoal.runtime.executor import run_all

_LENGTHS = ("mass", "inertia", "front", "rear", "friction", "stiffness", "shape", "lag", "smoothing", "step")


ROWS = 4096
"""Cars that one thread drives."""


@dataclass(frozen=True, repr=False)
class Car:
    """The single-track car with combined tyre slip of Velenis, Tsiotras and Lu; the numbers are those of a model car.

    Called, it is a transition function: ``car(states, actions, duration)`` takes states (B, 4) and held actions (B, 2)
    to the states (B, 4) after ``duration`` seconds, by Heun's method in steps of at most ``step`` seconds. A state is
    (v_x, v_y, r, w): body velocities in m/s, yaw rate in rad/s, surface speed of the driven wheels in m/s. An action is
    (δ, w_c): steering angle in rad and commanded wheel speed in m/s, which w follows with a first-order ``lag``.

    Attributes
    ----------
    mass, inertia:
        kg, and kg m² about the vertical.
    front, rear, height:
        m from the centre of mass to the axles, and its height, which moves load to the rear axle when speeding up.
    friction, stiffness, shape:
        μ, B and C of the simplified magic formula μ sin(C arctan(B s)), s the combined slip.
    rolling:
        Drag of a free wheel as a share of its load.
    lag:
        s, of the wheel speed behind its command.
    smoothing:
        v₀ in m/s: slip velocities are divided by √(w² + v₀²), so that a standing car has a slip.
    drive:
        "rear": the front wheels turn freely and have lateral slip only; "all": all wheels turn at w.
    step:
        s, the longest step of integration.

    Raises
    ------
    InputError
        Numbers that are not above zero (height and rolling: at least zero), a height that could lift an axle, a step
        too long for the fastest motion of the car, wrong shapes, NaN and infinity.
    """

    mass: float = 0.906
    inertia: float = 0.003
    front: float = 0.10
    rear: float = 0.107
    height: float = 0.0
    friction: float = 0.45
    stiffness: float = 4.0
    shape: float = 1.4
    rolling: float = 0.02
    lag: float = 0.10
    smoothing: float = 0.3
    drive: Literal["rear", "all"] = "rear"
    step: float = 0.005

    names: ClassVar[tuple[str, ...]] = ("vx", "vy", "r", "w")
    units: ClassVar[tuple[str, ...]] = ("m/s", "m/s", "rad/s", "m/s")
    action_names: ClassVar[tuple[str, ...]] = ("delta", "w_c")
    bounds: ClassVar[tuple[Floats, Floats]] = (frozen(np.array([-0.5, 0.0])), frozen(np.array([0.5, 3.6])))
    """Lowest and highest action, (2,) each: ±0.5 rad, 0 to 3.6 m/s."""

    def __post_init__(self) -> None:
        for what in _LENGTHS:
            object.__setattr__(self, what, positive(what, getattr(self, what)))
        for what in ("height", "rolling"):
            object.__setattr__(self, what, positive(what, getattr(self, what), zero=True))
        if self.drive not in ("rear", "all"):
            raise InputError("drive", found=repr(self.drive), wanted="'rear' or 'all'")
        if not self.height * (self.friction + self.rolling) < min(self.front, self.rear):
            most = min(self.front, self.rear) / (self.friction + self.rolling)
            raise InputError("height", found=self.height, wanted=f"below {most:.3g} m: both axles keep a load")
        if not self.step * self._fastest <= 2:
            hint = "a shorter step, or a larger smoothing"
            raise InputError("step", found=self.step, wanted=f"at most {2 / self._fastest:.3g} s", hint=hint)

    def __repr__(self) -> str:
        usual = {each.name: each.default for each in fields(self)}
        changed = [f"{name}={getattr(self, name)!r}" for name in usual if getattr(self, name) != usual[name]]
        return f"Car({', '.join(changed) or 'rear-wheel drive'})"

    @property
    def _fastest(self) -> float:
        """1/s, the fastest rate of the car at rest; Heun's method is stable up to 2 / rate."""
        grip = self.friction * self.stiffness * self.shape * GRAVITY / self.smoothing
        return max(1 / self.lag, grip * max(1.0, self.mass * self.front * self.rear / self.inertia))

    @cached_property
    def _build(self) -> Build:
        values = {name: getattr(self, name) for name in Build._fields[:-1]}
        return Build(**values, drives_front=self.drive == "all")

    def __call__(self, states: Any, actions: Any, duration: float) -> Floats:
        """(B, 4) the states after ``duration`` seconds of held actions."""
        begin, held = self._checked(states, actions)
        out, seconds = np.empty(begin.shape), positive("duration", duration, zero=True)
        edges = np.linspace(0, len(begin), max(1, len(begin) // ROWS) + 1).astype(int).tolist()
        parts = [(begin[a:b], held[a:b], seconds, self.step, self._build, out[a:b]) for a, b in pairwise(edges)]
        run_all(advance, parts, workers=None if len(parts) > 1 else 1)
        return out

    def derivative(self, states: Any, actions: Any) -> Floats:
        """(B, 4) d state / dt of states (B, 4) under actions (B, 2)."""
        at, held = self._checked(states, actions)
        out = np.empty(at.shape)
        derivatives(at, held, self._build, out)
        return out

    def _checked(self, states: Any, actions: Any) -> tuple[Floats, Floats]:
        pair = paired(states, actions)
        for what, values, names in zip(("states", "actions"), pair, (self.names, self.action_names), strict=True):
            if values.shape[1] != len(names):
                raise InputError(what, found=f"shape {values.shape}", wanted=f"(B, {len(names)}): {', '.join(names)}")
        return pair


REAR_DRIVE = Car()
"""The rear-driven model car; its drift is an unstable equilibrium, held by countersteering."""

ALL_DRIVE = Car(drive="all")
"""The same with all wheels driven; its drift is stable."""
