"""The order in which demonstrations first serve the places they are after: that of waypoints (thesis 4.5)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints

SEGMENT = 1 / 3
"""Of the observations of a usual segment, what makes it one and no stray."""


def first_served(
    demonstrations: Demonstrations, served: NDArray[np.integer[Any]], listed: Ints, shares: Floats
) -> Ints:
    """``listed`` (L,) in the order in which they are first served; ``served`` (N,) says which each observation serves.

    A place is first served at the median step of its first segment in a trajectory, so that neither stray pairs nor
    later rounds count. A segment ends where others are served for as long as a usual run of its place, one that the
    median of its observations is in; it holds more than a third of the observations of a usual segment. The order is
    that of the median over the trajectories that have such a segment; unused ones come last, by falling ``shares``
    (L,).
    """
    step = np.arange(demonstrations.n_observations) - demonstrations.offset[:-1][demonstrations.trajectory]
    rows = (np.flatnonzero(served == place) for place in listed)
    when = [_median_step(step[own], demonstrations.trajectory[own]) for own in rows]
    return np.asarray(listed[np.lexsort((-shares, np.array(when)))])


def _median_step(step: Ints, trajectory: Ints) -> float:
    """Median over trajectories of the median step of the first segment, from steps (n,) in order; ∞ for none."""
    if not step.size:
        return np.inf
    missed = np.where(np.diff(trajectory) > 0, np.inf, np.diff(step) - 1)
    runs = np.split(step, np.flatnonzero(missed > 0) + 1)
    begin = np.append(0, np.flatnonzero(missed >= max(_usual(runs), 1)) + 1)
    segments = np.split(step, begin[1:])
    least = SEGMENT * _usual(segments)
    long = np.flatnonzero([each.size > least for each in segments])
    _, first = np.unique(trajectory[begin[long]], return_index=True)
    return float(np.median([np.median(segments[k]) for k in long[first]]))


def _usual(pieces: list[Ints]) -> float:
    """Half of the observations are in pieces at least this long."""
    sizes = np.array([each.size for each in pieces])
    return float(np.median(np.repeat(sizes, sizes)))
