"""Loops over tiles of a likelihood table that add up along its columns (arrays named in the docstring are written)."""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit

NEGLIGIBLE = -745.0
"""e to this power is zero."""


@njit(cache=True, nogil=True)
def column_sums(tile, out):
    """Add each column of ``tile`` (B, G) to ``out`` (G,)."""
    for r in range(tile.shape[0]):
        for g in range(tile.shape[1]):
            out[g] += tile[r, g]


@njit(cache=True, nogil=True)
def column_ratios(tile, best, peak, total):
    """Go on with log Σ_i exp(ℓ_ig − ℓ_i,best) = peak_g + log total_g, for every column at once."""
    for r in range(tile.shape[0]):
        level = tile[r, best]
        for g in range(tile.shape[1]):
            value = tile[r, g] - level
            if value <= peak[g]:
                if value > -np.inf:
                    total[g] += exp(value - peak[g])
            else:
                total[g] = total[g] * exp(peak[g] - value) + 1.0
                peak[g] = value


@njit(cache=True, nogil=True)
def expected_counts(tile, log_weight, counts):
    """Add r_ig ∝ exp(ℓ_ig + log_weight_g), each row summing to one, to ``counts`` (G,); returns Σ_i log of the sums."""
    share = np.empty(tile.shape[1])
    whole = 0.0
    for r in range(tile.shape[0]):
        peak = -np.inf
        for g in range(share.size):
            share[g] = tile[r, g] + log_weight[g]
            peak = max(peak, share[g])
        if not peak > -np.inf:
            return -np.inf
        total = 0.0
        for g in range(share.size):
            gap = share[g] - peak
            share[g] = exp(gap) if gap > NEGLIGIBLE else 0.0
            total += share[g]
        for g in range(share.size):
            counts[g] += share[g] / total
        whole += peak + log(total)
    return whole
