"""Loops over a likelihood table for the convex weights: scaled rows, gradients, what screening needs."""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

OBSERVATIONS = 256
"""In one block of ``curvature``."""


@njit(cache=True, nogil=True)
def row_peaks(tile, out):
    """Write ``out`` (B,): the largest entry of each row; NaN if there is one, or if +inf stands there."""
    for r in range(tile.shape[0]):
        peak, broken = -np.inf, False
        for g in range(tile.shape[1]):
            value = tile[r, g]
            broken = broken or np.isnan(value)
            peak = max(peak, value)
        out[r] = np.nan if broken or peak == np.inf else peak


@njit(cache=True, nogil=True)
def scaled_columns(tile, peak, start, out):
    """Write exp(tile − peak) (B, G), turned, into columns start..start+B of ``out`` (G, N)."""
    for g in range(tile.shape[1]):
        for r in range(tile.shape[0]):
            out[g, start + r] = exp(tile[r, g] - peak[r])


@njit(cache=True, nogil=True)
def spread_of_rows(columns, inverse, squares, largest, first, stop):
    """Write Σ_i A² and max_i A of A = columns·inverse for rows first..stop of ``columns`` (G, N)."""
    for g in range(first, stop):
        total, peak = 0.0, 0.0
        for i in range(inverse.size):
            ratio = columns[g, i] * inverse[i]
            total += ratio * ratio
            peak = max(peak, ratio)
        squares[g] = total
        largest[g] = peak


@njit(cache=True, nogil=True, fastmath={"reassoc", "contract"})
def curvature(columns, inverse, first, stop, out, slope):
    """Add AAᵀ (s, s) and A1 (s,) of A = columns·inverse, observations first..stop of ``columns`` (s, N).

    Blocks of observations stay in cache; two by two rows of A are gone through together.
    """
    s = columns.shape[0]
    even = s + s % 2
    ratio = np.zeros((even, OBSERVATIONS))
    whole = np.zeros((even, even))
    for start in range(first, stop, OBSERVATIONS):
        size = min(OBSERVATIONS, stop - start)
        for g in range(s):
            total = 0.0
            for i in range(size):
                ratio[g, i] = columns[g, start + i] * inverse[start + i]
                total += ratio[g, i]
            slope[g] += total
        for g in range(0, even, 2):
            for h in range(0, g + 2, 2):
                aa, ab, ba, bb = 0.0, 0.0, 0.0, 0.0
                for i in range(size):
                    aa += ratio[g, i] * ratio[h, i]
                    ab += ratio[g, i] * ratio[h + 1, i]
                    ba += ratio[g + 1, i] * ratio[h, i]
                    bb += ratio[g + 1, i] * ratio[h + 1, i]
                whole[g, h] += aa
                whole[g, h + 1] += ab
                whole[g + 1, h] += ba
                whole[g + 1, h + 1] += bb
    for g in range(s):
        for h in range(g + 1):
            out[g, h] += whole[g, h]
            if h < g:
                out[h, g] += whole[g, h]
