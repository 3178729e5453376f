"""Gaussian-process dynamic programming (thesis 6.4) for every goal at once: the share of the future spent there."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from array_api_compat import array_namespace, is_numpy_array, to_device

from subgoal.gaussian.smoothers import Array, Smoothed, Smoother, squared_exponential
from subgoal.gaussian.value_iteration import MOST_SWEEPS, TOLERANCE, Further, IterationStatus, iterate_values
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.progress import Progress

LARGEST = 2**32
"""Bytes that weights and rewards may take."""
SHARE = (0.0, 1.0)
"""Of the future: between nothing and all of it."""


@dataclass(frozen=True, eq=False)
class Ahead:
    """Where test actions lead, in coordinates of the metric.

    Attributes
    ----------
    points:
        P arrays (q, e): the states passed within one step, the last one at its end.
    variance:
        (q, e) of the last one where the model is Gaussian, or None.
    """

    points: tuple[Array, ...]
    variance: Array | None = None

    def __len__(self) -> int:
        return int(self.points[-1].shape[0])

    def on(self, place: Callable[[Floats], Array]) -> Ahead:
        """The same, each array as ``place`` makes it of NumPy's."""
        return Ahead(tuple(place(at) for at in self.points), None if self.variance is None else place(self.variance))

    def some(self, rows: slice) -> Ahead:
        """Those of some rows."""
        return Ahead(
            tuple(at[rows, ...] for at in self.points), None if self.variance is None else self.variance[rows, ...]
        )


@dataclass(frozen=True, eq=False, repr=False)
class GoalValues:
    """Value functions of G goals: V_g(x), the share of the discounted future that can be spent at g from x.

    Attributes
    ----------
    support:
        (n, e) states at which values are known, in coordinates of the metric.
    goals:
        (G, e) where rewards R_g(x) = exp(−‖x − g‖²/(2·width²)) lie (thesis 6.1, with one point each).
    values:
        (n, G) in [0, 1].
    best:
        (n, G) number of the best test action at each support state.
    smoother, width, discount:
        W, the width of rewards in units of the metric, and γ of one step.
    gain:
        Largest sum of absolute weights of a row of W: above 1/γ convergence is observed, not proved.
    residuals, status:
        Of value iteration.
    """

    support: Array
    goals: Array
    values: Array
    best: Array
    smoother: Smoother
    width: float
    discount: float
    gain: float
    residuals: Floats
    status: IterationStatus

    def __repr__(self) -> str:
        n, goals = self.values.shape
        return f"GoalValues({goals} goals on {n} support states, {self.status.name}, residual {self.residual:.1e})"

    @property
    def residual(self) -> float:
        """Largest change of a value in the last sweep."""
        return float(self.residuals[-1]) if self.residuals.size else 0.0

    @property
    def error_bound(self) -> float:
        """No value at a support state is farther from the fixed point; infinity where W may amplify."""
        return self.residual * self.discount / (1 - self.discount) if self.smoother.contracts else math.inf

    def values_at(self, at: Array) -> Array:
        """(q, G) values at states (q, e)."""
        return array_namespace(at).clip(self._smoothed(at, None), *SHARE)

    def action_values(self, ahead: Ahead) -> Array:
        """(q, G) values Q = (1 − γ)·R + γ·V of the actions that lead to ``ahead``: one step of look-ahead."""
        after = array_namespace(self.values).clip(self._smoothed(ahead.points[-1], ahead.variance), *SHARE)
        return (1 - self.discount) * rewards(ahead, self.goals, self.width) + self.discount * after

    @cached_property
    def _smoothed(self) -> Smoothed:
        return self.smoother.through(self.support, self.values)

    def only(self, goals: Any) -> GoalValues:
        """The same of some goals."""
        return replace(self, goals=self.goals[goals, ...], values=self.values[:, goals], best=self.best[:, goals])


def in_main_memory(plan: GoalValues) -> GoalValues:
    """The same with NumPy arrays, wherever it was planned."""
    if is_numpy_array(plan.values):
        return plan
    found: dict[str, Any] = {name: _numpy(getattr(plan, name)) for name in ("support", "goals", "values", "best")}
    return replace(plan, **found)


def _numpy(array: Array) -> Any:
    try:
        return np.asarray(array)
    except TypeError:
        return np.asarray(to_device(array, "cpu"))


def rewards(ahead: Ahead, goals: Array, width: float) -> Array:
    """(q, G) mean reward over the points of a step; its expectation at the end, where the model is Gaussian."""
    last = squared_exponential(ahead.points[-1], goals, width, ahead.variance)
    passed = [squared_exponential(at, goals, width) for at in ahead.points[:-1]]
    return sum(passed, start=last) / len(ahead.points)


def plan_goals(
    support: Array,
    goals: Array,
    ahead: Ahead,
    *,
    smoother: Smoother,
    width: float,
    discount: float,
    tolerance: float = TOLERANCE,
    most_sweeps: int = MOST_SWEEPS,
    start: Array | None = None,
    further: Further | None = None,
    progress: Progress | None = None,
) -> GoalValues:
    """Values of every goal at every support state, thesis Algorithm 5 lines 8-10 with one weight matrix for all.

    Parameters
    ----------
    support, goals:
        (n, e) and (G, e), in coordinates of the metric.
    ahead:
        Where each of m test actions leads from each support state: (n·m, e), the actions of a state together.
    smoother:
        ``GaussianSmoother`` or ``Averager``.
    width, discount:
        Of the rewards, in units of the metric; γ of one step.
    tolerance, most_sweeps, start, further, progress:
        As in ``iterate_values``.

    Not converging does not raise: ``status`` says so. Raises ``InputError`` for shapes that do not fit and support
    states that cannot be told apart, ``BudgetError`` above 4 GiB.
    """
    xp = array_namespace(support, goals)
    n = support.shape[0]
    actions, rest = divmod(len(ahead), n)
    if rest or not actions:
        raise InputError("ahead", found=f"{len(ahead)} states", wanted=f"a multiple of {n}, one for each test action")
    needed = 8.0 * n * actions * (n + goals.shape[0])
    if needed > LARGEST:
        raise BudgetError("weights and rewards", needed=needed, budget=LARGEST,
                          hint="fewer support states (a larger radius), or fewer test actions")  # fmt: skip
    weights = smoother.weights(support, ahead.points[-1], ahead.variance)
    reward = (1 - discount) * rewards(ahead, goals, positive("width", width))
    found = iterate_values(
        xp.reshape(reward, (n, actions, -1)), xp.reshape(weights, (n, actions, n)), discount=discount,
        tolerance=tolerance, most_sweeps=most_sweeps, start=start, further=further, progress=progress,
    )  # fmt: skip
    gain = float(xp.max(xp.sum(xp.abs(weights), axis=1)))
    return GoalValues(
        support, goals, found.values, found.best, smoother, width, discount, gain, found.residuals, found.status
    )
