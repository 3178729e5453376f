"""Where subgoals may lie: visited states, an ε-net of them, a grid, or the user's own named places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import logsumexp

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.demonstrations.thinning import epsilon_net_indices
from subgoal.runtime.checks import Floats, frozen, positive, real_array
from subgoal.runtime.errors import BudgetError, InputError, ReadError

DEFAULT_NET = 0.03
LEAST_LOG_PRIOR = -600.0
"""A smaller prior cannot be told from zero in the arithmetic of the samplers."""
MOST_GRID_POINTS = 1_000_000
SEPARATORS = (",", ";", "\t", "|")
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
    """

    points: Floats
    log_prior: Any = None
    names: tuple[str, ...] = ()
    radius: float = 0.0
    metric: Any = None

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

    def __repr__(self) -> str:
        return f"Candidates({self.n_candidates} places in {self.points.shape[1]}-D, radius {self.radius:g})"

    @classmethod
    def from_points(
        cls, points: Any, names: Sequence[str] = (), log_prior: Any = None, *, radius: float = 0.0, metric: Any = None
    ) -> Candidates:
        """The user's own places, shape (G, d): exits, ports, waypoints, with names and prior if there are any."""
        return cls(points=points, names=tuple(names), log_prior=log_prior, radius=radius, metric=metric)

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

    def name(self, g: int) -> str:
        """The label of candidate ``g``, or the empty string."""
        return self.names[g] if self.names else ""


def epsilon_net(
    demonstrations: Demonstrations, radius: float | None = None, *, metric: Metric | None = None
) -> Candidates:
    """Visited places no closer than ``radius`` to each other (thesis Alg. 5 lines 2-7), every end point among them.

    ``radius`` None is 3 % of the largest extent of the states in the metric.
    """
    places = np.vstack([demonstrations.final_states, _continuous(demonstrations)])
    metric = Metric.euclidean(places.shape[1]) if metric is None else metric
    if radius is None:
        radius = DEFAULT_NET * float((np.ptp(places, axis=0) * metric.weights).max())
    radius = positive("radius", radius, zero=True)
    ends = np.arange(demonstrations.n_trajectories)
    return Candidates(points=places[epsilon_net_indices(places, radius, metric, ends)], radius=radius, metric=metric)


def visited(demonstrations: Demonstrations, *, metric: Metric | None = None) -> Candidates:
    """Every visited place once (thesis Proposition 1), end points included."""
    places = np.vstack([demonstrations.final_states, _continuous(demonstrations)])
    return Candidates(points=np.unique(places, axis=0), metric=metric)


def read_candidates(path: str | Path, position: Sequence[str], *, metric: Metric | None = None) -> Candidates:
    """Places from a CSV file: the ``position`` columns, optionally ``name`` and ``log_prior`` (or ``prior``) columns.

    Raises ``ReadError`` for a file that is not such a table.
    """
    import pandas as pd

    try:
        with Path(path).open(encoding="utf-8-sig") as stream:
            separator = max(SEPARATORS, key=stream.readline().count)
        table = pd.read_csv(path, sep=separator, encoding="utf-8-sig")
    except (OSError, ValueError) as problem:
        raise ReadError("candidates file", found=str(problem), wanted="a readable CSV table", where=str(path)) from None
    if not isinstance(table.index, pd.RangeIndex):
        raise ReadError("candidates file", where=str(path), found="rows longer than the header",
                        wanted="as many fields as columns")  # fmt: skip
    missing = [name for name in position if name not in table.columns]
    if missing:
        raise ReadError(
            "candidates file",
            where=str(path),
            found=f"columns {list(table.columns)}",
            wanted=f"columns {list(position)}",
        )
    prior = None
    if "log_prior" in table.columns:
        prior = table["log_prior"].to_numpy()
    elif "prior" in table.columns:
        given = real_array("column prior", table["prior"].to_numpy(), ndim=1)
        if not (given > 0).all():
            row = int(np.argmax(~(given > 0)))
            raise ReadError("column prior", where=f"row {row} of {path}", found=given[row], wanted="numbers above 0")
        prior = np.log(given)
    names = tuple(table["name"].astype(str)) if "name" in table.columns else ()
    return Candidates(points=table[list(position)].to_numpy(), names=names, log_prior=prior, metric=metric)


def _continuous(demonstrations: Demonstrations) -> Floats:
    states = np.asarray(demonstrations.states)
    if states.ndim != 2:
        raise InputError("demonstrations", found="discrete states", wanted="positions (N, d)")
    return states


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
