"""Dynamics learned from demonstrations: what they say, how sure they are, and how wrong they were."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.learned_models import Model, Processes
from subgoal.dynamics.learned_pairs import WHOLE, inputs
from subgoal.dynamics.protocol import paired
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError

_SHIFT = 1e-4


@dataclass(frozen=True, eq=False)
class HeldOut:
    """How far predictions of one step were off where nothing was learned from.

    Attributes
    ----------
    error, persistence:
        (d,) root mean square error in the units of the states, and that of "the state stays as it is".
    share:
        (d,) the error over the standard deviation of the increments held out: 1 is no better than their mean.
    count:
        Transitions tested on; they overlap where the step spans several pairs.
    """

    error: Floats
    persistence: Floats
    share: Floats
    count: int

    @property
    def overall(self) -> float:
        """Root mean square of the shares, by which kinds are compared."""
        return float(np.sqrt(np.mean(self.share**2)))


@dataclass(frozen=True, eq=False, repr=False)
class LearnedDynamics:
    """A transition function learned from demonstrations, called like every other.

    A duration of several steps is the step repeated. A share of a step, left over at the end, is that share of the
    increment of a step; it is linear in time, and not exact even where the step is.

    Attributes
    ----------
    kind:
        "linear", "gp" or "neighbours".
    step:
        Duration of what was learned, in ``time_unit``.
    model:
        By how much a state changes in a step: ``Affine``, ``Neighbours`` or ``Processes``, learned from all
        transitions.
    metric:
        Its periods are those of the angles; the weights do not count.
    tried:
        Errors of each kind that was tried, learned from what was not held out.
    names, time_unit:
        As in the demonstrations.
    low:
        (d,) angles lie from here to one period above.
    n_actions:
        k.
    """

    kind: str
    step: float
    model: Model
    metric: Metric
    tried: dict[str, HeldOut]
    names: tuple[str, ...]
    time_unit: str
    low: Floats
    n_actions: int

    def __repr__(self) -> str:
        told = f"{self.kind}, a step is {self.step:g} {self.time_unit}"
        return f"{type(self).__name__}({told}, held-out error {self.held_out.overall:.1%} of what changes)"

    @property
    def held_out(self) -> HeldOut:
        """Errors of the kind that was taken."""
        return self.tried[self.kind]

    def __call__(self, states: Any, actions: Any, duration: float) -> Floats:
        """(B, d) the states after ``duration`` of held actions (B, k)."""
        at, held = self._checked(states, actions)
        for share in self._shares(duration):
            at = self._next(at, held, share)
        return np.array(at)

    def _shares(self, duration: Any) -> list[float]:
        """Whole steps, and what is left of one."""
        steps = positive("duration", duration, zero=True) / self.step
        count = int(steps + WHOLE)
        left = steps - count
        return [1.0] * count + ([left] if left > WHOLE else [])

    def _next(self, states: Floats, actions: Floats, share: float) -> Floats:
        moved = states + share * self.model.increments(inputs(self.metric, states, actions))
        turns = np.isfinite(self.metric.period)
        period = self.metric.period[turns]
        moved[:, turns] -= period * np.floor((moved[:, turns] - self.low[turns]) / period)
        return moved

    def _checked(self, states: Any, actions: Any) -> tuple[Floats, Floats]:
        pair = paired(states, actions)
        wanted = (len(self.names), self.n_actions)
        for what, values, width in zip(("states", "actions"), pair, wanted, strict=True):
            if values.shape[1] != width:
                raise InputError(what, found=f"shape {values.shape}", wanted=f"(B, {width}), as learned from")
        return pair


@dataclass(frozen=True, eq=False, repr=False)
class GaussianDynamics(LearnedDynamics):
    """Learned dynamics that know how sure they are."""

    model: Processes

    def variance(self, states: Any, actions: Any, duration: float) -> Floats:
        """(B, d) variances of the states after ``duration``: of what is not known of the mean, and of the noise.

        Over several steps errors are carried on by the slope of the mean (P ← J P Jᵀ + Q, J by differences), and a
        share of a step has that share of its variance.
        """
        at, held = self._checked(states, actions)
        spread = np.zeros((*at.shape, at.shape[1]))
        for k, share in enumerate(self._shares(duration)):
            if k:
                slope = self._slope(at, held, share)
                spread = slope @ spread @ slope.transpose(0, 2, 1)
            own = share * self.model.variances(inputs(self.metric, at, held))
            spread = spread + own[:, :, None] * np.eye(at.shape[1])
            at = self._next(at, held, share)
        return np.array(np.diagonal(spread, axis1=1, axis2=2))

    def _slope(self, states: Floats, actions: Floats, share: float) -> Floats:
        """(B, d, d) ∂ next / ∂ state by central differences."""
        d = states.shape[1]
        shifts = _SHIFT * np.maximum(self.model.scale, 1e-6) * np.eye(d)
        at = np.repeat(states, d, axis=0)
        both, held = np.tile(shifts, (len(states), 1)), np.repeat(actions, d, axis=0)
        rise = self.model.increments(inputs(self.metric, at + both, held))
        rise -= self.model.increments(inputs(self.metric, at - both, held))
        by_row = rise.reshape(-1, d, d) / (2 * np.diagonal(shifts)[:, None])
        return np.asarray(np.eye(d) + share * by_row.transpose(0, 2, 1))
