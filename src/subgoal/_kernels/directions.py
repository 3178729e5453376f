"""Log density of unit directions around the straight way to each candidate (thesis 5.1 with 5.2), row by row."""

from __future__ import annotations

from math import exp, log, sqrt

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def direction_row(unit, state, goals, period, near, confidence, log_normaliser, log_uniform, squared, out):
    """Write ``out`` (G,): −α‖u − û_g‖ − log Z, or the uniform density where the candidate is within ``near``.

    ``unit`` (d,), ``state`` (d,), ``goals`` (d, G) and ``period`` (d,) are in weighted units; ``confidence`` and
    ``log_normaliser`` are (G,); ``squared`` (G,) is room.
    """
    d, g_count = goals.shape
    for g in range(g_count):
        squared[g] = 0.0
    for k in range(d):
        origin = state[k]
        if np.isinf(period[k]):
            for g in range(g_count):
                squared[g] += (goals[k, g] - origin) ** 2
        else:
            for g in range(g_count):
                gap = goals[k, g] - origin
                squared[g] += (gap - period[k] * np.rint(gap / period[k])) ** 2
    for g in range(g_count):
        out[g] = 0.0
    for k in range(d):
        origin, along = state[k], unit[k]
        if np.isinf(period[k]):
            for g in range(g_count):
                out[g] += (along - (goals[k, g] - origin) / sqrt(squared[g])) ** 2
        else:
            for g in range(g_count):
                gap = goals[k, g] - origin
                out[g] += (along - (gap - period[k] * np.rint(gap / period[k])) / sqrt(squared[g])) ** 2
    limit = near * near
    for g in range(g_count):
        out[g] = log_uniform if squared[g] <= limit else -confidence[g] * sqrt(out[g]) - log_normaliser[g]


@njit(cache=True, nogil=True, error_model="numpy")
def direction_tile(units, states, slow, goals, period, near, confidence, log_normaliser, log_uniform, out):
    """Write ``out`` (B, G) for B observations; those marked ``slow`` get the uniform density everywhere."""
    squared = np.empty(goals.shape[1])
    for i in range(units.shape[0]):
        if slow[i]:
            out[i] = log_uniform
        else:
            direction_row(
                units[i], states[i], goals, period, near, confidence, log_normaliser, log_uniform, squared, out[i]
            )


@njit(cache=True, nogil=True, error_model="numpy")
def log_sum_row(row, log_prior):
    """log Σ_g p_g exp(row_g); −inf when all are impossible."""
    peak = -np.inf
    for g in range(row.size):
        peak = max(peak, row[g] + log_prior[g])
    if not np.isfinite(peak):
        return peak
    total = 0.0
    for g in range(row.size):
        total += exp(row[g] + log_prior[g] - peak)
    return peak + log(total)


@njit(cache=True, nogil=True, error_model="numpy")
def log_sum_tile(tile, log_prior, out):
    """Write ``out`` (B,): ``log_sum_row`` of each row; NaN in a row gives NaN."""
    for i in range(tile.shape[0]):
        out[i] = log_sum_row(tile[i], log_prior)
        for g in range(tile.shape[1]):
            if np.isnan(tile[i, g]):
                out[i] = np.nan


@njit(cache=True, nogil=True, error_model="numpy")
def direction_log_sum(
    units, states, slow, goals, period, near, confidence, log_normaliser, log_uniform, log_prior, out
):
    """Write ``out`` (B,): log Σ_g p_g L_ig with no row kept."""
    squared = np.empty(goals.shape[1])
    row = np.empty(goals.shape[1])
    for i in range(units.shape[0]):
        if slow[i]:
            out[i] = log_uniform
        else:
            direction_row(
                units[i], states[i], goals, period, near, confidence, log_normaliser, log_uniform, squared, row
            )
            out[i] = log_sum_row(row, log_prior)


@njit(cache=True, nogil=True, error_model="numpy")
def relative_tile(tile, marginal, out):
    """Write ``out`` (B, G): exp(ℓ − log marginal)."""
    for i in range(tile.shape[0]):
        for g in range(tile.shape[1]):
            out[i, g] = exp(tile[i, g] - marginal[i])
