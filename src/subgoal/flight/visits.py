"""Which subgoal was gone to after which, and how far the demonstrator turned on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from subgoal.answers.segments import OTHER, Segments
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints

TURN = 2 * np.pi


@dataclass(frozen=True)
class Visit:
    """Rows ``start`` to ``stop`` (excluded) of one trajectory, that serve subgoal ``subgoal`` (from 0)."""

    trajectory: int
    subgoal: int
    start: int
    stop: int


def visited_in_order(demonstrations: Demonstrations, cut: Segments, kept: int, stray: int) -> list[Visit]:
    """The segments of the first ``kept`` subgoals; neighbours of one subgoal are one visit.

    Those of fewer than ``stray`` observations and those of other subgoals are left out, and what they part is joined.
    """
    seen: list[Visit] = []
    for each in cut:
        if each.subgoal == OTHER or each.subgoal >= kept or each.stop - each.start < stray:
            continue
        if seen and seen[-1].subgoal == each.subgoal and seen[-1].trajectory == each.trajectory:
            seen[-1] = replace(seen[-1], stop=each.stop)
        else:
            seen.append(Visit(each.trajectory, each.subgoal, each.start, each.stop))
    return seen


def follows(seen: list[Visit], last: int, first: int) -> bool:
    """Whether the visits that come after one of ``last``, in the same trajectory, are mostly of ``first``."""
    after = [b.subgoal for a, b in pairwise(seen) if a.subgoal == last and a.trajectory == b.trajectory]
    return last != first and 2 * after.count(first) > len(after)


def turns_to(angles: Floats, offset: Ints, seen: list[Visit], order: Ints, wrapped: Floats) -> Floats:
    """(W,) the turns ``wrapped`` (W,) with the whole turns that the demonstrator made: the nearest to the median visit.

    ``angles`` (N,) are those of the demonstrations. What is turned during a visit is from its first row to its last.
    """
    rolled = np.concatenate([np.unwrap(angles[a:b]) for a, b in pairwise(offset.tolist())])
    made = np.array([rolled[visit.stop - 1] - rolled[visit.start] for visit in seen])
    to = np.array([visit.subgoal for visit in seen])
    usual = np.array([np.median(made[to == k]) if (to == k).any() else 0.0 for k in order])
    if order.size == to.size and (order == to).all():
        usual = made
    return np.asarray(wrapped + TURN * np.round((usual - wrapped) / TURN))
