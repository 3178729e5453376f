"""Steady states of a car: where a held command leaves it, and whether it stays there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from subgoal.dynamics.car import Car
from subgoal.runtime.checks import Floats, frozen, real_array
from subgoal.runtime.errors import InputError

RESIDUAL = 1e-8
"""Largest derivative, in units of the state per second, of what counts as steady."""

APART = 1e-4
"""Steady states nearer than this in every dimension are one."""

_STEP = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium:
    """A state that does not change while its command is held.

    Attributes
    ----------
    state, action:
        (4,) and (2,), as in ``Car``.
    eigenvalues:
        (4,) complex, 1/s, of the Jacobian at the held command, the slowest to decay first.
    residual:
        Largest absolute derivative that is left.
    """

    state: Floats
    action: Floats
    eigenvalues: NDArray[np.complex128]
    residual: float

    def __repr__(self) -> str:
        state, action = (", ".join(f"{value:.2f}" for value in values) for values in (self.state, self.action))
        return f"Equilibrium(({state}) under ({action}), {'' if self.stable else 'un'}stable)"

    @property
    def growth(self) -> float:
        """1/s, the largest real part of the eigenvalues: how fast a small error grows, or decays if below zero."""
        return float(self.eigenvalues[0].real)

    @property
    def stable(self) -> bool:
        """Whether small errors die out by themselves."""
        return self.growth < 0

    @property
    def sideslip(self) -> float:
        """β = arctan(v_y / v_x) in rad; 0 at rest."""
        return float(np.arctan2(self.state[1], self.state[0]))


def jacobians(car: Car, state: Any, action: Any) -> tuple[Floats, Floats]:
    """(4, 4) ∂(d state / dt) / ∂ state and (4, 2) the same by the action, by central differences."""
    point = np.append(state, action)
    shifts = _STEP * np.eye(point.size)
    up, down = (car.derivative(each[:, :4], each[:, 4:]) for each in (point + shifts, point - shifts))
    slopes = (up - down).T / (2 * _STEP)
    return slopes[:, :4], slopes[:, 4:]


def steady_state(car: Car, action: Any, start: Any) -> Equilibrium:
    """The steady state under ``action`` (2,) that a root search from ``start`` (4,) finds.

    Raises ``InputError`` when the search ends in no steady state.
    """
    held, begin = real_array("action", action, ndim=1), real_array("start", start, ndim=1)
    found = _search(car, held, begin)
    if found is None:
        told = ", ".join(f"{value:g}" for value in begin)
        raise InputError(
            "start", found=f"no steady state from ({told})", wanted="a start near one",
            hint="equilibria_of(car, action), which searches from many starts",
        )  # fmt: skip
    return found


def equilibria_of(car: Car, action: Any) -> tuple[Equilibrium, ...]:
    """All distinct steady states under ``action`` (2,) that are found from 315 starts, the most stable first.

    The starts are speeds up to 1.2 w_c, sideslips to ±80° and yaw rates to ±4.5 rad/s: gripping, drifting to either
    side, and spinning. What is found is steady; that nothing was missed is not proved.
    """
    held = real_array("action", action, ndim=1)
    found: list[Equilibrium] = []
    for speed, angle, rate in product((0.1, 0.3, 0.6, 0.9, 1.2), np.linspace(-1.4, 1.4, 9), np.linspace(-4.5, 4.5, 7)):
        forward = speed * max(held[1], 0.1)
        each = _search(car, held, np.array([forward * np.cos(angle), forward * np.sin(angle), rate, held[1]]))
        if each is not None and all(np.abs(each.state - other.state).max() > APART for other in found):
            found.append(each)
    return tuple(sorted(found, key=lambda each: each.growth))


def manoeuvres(car: Car) -> dict[str, Equilibrium]:
    """Stop, straight, left, right, left drift and right drift of a model car, each solved for.

    The drift of a rear-driven car is held by countersteering. Raises ``InputError`` for a car that has no such steady
    state.
    """
    if car.drive == "rear":
        drift, start = (-0.30, 2.5), (1.2, -0.8, 2.3, 2.5)
    else:
        drift, start = (0.20, 2.6), (1.2, -1.1, 2.6, 2.6)
    left, mirror, over = (0.22, 1.5), np.array([1.0, -1.0, -1.0, 1.0]), np.array([-1.0, 1.0])
    return {
        "stop": steady_state(car, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
        "straight": steady_state(car, (0.0, 1.9), (1.9, 0.0, 0.0, 1.9)),
        "left": steady_state(car, left, (1.5, 0.0, 1.5, 1.5)),
        "right": steady_state(car, over * left, mirror * (1.5, 0.0, 1.5, 1.5)),
        "left drift": steady_state(car, drift, start),
        "right drift": steady_state(car, over * drift, mirror * start),
    }


def _search(car: Car, action: Floats, start: Floats) -> Equilibrium | None:
    def rate(state: Floats) -> Floats:
        return np.asarray(car.derivative(state[None], action[None])[0])

    state = root(rate, start, tol=1e-13).x
    if not np.isfinite(state).all():
        return None
    residual = float(np.abs(rate(state)).max())
    if not residual <= RESIDUAL:
        return None
    values = np.linalg.eigvals(jacobians(car, state, action)[0]).astype(complex)
    values = values[np.argsort(-values.real, kind="stable")]
    return Equilibrium(frozen(state), frozen(action), frozen(values), residual)
