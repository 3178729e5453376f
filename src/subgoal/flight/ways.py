"""One way from rest to rest through places, within limits, and near the straight lines between them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from subgoal.flight.polynomials import Limits, Pieces, joined, minimum_snap, slack
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

HALVINGS = 3
"""How often a leg that leaves the straight line too far is halved, before the vehicle stops at its ends."""
MOST_LEGS = 12
"""Legs that are solved together."""
FITTED = 1.005
"""Limits are kept to this factor where derivatives are given, so that the path is not the same at another speed."""
Pinned = Mapping[int, Mapping[str, Any]]


def way(places: Floats, limits: Limits, bound: float, pinned: Pinned) -> tuple[Pieces, Floats, float]:
    """Through ``places`` (K, 3): the path, (K,) when it comes to each, and how far it leaves the straight lines."""
    parts: list[Pieces] = []
    reached, widest = [np.zeros(1)], 0.0
    legs = len(places) - 1
    edges = np.linspace(0, legs, -(-legs // MOST_LEGS) + 1).round().astype(np.int64).tolist()
    for a, b in pairwise(edges):
        own = {k - a: pinned[k] for k in range(a + 1, b) if k in pinned}
        part, times, apart = _solved(places[a : b + 1], limits, bound, own)
        reached.append(reached[-1][-1] + times[1:])
        parts.append(part)
        widest = max(widest, apart)
    return joined(parts), np.concatenate(reached), widest


def _solved(places: Floats, limits: Limits, bound: float, pinned: Pinned) -> tuple[Pieces, Floats, float]:
    """As ``way``, for a few legs."""
    halves = np.ones(len(places) - 1, np.int64)
    for _ in range(HALVINGS + 1):
        points, at = _with_points_between(places, halves)
        path, times = _paced(points, limits, {int(at[k]): pinned[k] for k in pinned})
        apart = _distances(path, places, times[at])
        if (apart <= bound).all() or len(places) == 2:
            return path, times[at], float(apart.max())
        halves = np.where(apart > bound, 2 * halves, halves)
    worst = int(np.argmax(apart))
    cut = worst if worst > 0 else 1
    if cut in pinned:
        raise InputError("constraints", where=f"waypoint {cut}", found=f"{apart.max():.2g} m beside the line",
                         wanted=f"at most {bound:g} m", hint="a larger overshoot=, or a smaller velocity")  # fmt: skip
    first = _solved(places[: cut + 1], limits, bound, {k: v for k, v in pinned.items() if k < cut})
    then = _solved(places[cut:], limits, bound, {k - cut: v for k, v in pinned.items() if k > cut})
    reached = np.append(first[1], first[1][-1] + then[1][1:])
    return joined([first[0], then[0]]), reached, max(first[2], then[2])


def _with_points_between(places: Floats, halves: Ints) -> tuple[Floats, Ints]:
    """Points with each leg cut into equal parts, and (K,) which of them are the places."""
    parts = [
        a + (b - a) * np.arange(count)[:, None] / count
        for a, b, count in zip(places[:-1], places[1:], halves.tolist(), strict=True)
    ]
    return np.vstack([*parts, places[-1:]]), np.append(0, np.cumsum(halves))


def _paced(points: Floats, limits: Limits, pinned: Pinned) -> tuple[Pieces, Floats]:
    """The path of minimum snap, as fast as the limits let it; times by length, more at both ends."""
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1) / limits.speed
    legs[[0, -1]] += limits.speed / limits.acceleration / 2
    times = np.append(0.0, np.cumsum(legs))
    for _ in range(12):
        path = minimum_snap(points, times, pinned)
        factor = slack(path, limits)
        if not pinned:
            return path.stretched(factor), times * factor
        if factor <= FITTED:
            return path, times
        times = times * factor
    raise InputError("constraints", found=f"{factor:.2g} times the limits of speed and acceleration",
                     wanted="derivatives that can be had within them")  # fmt: skip


def _distances(path: Pieces, places: Floats, reached: Floats) -> Floats:
    """(K − 1,) how far the path lies from the straight line of each leg, at most."""
    times = path.samples()
    here = path.at(times)[0]
    leg = np.clip(np.searchsorted(reached, times, side="right") - 1, 0, len(places) - 2)
    along = np.diff(places, axis=0)[leg]
    share = np.clip(((here - places[leg]) * along).sum(axis=1) / (along**2).sum(axis=1), 0, 1)
    gaps = np.linalg.norm(here - places[leg] - share[:, None] * along, axis=1)
    return np.array([gaps[leg == k].max() for k in range(len(places) - 1)])
