"""How fast one can get about in a grid at best, whatever its walls: an upper bound of E[γ^T] for any two cells.

For w in the plane let φ(s) = exp(−w·(g − s)). A step in direction e multiplies φ by exp(w·e), and by one if a wall is
in the way. If γ Σ_k p_k max(exp(w·e_k), 1) ≤ 1 for every action, γ^t φ(s_t) is a supermartingale for every policy in
every such world, so that E[γ^T] ≤ φ(s). The set W of such w is convex; the bound is exp(−max_{w ∈ W} w·(g − s)).
Without slip this is γ to the power of the number of king's moves.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from subgoal._kernels.grid_rows import travel_bounds
from subgoal.runtime.checks import Floats, Ints

DIRECTIONS = 64
"""Directions for which the best w is sought; for others the best of those found is a valid bound too."""
FANNED, ZOOMS = 33, 6
"""Angles of w that are tried about the best so far, and how often, ever nearer to it."""
LARGEST = 700.0
MARGIN = 1e-12
SAME = 1e-7


class TravelBound(NamedTuple):
    """(K, 2) some w of W, as two columns."""

    slope_x: Floats
    slope_y: Floats

    def __call__(self, cells: Ints, goals: Ints) -> Floats:
        """(M, G) upper bounds of E[γ^T] from cells (M, 2) to goals (G, 2)."""
        out = np.empty((len(cells), len(goals)))
        here, there = np.asarray(cells, float), np.asarray(goals, float)
        travel_bounds(here[:, 0], here[:, 1], there[:, 0], there[:, 1], self.slope_x, self.slope_y, out)
        return out


def travel_bound(directions: Ints, slip: tuple[float, ...], discount: float) -> TravelBound:
    """The bound of a grid with these steps (moves, 2), chances of ``GridWorld.slip`` and γ."""
    return _found(tuple(map(tuple, directions.tolist())), slip, discount)


@lru_cache(maxsize=64)
def _found(steps: tuple[tuple[int, int], ...], slip: tuple[float, ...], discount: float) -> TravelBound:
    directions = np.array(steps)
    angle = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    theta, spread = angle.copy(), np.pi / 2
    for _ in range(ZOOMS):
        tried = theta[:, None] + spread * np.linspace(-1, 1, FANNED)
        reach = _length(tried.ravel(), directions, slip, discount).reshape(tried.shape) * np.cos(tried - angle[:, None])
        theta, spread = tried[np.arange(DIRECTIONS), reach.argmax(axis=1)], 2 * spread / (FANNED - 1)
    length = _length(theta, directions, slip, discount)
    slopes = np.column_stack([length * np.cos(theta), length * np.sin(theta)])
    _, first = np.unique(np.round(slopes / max(SAME * length.max(), 1e-300)), axis=0, return_index=True)
    kept = slopes[np.sort(first)]
    return TravelBound(np.ascontiguousarray(kept[:, 0]), np.ascontiguousarray(kept[:, 1]))


def _length(theta: Floats, directions: Ints, slip: tuple[float, ...], discount: float) -> Floats:
    """How far W reaches in direction theta, a little less to be safe from rounding."""
    if discount == 0:
        return np.full(theta.shape, LARGEST / 2)
    unit = np.column_stack([np.cos(theta), np.sin(theta)]) @ directions.T
    low, high = np.zeros(theta.shape), np.full(theta.shape, LARGEST / 2)
    for _ in range(60):
        middle = (low + high) / 2
        fits = _growth(middle[:, None] * unit, slip) <= 1 / discount
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    return low * (1 - MARGIN)


def _growth(steps: Floats, slip: tuple[float, ...]) -> Floats:
    """(K,) max over actions of Σ_k p_k max(exp(w·e_k), 1) for w·e (K, moves)."""
    moves = steps.shape[1]
    grown = np.exp(np.maximum(steps, 0.0))
    rest = sum(slip[moves:])
    turned = np.stack([np.roll(grown, -a, axis=1) @ np.array(slip[:moves]) for a in range(moves)])
    return np.asarray(np.maximum(turned.max(axis=0) + rest, 1.0))
