"""Fitted value iteration for many goals at once: one matrix product and one maximum a sweep.

Where an action leads does not depend on the goal, so that the weights W are made once for all goals and sweeps. Written
against the array API standard: NumPy by default, and the same code on the arrays of a GPU library.
"""

from __future__ import annotations

import enum
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from array_api_compat import array_namespace, is_numpy_array

from subgoal.gaussian.smoothers import Array
from subgoal.runtime.checks import Floats, positive, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

TOLERANCE = 1e-4
MOST_SWEEPS = 500
BLOCK = 2**18
"""Action values worked on at once in main memory, so that they stay in the cache."""
BLOWN_UP = 1e6
"""Values that change by this many times the largest reward are on their way to infinity."""


class IterationStatus(enum.Enum):
    """How value iteration ended; the value says it in words."""

    CONVERGED = "converged: values change by less than the tolerance"
    LIMIT = (
        "NOT CONVERGED: values still change after the last sweep. Try: a larger noise of the smoother, a longer step, "
        "more sweeps (most_sweeps), a shorter horizon, or Averager()"
    )
    STOPPED = "STOPPED: interrupted before values had settled"
    DIVERGED = "DIVERGED: values grow without bound. Try: a larger noise of the smoother, bounds, or Averager()"


@dataclass(frozen=True, eq=False)
class Further:
    """One more action for each support state and goal: its rewards (n, G) and weights (n, G, n)."""

    reward: Array
    weights: Array


@dataclass(frozen=True, eq=False)
class Iterated:
    """Values after the last sweep.

    Attributes
    ----------
    values:
        (n, G) in units of the reward, summed over the discounted future.
    best:
        (n, G) number of the action that is best.
    residuals:
        (sweeps,) largest change of a value in each sweep.
    status:
        How it ended.
    """

    values: Array
    best: Array
    residuals: Floats
    status: IterationStatus

    @property
    def residual(self) -> float:
        """Of the last sweep; zero where none was needed."""
        return float(self.residuals[-1]) if self.residuals.size else 0.0


def iterate_values(
    reward: Array,
    weights: Array,
    *,
    discount: float,
    bounds: tuple[float, float] | None = (0.0, 1.0),
    tolerance: float = TOLERANCE,
    most_sweeps: int = MOST_SWEEPS,
    start: Array | None = None,
    further: Further | None = None,
    progress: Progress | None = None,
) -> Iterated:
    """Sweeps V ← max_u [R + γ·clip(W V)] until no value changes by more than ``tolerance``.

    Parameters
    ----------
    reward:
        (n, m, G) reward of action u in support state i, for goal g.
    weights:
        (n, m, n) the value after it, as weights of the values at the support states; the same for all goals.
    discount:
        γ of one step, at least 0 and below 1.
    bounds:
        Between which values lie for certain; what W makes of them is clipped to these. None clips nothing.
    tolerance, most_sweeps:
        When to stop.
    start:
        (n, G) values to begin from; zero if None.
    further:
        Actions of their own for each state and goal, beside those that all goals share; never counted in ``best``.
    progress:
        Told of every sweep. Ctrl-C ends after the sweep in hand, with what there is then; the status says so.

    Notes
    -----
    If the rows of |W| sum to at most 1 the sweep is a contraction and values are within residual·γ/(1 − γ) of the fixed
    point. Otherwise nothing is proved: the residuals are watched, and the status says what they did (Deisenroth et al.
    2009 iterate in the same way, a Gaussian process at a time).
    """
    xp = array_namespace(reward, weights)
    _check(reward, weights, discount, bounds, positive("tolerance", tolerance), whole("most_sweeps", most_sweeps))
    n, _, goals = reward.shape
    values = xp.zeros((n, goals), dtype=reward.dtype, device=reward.device) if start is None else start
    top = BLOWN_UP * max(1e-300, float(xp.max(xp.abs(reward))))
    display = progress or Silent()
    residuals: list[float] = []
    status = IterationStatus.LIMIT
    how = discount, bounds
    with Interrupt() as interrupt, display:
        for sweep in range(most_sweeps):
            new = xp.concat([xp.max(worth, axis=1) for worth in _worth(reward, weights, values, *how)], axis=0)
            if further is not None:
                new = xp.maximum(new, _further_worth(further, values, *how))
            residuals.append(float(xp.max(xp.abs(new - values))))
            values = new
            display.update(sweep + 1, most_sweeps)
            if residuals[-1] <= tolerance:
                status = IterationStatus.CONVERGED
                break
            if not residuals[-1] <= top:
                status = IterationStatus.DIVERGED
                break
            if interrupt.requested:
                status = IterationStatus.STOPPED
                break
    best = xp.concat([xp.argmax(worth, axis=1) for worth in _worth(reward, weights, values, *how)], axis=0)
    return Iterated(values, best, np.array(residuals), status)


def _worth(
    reward: Array, weights: Array, values: Array, discount: float, bounds: tuple[float, float] | None
) -> Iterator[Array]:
    """Action values (rows, m, G) of some support states after others."""
    xp = array_namespace(reward, weights)
    n, m, goals = reward.shape
    rows = max(1, BLOCK // (m * goals)) if is_numpy_array(values) else n
    for first in range(0, n, rows):
        some = slice(first, min(first + rows, n))
        after = xp.reshape(xp.reshape(weights[some, ...], (-1, n)) @ values, (-1, m, goals))
        if bounds is not None:
            after = xp.clip(after, bounds[0], bounds[1])
        yield reward[some, ...] + discount * after


def _further_worth(further: Further, values: Array, discount: float, bounds: tuple[float, float] | None) -> Array:
    """(n, G) values of the further actions."""
    xp = array_namespace(values)
    after = (further.weights[:, :, None, :] @ values.T[None, :, :, None])[:, :, 0, 0]
    return further.reward + discount * (after if bounds is None else xp.clip(after, bounds[0], bounds[1]))


def _check(reward: Array, weights: Array, discount: float, bounds: Any, tolerance: float, sweeps: int) -> None:
    """Raise ``InputError`` for what cannot be iterated."""
    n, m = reward.shape[:2]
    if weights.shape != (n, m, n):
        raise InputError("weights", found=f"shape {tuple(weights.shape)}", wanted=f"({n}, {m}, {n}), as the reward")
    if not 0 <= discount < 1:
        raise InputError("discount", found=discount, wanted="at least 0 and below 1")
    if bounds is not None and not bounds[0] < bounds[1]:
        raise InputError("bounds", found=bounds, wanted="two numbers, the smaller first")
