"""Transition rows of a grid world, written for the states that are asked for."""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def grid_rows(here, target, over, slip, moves, stay):
    """``offset`` (M·A + 1,), ``successor`` and ``probability`` of all actions of M states.

    ``target`` (M, moves) is where a step in each direction leads, the state itself of ``here`` (M,) where it is
    blocked; ``slip`` (moves + 1,) are the chances to go k directions clockwise of the chosen one, and not to move.
    States that are ``over`` (M,) have empty rows. What does not move comes last in its row.
    """
    n_actions = moves + 1 if stay else moves
    offset = np.zeros(here.size * n_actions + 1, np.int64)
    most = here.size * n_actions * (np.count_nonzero(slip[:moves]) + 1)
    successor, probability = np.empty(most, target.dtype), np.empty(most)
    entries = 0
    for i in range(here.size):
        for a in range(n_actions):
            if not over[i]:
                stays = 1.0 if a == moves else 0.0
                for k in range(moves):
                    if a == moves or slip[k] == 0.0:
                        continue
                    to = target[i, (a + k) % moves]
                    if to == here[i]:
                        stays += slip[k]
                    else:
                        successor[entries], probability[entries] = to, slip[k]
                        entries += 1
                if a < moves:
                    stays += slip[moves]
                if stays > 0.0:
                    successor[entries], probability[entries] = here[i], stays
                    entries += 1
            offset[i * n_actions + a + 1] = entries
    return offset, successor[:entries].copy(), probability[:entries].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def travel_bounds(x, y, goal_x, goal_y, slope_x, slope_y, out):
    """Write ``out`` (M, G): exp(−max_k w_k · (g − s)), one at most, for cells (x, y) and goals."""
    for i in range(x.size):
        for j in range(goal_x.size):
            dx, dy = goal_x[j] - x[i], goal_y[j] - y[i]
            most = 0.0
            for k in range(slope_x.size):
                most = max(most, slope_x[k] * dx + slope_y[k] * dy)
            out[i, j] = np.exp(-most)
