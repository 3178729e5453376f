"""What is drawn of large data: places, times and the rows that are shown."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.checks import Floats, Ints

MOST_SHOWN = 20_000


@dataclass(frozen=True, eq=False)
class Shown:
    """The part of the data that is drawn.

    Attributes
    ----------
    rows:
        (M,) rows of the data, in order.
    offset:
        (T+1,) start of each drawn trajectory in ``rows``.
    trajectory:
        (T,) which trajectories these are.
    note:
        A sentence if not everything is drawn, else empty.
    """

    rows: Ints
    offset: Ints
    trajectory: Ints
    note: str

    def paths(self, places: Floats, ends: Floats | None = None) -> list[Floats]:
        """The drawn points of each drawn trajectory, up to its end in ``ends`` (D, k) if given."""
        parts = [places[self.rows[a:b]] for a, b in pairwise(self.offset)]
        if ends is None:
            return parts
        return [np.vstack([part, ends[d]]) for part, d in zip(parts, self.trajectory, strict=True)]


def shown(offset: Ints, most: int = MOST_SHOWN) -> Shown:
    """All rows up to ``most``; above that every k-th of a trajectory with its last, and every k-th trajectory."""
    count = int(offset[-1])
    n_trajectories = len(offset) - 1
    skip = -(-4 * n_trajectories // most)
    chosen = np.arange(0, n_trajectories, max(1, skip if count > most else 1))
    lengths = np.diff(offset)[chosen]
    rows = np.repeat(offset[chosen], lengths) + _within(lengths)
    stride = max(1, -(-rows.size // (most - min(chosen.size, most // 2)))) if rows.size > most else 1
    last = np.zeros(rows.size, bool)
    last[np.cumsum(lengths) - 1] = True
    kept = (_within(lengths) % stride == 0) | last
    owner = np.repeat(np.arange(chosen.size), lengths)[kept]
    edges = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=chosen.size))])
    note = "" if kept.sum() == count else f"{kept.sum():,} of {count:,} observations drawn"
    return Shown(rows[kept], edges, chosen, note)


def _within(lengths: Ints) -> Ints:
    return np.arange(int(lengths.sum())) - np.repeat(np.cumsum(lengths) - lengths, lengths)


def places_of(data: Demonstrations | Recording) -> Floats:
    """(N, d) positions; coordinates or numbers of the states of a discrete world."""
    return data.positions if isinstance(data, Recording) else data.places


def ends_of(demonstrations: Demonstrations) -> Floats:
    """(D, d) where each trajectory ended."""
    return demonstrations.final_places


def clock_of(data: Demonstrations | Recording) -> tuple[Floats, str]:
    """(N,) time since the start of each trajectory and the label of its axis; steps where there is no clock."""
    starts = np.repeat(data.offset[:-1], np.diff(data.offset))
    if data.times is None:
        return np.asarray(np.arange(starts.size) - starts, float), "observation"
    times = np.asarray(data.times)
    return times - times[starts], f"time since the start [{data.time_unit}]"


def is_unordered(data: Demonstrations | Recording) -> bool:
    """Whether every trajectory is a single observation."""
    return bool((np.diff(data.offset) == 1).all())
