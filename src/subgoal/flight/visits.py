"""Which subgoal was gone to after which, and how far the demonstrator turned on the way."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from subgoal.answers.segments import OTHER, Segments
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints

TURN = 2 * np.pi
LEAST_ROUND = 0.05
"""Loops count as no narrower than this."""


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


def in_this_order(seen: list[Visit], order: Ints) -> bool:
    """Whether some trajectory goes to the places of ``order``, one after another, whatever lies between."""
    wanted = order.tolist()
    for name in {visit.trajectory for visit in seen}:
        ahead = iter(visit.subgoal for visit in seen if visit.trajectory == name)
        if all(goal in ahead for goal in wanted):
            return True
    return False


def turns_to(angles: Floats, offset: Ints, seen: list[Visit], order: Ints, wrapped: Floats) -> Floats:
    """(W,) the turns ``wrapped`` (W,) with the whole turns that the demonstrator made: the nearest to the median visit.

    ``angles`` (N,) are those of the demonstrations. What is turned during a visit is from its first row to its last.
    """
    rolled = np.concatenate([np.unwrap(angles[a:b]) for a, b in pairwise(offset.tolist())])
    made = np.array([rolled[visit.stop - 1] - rolled[visit.start] for visit in seen])
    usual = _of_each(made, seen, order, 0.0)
    return np.asarray(wrapped + TURN * np.round((usual - wrapped) / TURN))


def roundness_of(positions: Floats, seen: list[Visit], order: Ints, turns: Floats) -> Floats:
    """(W,) how far the way of each visit swung out of its straight line, over what the arc of the turn does; at most 1.

    1 where positions (N, k) are not two, and where less than a quarter of a turn was made.
    """
    if positions.shape[1] != 2:
        return np.ones(order.size)
    made = np.array([_swing(positions[visit.start : visit.stop]) for visit in seen])
    arcs = np.tan(np.minimum(np.abs(turns), np.pi) / 4) / 2
    share = np.clip(_of_each(made, seen, order, np.inf) / np.maximum(arcs, 1e-9), LEAST_ROUND, 1.0)
    return np.where(np.abs(turns) < TURN / 4, 1.0, share)


def _swing(path: Floats) -> float:
    """Largest distance of (n, 2) from the line between its ends, over their distance; ∞ where they are one."""
    along = path[-1] - path[0]
    length = float(np.hypot(*along))
    aside = (path - path[0]) @ np.array([-along[1], along[0]])
    return float(np.abs(aside).max()) / length**2 if length > 0 else np.inf


def _of_each(values: Floats, seen: list[Visit], order: Ints, none: float) -> Floats:
    """(W,) the value (V,) of the visit itself where ``order`` is that of the visits, else the median over each place's.

    The first visit of a trajectory begins at no waypoint, and is left out where there are others; ``none`` where a
    place has no visit.
    """
    to = np.array([visit.subgoal for visit in seen])
    if order.size == to.size and (order == to).all():
        return values
    own = np.array([visit.trajectory for visit in seen])
    later = np.append(False, own[1:] == own[:-1])
    found = (values[(to == k) & (later | ~later[to == k].any())] for k in order)
    return np.array([np.median(each) if each.size else none for each in found])
