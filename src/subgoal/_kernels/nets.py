"""Greedy ε-net over points that come in order, with a spatial hash."""

import math
from typing import Any

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def _cell(value: float, origin: float, width: float, cells: int) -> int:
    """Cell of one coordinate; ``cells`` > 0 is the number around a period, 0 means the axis does not wrap."""
    if cells > 0:
        period = width * cells
        return min(int((value - period * math.floor(value / period)) / width), cells - 1)
    return math.floor((value - origin) / width)


@njit(cache=True, nogil=True)
def _bucket(a: int, b: int, c: int, mask: int) -> Any:
    """Bucket of a cell; different cells may share one, which costs time and nothing else."""
    return (a * 73856093 ^ b * 19349663 ^ c * 83492791) & mask


@njit(cache=True, nogil=True)
def _distance(points: Any, i: int, j: int, weights: Any, period: Any) -> float:
    """Weighted distance of two rows, the shorter way round on axes of finite period."""
    total = 0.0
    for k in range(points.shape[1]):
        step = points[i, k] - points[j, k]
        if period[k] < np.inf:
            step -= period[k] * np.rint(step / period[k])
        step *= weights[k]
        total += step * step
    return math.sqrt(total)


@njit(cache=True, nogil=True)
def greedy_net(
    points: Any, order: Any, n_first: int, radius: float, weights: Any, period: Any,
    axes: Any, origin: Any, width: Any, cells: Any, mask: int,
) -> Any:  # fmt: skip
    """Rows of ``points`` kept, going through ``order``: those farther than ``radius`` from all kept before.

    points (M,d); order (M',) rows, the first ``n_first`` of which are kept unless at distance 0 of a kept one;
    weights, period (d,) as in Metric; axes (3,) the axes that are hashed, −1 for none; origin, width, cells (3,)
    the hash grid in unweighted units, no cell narrower than the radius; mask = number of buckets − 1.
    Returns int64 (K,), in the order kept.
    """
    head = np.full(mask + 1, -1, np.int64)
    chain = np.empty(order.size, np.int64)
    kept = np.empty(order.size, np.int64)
    count = 0
    at = np.zeros(3, np.int64)
    for position in range(order.size):
        i = order[position]
        limit = 0.0 if position < n_first else radius
        for h in range(3):
            if axes[h] >= 0:
                at[h] = _cell(points[i, axes[h]], origin[h], width[h], cells[h])
        covered = False
        for da in range(-1 if axes[0] >= 0 else 0, 2 if axes[0] >= 0 else 1):
            a = (at[0] + da) % cells[0] if cells[0] > 0 else at[0] + da
            for db in range(-1 if axes[1] >= 0 else 0, 2 if axes[1] >= 0 else 1):
                b = (at[1] + db) % cells[1] if cells[1] > 0 else at[1] + db
                for dc in range(-1 if axes[2] >= 0 else 0, 2 if axes[2] >= 0 else 1):
                    c = (at[2] + dc) % cells[2] if cells[2] > 0 else at[2] + dc
                    j = head[_bucket(a, b, c, mask)]
                    while j >= 0 and not covered:
                        covered = _distance(points, i, kept[j], weights, period) <= limit
                        j = chain[j]
                    if covered:
                        break
                if covered:
                    break
            if covered:
                break
        if not covered:
            slot = _bucket(at[0], at[1], at[2], mask)
            kept[count] = i
            chain[count] = head[slot]
            head[slot] = count
            count += 1
    return kept[:count].copy()
