"""Thinning by a greedy ε-net: few points, none of the rest farther than a radius from them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints, positive, real_array
from subgoal.runtime.errors import InputError

HASHED_AXES = 3
"""At most this many axes are hashed: 27 neighbouring cells are looked at."""
FINEST_GRID = 2**20
"""At most this many cells along an axis, so that cell numbers stay small integers."""


def epsilon_net_indices(points: Any, radius: float, metric: Metric, first: Any = None) -> Ints:
    """Rows that form a greedy ε-net of the points, in the order they were kept (thesis Alg. 5, lines 2-7).

    Parameters
    ----------
    points:
        (M, d) places, gone through in order; a place is kept if it is farther than ``radius`` from all kept ones.
    radius:
        ε ≥ 0 in the metric's weighted units. Zero keeps every distinct place once.
    metric:
        Weights and periods of the d dimensions.
    first:
        Row numbers that come first and are kept whatever the radius (ends of trajectories); only those at
        distance 0 of an earlier one collapse into it.

    Returns
    -------
    int64 (K,) row numbers.

    Raises
    ------
    InputError
        Wrong shape, NaN or infinity, a radius below 0, row numbers that do not exist.
    """
    points = real_array("points", points, ndim=2)
    radius = positive("radius", radius, zero=True)
    if metric.dimension != points.shape[1]:
        raise InputError("metric", found=f"{metric.dimension} dimensions", wanted=f"{points.shape[1]} as the points")
    if not len(points):
        return np.empty(0, np.int64)
    head = _first_rows(first, len(points))
    rest = np.ones(len(points), bool)
    rest[head] = False
    order = np.concatenate([head, np.flatnonzero(rest)])
    from subgoal._kernels.nets import greedy_net

    grid = _hash_grid(points, radius, metric)
    mask = 2 ** int(np.clip(np.ceil(np.log2(len(points))), 4, 22)) - 1
    kept: Ints = greedy_net(points, order, len(head), radius, metric.weights, metric.period, *grid, mask)
    return kept


def thin(demos: Demonstrations, radius: float, metric: Metric | None = None) -> Demonstrations:
    """Within each trajectory, drop a pair when its state is within ``radius`` of one already kept (thesis 8.1.2).

    ``radius`` ≥ 0 in the units of the states (of the metric, if given). Trajectory ends (``final_states``) stay as
    they are, and so does the first pair of every trajectory. Counts go to ``source.notes``.

    Raises
    ------
    InputError
        The states are those of a discrete world, or the radius is below 0.
    """
    if demos.states.ndim != 2:
        raise InputError("demos", found="states of a discrete world", wanted="coordinates, shape (N, d)")
    metric = Metric.euclidean(demos.states.shape[1]) if metric is None else metric
    kept = [
        start + np.sort(epsilon_net_indices(demos.states[start:end], radius, metric))
        for start, end in zip(demos.offset[:-1], demos.offset[1:], strict=True)
    ]
    rows = np.concatenate(kept)
    dropped = demos.n_observations - len(rows)
    return replace(
        demos,
        states=demos.states[rows],
        actions=demos.actions[rows],
        offset=np.concatenate([[0], np.cumsum([len(k) for k in kept])]),
        times=None if demos.times is None else demos.times[rows],
        source=demos.source.noting(pairs_dropped_by_thinning=dropped, pairs_kept_by_thinning=len(rows)),
    )


def _first_rows(first: Any, count: int) -> Ints:
    """``first`` as distinct row numbers, in the order given."""
    if first is None:
        return np.empty(0, np.int64)
    rows = np.asarray(first)
    if rows.ndim != 1 or (rows.size and rows.dtype.kind not in "iu"):
        raise InputError("first", found=f"{rows.dtype} of shape {rows.shape}", wanted="row numbers, shape (F,)")
    rows = rows.astype(np.int64)
    bad = (rows < 0) | (rows >= count)
    if bad.any():
        k = int(np.argmax(bad))
        raise InputError("first", where=f"index {k}", found=int(rows[k]), wanted=f"a row from 0 to {count - 1}")
    return rows[np.sort(np.unique(rows, return_index=True)[1])]


def _hash_grid(points: Floats, radius: float, metric: Metric) -> tuple[Ints, Floats, Floats, Ints]:
    """Axes (−1: none), origin, cell width and cells around a period of the hashed axes, each of shape (3,)."""
    with np.errstate(over="ignore"):
        extent = np.minimum(np.ptp(points, axis=0), metric.period)
        squared = (extent * metric.weights) ** 2
    if not np.isfinite(squared).all():
        raise InputError("points", found="coordinates too far apart", wanted="differences whose square is finite")
    axes = np.full(HASHED_AXES, -1)
    widest = np.argsort(-extent * metric.weights, kind="stable")[:HASHED_AXES]
    axes[: len(widest)] = widest
    origin, width, cells = np.zeros(HASHED_AXES), np.ones(HASHED_AXES), np.zeros(HASHED_AXES, np.int64)
    for h, k in enumerate(widest):
        origin[h] = points[:, k].min()
        span = metric.period[k] if np.isfinite(metric.period[k]) else extent[k]
        width[h] = max(1.001 * radius / metric.weights[k], span / FINEST_GRID, np.finfo(float).tiny)
        if np.isfinite(metric.period[k]):
            cells[h] = max(1, int(metric.period[k] / width[h]))
            width[h] = metric.period[k] / cells[h]
    return axes, origin, width, cells
