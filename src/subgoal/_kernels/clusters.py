"""Clusters with their candidate summed out: m(C) = Σ_g p_g Π_{i∈C} L_ig from cached sums of logs. Arrays are written.

Of each cluster are held ``sums`` (G,) of its finite ℓ[i, g] and ``walls`` (G,), how many of its ℓ[i, g] are −inf, so
that a row can be taken away again; and its ``share`` (G,) ∝ p_g Π L_ig, packed to the candidates in ``support``.
Then m(C with i)/m(C) = Σ_g share_g L_ig.
"""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit

NEGLIGIBLE = -60.0
"""Shares below e^−60 of the largest vanish in the last binary digit of any sum."""


@njit(cache=True, nogil=True)
def add_row(row, sign, sums, walls):
    """Add (``sign`` 1) or take away (−1) a row of the table."""
    for g in range(row.size):
        if row[g] == -np.inf:
            walls[g] += sign
        else:
            sums[g] += sign * row[g]


@njit(cache=True, nogil=True)
def share_candidates(sums, walls, log_prior, share, support):
    """Write ``share`` and ``support``; returns how many candidates they hold and log m(C).

    Of an impossible cluster these are 0 and −inf.
    """
    peak = -np.inf
    for g in range(sums.size):
        if walls[g] == 0:
            peak = max(peak, sums[g] + log_prior[g])
    if peak == -np.inf:
        return 0, -np.inf
    count = 0
    total = 0.0
    for g in range(sums.size):
        below = sums[g] + log_prior[g] - peak
        if walls[g] == 0 and below > NEGLIGIBLE:
            share[count] = exp(below)
            support[count] = g
            total += share[count]
            count += 1
    for j in range(count):
        share[j] /= total
    return count, peak + log(total)


@njit(cache=True, nogil=True)
def relative_gain(count, share, support, relative):
    """m(C with i)/m(C), over m({i}): from one row (G,) of L_ig / Σ_g p_g L_ig."""
    gain = 0.0
    for j in range(count):
        gain += share[j] * relative[support[j]]
    return gain
