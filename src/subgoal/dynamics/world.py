"""A continuous world: dynamics, the actions there are, and how often one decides."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.protocol import Dynamics, checked_dynamics
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import Ahead
from subgoal.runtime.checks import Floats, frozen, positive, real_array, whole
from subgoal.runtime.errors import BudgetError, InputError

PER_AXIS = {1: 33, 2: 9, 3: 5}
"""Test actions along each dimension, by the number of dimensions; three for more."""
MOST_TEST_ACTIONS = 100_000
STEPS_AHEAD = 5


@dataclass(frozen=True, eq=False, repr=False)
class ContinuousWorld:
    """Where held actions lead, and which there are to choose from.

    Attributes
    ----------
    dynamics:
        (states (B, d), actions (B, k), duration) -> (B, d), as ``Dynamics``. If it has a method ``variance`` of the
        same arguments, (B, d), and ``gaussian`` is True, where an action leads is a normal law.
    low, high:
        (k,) bounds of the actions.
    step:
        Time between two decisions, in the unit of the dynamics.
    horizon:
        τ, how far ahead one looks: γ = exp(−step/τ). The same unit; five steps by default.
    test_actions:
        (m, k) actions that are compared; by default a regular grid over the bounds, ends included.
    points:
        At how many evenly spaced moments of a step the reward is taken, the last at its end.
    gaussian:
        Whether to use the variances of the dynamics, if it has any.
    """

    dynamics: Dynamics
    low: Any
    high: Any
    step: float
    horizon: Any = None
    test_actions: Any = None
    points: int = 2
    gaussian: bool = False

    def __post_init__(self) -> None:
        low, high = real_array("low", self.low, ndim=1), real_array("high", self.high, ndim=1)
        if low.shape != high.shape or not (low < high).all():
            raise InputError("bounds of the actions", found=f"{low} to {high}", wanted="one below the other throughout")
        for name, value in (("low", low), ("high", high)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "step", positive("step", self.step))
        horizon = STEPS_AHEAD * self.step if self.horizon is None else self.horizon
        object.__setattr__(self, "horizon", positive("horizon", horizon))
        object.__setattr__(self, "points", whole("points", self.points))
        actions = action_grid(low, high) if self.test_actions is None else self.test_actions
        actions = real_array("test_actions", actions, ndim=2)
        if len(actions) < 2 or actions.shape[1] != low.size or (actions < low).any() or (actions > high).any():
            raise InputError("test_actions", found=f"shape {actions.shape}",
                             wanted=f"two or more rows of {low.size} numbers within the bounds")  # fmt: skip
        object.__setattr__(self, "test_actions", actions)
        if self.gaussian and not callable(getattr(self.dynamics, "variance", None)):
            raise InputError(
                "gaussian", found=True, wanted="dynamics with a method variance(states, actions, duration)"
            )

    def __repr__(self) -> str:
        told = f"{len(self.test_actions)} test actions, decides every {self.step:g}, looks {self.horizon:g} ahead"
        return f"ContinuousWorld({getattr(self.dynamics, '__name__', self.dynamics)}, {told})"

    @property
    def discount(self) -> float:
        """γ of one step."""
        return math.exp(-self.step / self.horizon)

    @property
    def log_volume(self) -> float:
        """Log of the volume of the actions between the bounds."""
        return float(np.log(self.high - self.low).sum())

    def after(self, states: Floats, actions: Floats) -> Floats:
        """(B, d) the states one step after actions (B, k) in states (B, d)."""
        return self._passed(states, actions)[-1]

    def _passed(self, states: Floats, actions: Floats) -> list[Floats]:
        """The states at the ``points`` moments of a step, each from its beginning: what was learned of whole steps is
        not put together from parts of one.
        """
        moments = self.step * np.arange(1, self.points + 1) / self.points
        return [checked_dynamics(self.dynamics, states, actions, float(moment)) for moment in moments]

    def ahead(self, states: Floats, actions: Floats, metric: Metric) -> Ahead:
        """Where each action (B, k) leads from its state (B, d), in coordinates of the metric."""
        passed = [coordinates(metric, at) for at in self._passed(states, actions)]
        if not self.gaussian:
            return Ahead(tuple(passed))
        if np.isfinite(metric.period).any():
            raise InputError("gaussian", found="angles that wrap", wanted="dimensions that do not",
                             hint="gaussian=False, which takes the mean of the model")  # fmt: skip
        law: Any = self.dynamics
        spread: Floats = np.asarray(law.variance(states, actions, self.step), float)
        if spread.shape != states.shape or not (spread >= 0).all():
            raise InputError("variance of the dynamics", found=f"shape {spread.shape}, least {spread.min():g}",
                             wanted=f"numbers of at least 0 of shape {states.shape}")  # fmt: skip
        return Ahead(tuple(passed), spread * metric.weights**2)

    def ahead_of_tests(self, states: Floats, metric: Metric) -> Ahead:
        """Where every test action leads from every state (B, d): (B·m, e), the actions of a state together."""
        m = len(self.test_actions)
        return self.ahead(np.repeat(states, m, axis=0), np.tile(self.test_actions, (len(states), 1)), metric)


def action_grid(low: Any, high: Any, per_axis: int | None = None) -> Floats:
    """(m, k) a regular grid of actions over the bounds (k,), ends included; the last dimension varies fastest.

    By default 33, 9 × 9, 5 × 5 × 5, or three for each dimension. Raises ``BudgetError`` above 100,000 actions.
    """
    low, high = real_array("low", low, ndim=1), real_array("high", high, ndim=1)
    number = PER_AXIS.get(low.size, 3) if per_axis is None else whole("per_axis", per_axis, least=2)
    if number**low.size > MOST_TEST_ACTIONS:
        raise BudgetError("test actions", needed=8.0 * number**low.size * low.size, budget=8.0 * MOST_TEST_ACTIONS,
                          hint="fewer along each dimension, or test_actions of your own")  # fmt: skip
    axes = [np.linspace(a, b, number) for a, b in zip(low, high, strict=True)]
    return np.asarray(frozen(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, low.size)))
