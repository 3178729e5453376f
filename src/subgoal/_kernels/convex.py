"""Loops over a likelihood table for the convex weights: scaled rows, gradients, what screening needs."""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit


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
