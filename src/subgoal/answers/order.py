"""The order in which demonstrations first serve the places they are after: that of waypoints (thesis 4.5)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints

SEGMENT = 1 / 3
"""Of the observations of a usual segment, what makes it one and no stray."""


def first_served(
    demonstrations: Demonstrations,
    served: NDArray[np.integer[Any]],
    listed: Ints,
    shares: Floats,
    chances: sparse.csr_array,
) -> Ints:
    """``listed`` (L,) in the order in which they are first served; ``served`` (N,) says which each observation serves.

    A place is first served at the median step of its first segment in a trajectory, so that neither stray pairs nor
    later rounds count. A segment ends where others are served for as long as a usual run of its place, one that the
    median of its observations is in; it holds more than a third of the observations of a usual segment. A place that
    nothing serves, as its neighbour took its part in one draw, has the observations whose ``chances`` (N, L) of serving
    it are at least half the largest.

    Of two places that first is which comes first in most of the trajectories that have segments of both, whatever
    their lengths; where there are as many of the one kind as of the other, or none, that of the lesser median share
    of its trajectories gone by. The order is by the number of places that come later, then by that share, then by
    falling ``shares`` (L,).
    """
    lengths = np.diff(demonstrations.offset)
    step = np.arange(demonstrations.n_observations) - demonstrations.offset[:-1][demonstrations.trajectory]
    when = np.full((listed.size, lengths.size), np.nan)
    for k, place in enumerate(listed):
        own = np.flatnonzero(served == place)
        own = own if own.size else _likeliest(chances, k)
        for trajectory, middle in _first_segments(step[own], demonstrations.trajectory[own]):
            when[k, trajectory] = middle
    gone = np.array([_median((row + 0.5) / lengths) for row in when])
    later = np.array([_goes_before(when, gone, k) for k in range(listed.size)])
    return np.asarray(listed[np.lexsort((-shares, gone, -later))])


def _likeliest(chances: sparse.csr_array, k: int) -> Ints:
    """Rows at least half as likely as any to serve the place ``k``."""
    column = np.asarray(chances[:, [k]].todense()).ravel()
    return np.flatnonzero((column > 0) & (2 * column >= column.max(initial=0.0)))


def _goes_before(when: Floats, gone: Floats, k: int) -> int:
    """How many places come later than the place ``k``, of those first served at ``when`` (L, D)."""
    won = (when[k] < when).sum(axis=1) - (when[k] > when).sum(axis=1)
    return int(((won > 0) | ((won == 0) & (gone[k] < gone))).sum())


def _median(values: Floats) -> float:
    """Of what is a number; ∞ where nothing is."""
    known = values[~np.isnan(values)]
    return float(np.median(known)) if known.size else np.inf


def _first_segments(step: Ints, trajectory: Ints) -> Iterator[tuple[int, float]]:
    """Trajectories and the median step of the first segment of each, from steps (n,) in order."""
    if not step.size:
        return
    missed = np.where(np.diff(trajectory) > 0, np.inf, np.diff(step) - 1)
    runs = np.split(step, np.flatnonzero(missed > 0) + 1)
    begin = np.append(0, np.flatnonzero(missed >= max(_usual(runs), 1)) + 1)
    segments = np.split(step, begin[1:])
    least = SEGMENT * _usual(segments)
    long = np.flatnonzero([each.size > least for each in segments])
    own, first = np.unique(trajectory[begin[long]], return_index=True)
    for at, k in zip(own.tolist(), long[first].tolist(), strict=True):
        yield at, float(np.median(segments[k]))


def _usual(pieces: list[Ints]) -> float:
    """Half of the observations are in pieces at least this long."""
    sizes = np.array([each.size for each in pieces])
    return float(np.median(np.repeat(sizes, sizes)))
