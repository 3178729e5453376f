"""``Candidates``: the places or sets of states where a subgoal may lie, with their prior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from subgoal.demonstrations.metric import Metric
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array
from subgoal.runtime.errors import BudgetError, InputError

LEAST_LOG_PRIOR = -600.0
"""A smaller prior cannot be told from zero in the arithmetic of the samplers."""
MOST_GRID_POINTS = 1_000_000
ROUNDING = 1e-12
"""A prior that sums to one within this is left alone, so that normalising twice is normalising once."""


@dataclass(frozen=True, eq=False, repr=False)
class Candidates:
    """G places where a subgoal may lie, with their prior P(g).

    Attributes
    ----------
    points:
        (G, d) positions in the units of the states.
    log_prior:
        (G,) log P(g), normalised on the way in; uniform if not given.
    names:
        G labels that then stand in tables and pictures; empty if the places have none.
    radius:
        ε for nets, spacing for grids, 0 for named, tabular and feature places. Half of it counts as being there.
    metric:
        The distance used for nets, for "there", and for merging near-duplicates.
    goal_sets:
        G arrays of states of a discrete world: the subgoal is reached in any state of its set (thesis Definitions 1
        and 3). None for places in space.
    """

    points: Floats
    log_prior: Any = None
    names: tuple[str, ...] = ()
    radius: float = 0.0
    metric: Any = None
    goal_sets: Any = None

    def __post_init__(self) -> None:
        points = real_array("candidate points", self.points, ndim=(1, 2))
        points = frozen(points.reshape(-1, 1)) if points.ndim == 1 else points
        if not len(points):
            raise InputError("candidate points", found="none", wanted="at least one")
        metric = Metric.euclidean(points.shape[1]) if self.metric is None else self.metric
        if metric.dimension != points.shape[1]:
            raise InputError(
                "metric", found=f"{metric.dimension} dimensions", wanted=f"{points.shape[1]}, as the points"
            )
        names = tuple(str(name) for name in self.names)
        if names and len(names) != len(points):
            raise InputError("candidate names", found=f"{len(names)}", wanted=f"{len(points)}, one per point")
        if len(set(names)) < len(names):
            twice = next(name for k, name in enumerate(names) if name in names[:k])
            raise InputError("candidate names", found=f"{twice!r} twice", wanted="different names")
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "log_prior", _normalised(self.log_prior, len(points)))
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "radius", positive("candidate radius", self.radius, zero=True))
        object.__setattr__(self, "metric", metric)
        if self.goal_sets is not None:
            object.__setattr__(self, "goal_sets", _sets(self.goal_sets, len(points)))

    def __repr__(self) -> str:
        return f"Candidates({self.n_candidates} places in {self.points.shape[1]}-D, radius {self.radius:g})"

    @classmethod
    def from_points(
        cls, points: Any, names: Sequence[str] = (), log_prior: Any = None, *, radius: float = 0.0, metric: Any = None
    ) -> Candidates:
        """The user's own places, shape (G, d): exits, ports, waypoints, with names and prior if there are any."""
        return cls(points=points, names=tuple(names), log_prior=log_prior, radius=radius, metric=metric)

    @classmethod
    def from_states(
        cls, goals: Any, *, coordinates: Any = None, points: Any = None, names: Sequence[str] = (),
        log_prior: Any = None, radius: float = 0.0, metric: Metric | None = None,
    ) -> Candidates:  # fmt: skip
        """States, or sets of states, of a discrete world.

        Each lies at ``points`` (G, d) if given, else at the mean of the ``coordinates`` (S, d) of its states, else at
        its smallest state's number.
        """
        sets = _sets([np.atleast_1d(each) for each in goals], len(goals))
        if points is None and coordinates is None:
            points = np.array([[each[0]] for each in sets], float)
        elif points is None:
            table = real_array("coordinates", coordinates, ndim=2)
            last = max(int(each[-1]) for each in sets)
            if last >= len(table):
                raise InputError("goals", found=f"state {last}", wanted=f"a state of 0 to {len(table) - 1}")
            points = np.stack([table[each].mean(axis=0) for each in sets])
        return cls(points=points, names=tuple(names), log_prior=log_prior, radius=radius, metric=metric, goal_sets=sets)

    @classmethod
    def grid(cls, lower: Any, upper: Any, spacing: float, *, metric: Metric | None = None) -> Candidates:
        """A regular grid from ``lower`` to ``upper`` (d,), ``spacing`` apart in every dimension, first point at lower.

        Raises ``BudgetError`` above a million points.
        """
        low, high = real_array("lower", lower, ndim=1), real_array("upper", upper, ndim=1)
        step = positive("spacing", spacing)
        if low.shape != high.shape or not (low <= high).all():
            raise InputError("upper", found=f"{high}", wanted=f"as many numbers as lower, none below {low}")
        sizes = np.floor((high - low) / step + 1e-9) + 1
        if np.prod(sizes) > MOST_GRID_POINTS:
            raise BudgetError(
                "candidate grid",
                needed=float(np.prod(sizes)) * 8 * low.size,
                budget=MOST_GRID_POINTS * 8.0 * low.size,
                hint="a wider spacing",
            )
        axes = [lo + step * np.arange(int(n)) for lo, n in zip(low, sizes, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, low.size)
        return cls(points=points, radius=step, metric=metric)

    @property
    def n_candidates(self) -> int:
        """G."""
        return len(self.points)

    def some(self, kept: Any) -> Candidates:
        """Those of some rows, numbers or booleans, with the prior of them alone."""
        rows = np.arange(self.n_candidates)[kept]
        return replace(
            self, points=self.points[rows], log_prior=self.log_prior[rows],
            names=tuple(self.names[g] for g in rows) if self.names else (),
            goal_sets=None if self.goal_sets is None else tuple(self.goal_sets[g] for g in rows),
        )  # fmt: skip

    def name(self, g: int) -> str:
        """The label of candidate ``g``, or the empty string."""
        return self.names[g] if self.names else ""


def _normalised(log_prior: Any, count: int) -> Floats:
    if log_prior is None:
        return np.asarray(frozen(np.full(count, -np.log(count))))
    values = real_array("log_prior", log_prior, ndim=1)
    if values.shape != (count,):
        raise InputError("log_prior", found=f"shape {values.shape}", wanted=f"({count},), one per point")
    total = logsumexp(values)
    values = values - total if abs(total) > ROUNDING else values
    if values.min() < LEAST_LOG_PRIOR:
        g = int(np.argmin(values))
        raise InputError(
            "log_prior", where=f"candidate {g}", found=f"{values[g]:.6g} once normalised",
            wanted=f"at least {LEAST_LOG_PRIOR:g}", hint="leave out a candidate that is all but impossible",
        )  # fmt: skip
    return np.asarray(frozen(values))


def _sets(given: Any, count: int) -> tuple[Ints, ...]:
    """Each set as sorted states, none of them empty or negative."""
    arrays = [np.asarray(each) for each in given]
    if len(arrays) != count or not count:
        raise InputError("goal_sets", found=f"{len(arrays)} sets", wanted=f"{max(count, 1)}, one per candidate")
    for g, each in enumerate(arrays):
        if each.dtype.kind not in "iu" or each.ndim != 1 or not each.size or each.min() < 0:
            raise InputError("goal_sets", where=f"candidate {g}", found=f"{each.tolist()}"[:60],
                             wanted="states: whole numbers of at least 0, one or more")  # fmt: skip
    return tuple(frozen(np.unique(each.astype(np.int64))) for each in arrays)
