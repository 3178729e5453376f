"""Log probabilities of actions under a softmax of their values, for many goals side by side."""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def softmax_tile(values, rows, actions, confidence, out):
    """Write ``out`` (B, G): α·Q(s, a) − log Σ_b exp(α·Q(s, b)) for row and action of each of B pairs.

    ``confidence`` is (G,); ``values`` (U, A, G) are −inf for illegal actions, which have no part in the sum.
    """
    n_actions, g_count = values.shape[1], values.shape[2]
    peak, total = np.empty(g_count), np.empty(g_count)
    for i in range(rows.size):
        table = values[rows[i]]
        for g in range(g_count):
            peak[g], total[g] = table[0, g], 0.0
        for a in range(1, n_actions):
            for g in range(g_count):
                peak[g] = table[a, g] if table[a, g] > peak[g] else peak[g]
        for a in range(n_actions):
            for g in range(g_count):
                total[g] += exp(confidence[g] * (table[a, g] - peak[g]))
        for g in range(g_count):
            out[i, g] = confidence[g] * (table[actions[i], g] - peak[g]) - log(total[g])


@njit(cache=True, nogil=True, error_model="numpy")
def tested_tile(taken, tested, confidence, out):
    """Write ``out`` (B, G): α·Q(s, a) − log mean_m exp(α·Q(s, u_m)) of the action taken, by M test actions.

    ``taken`` (B, G) are the values of the actions taken, ``tested`` (B, M, G) of the test actions; ``confidence`` (G,).
    """
    m_count, g_count = tested.shape[1], tested.shape[2]
    peak, total = np.empty(g_count), np.empty(g_count)
    for i in range(tested.shape[0]):
        for g in range(g_count):
            peak[g], total[g] = tested[i, 0, g], 0.0
        for m in range(1, m_count):
            for g in range(g_count):
                peak[g] = tested[i, m, g] if tested[i, m, g] > peak[g] else peak[g]
        for m in range(m_count):
            for g in range(g_count):
                total[g] += exp(confidence[g] * (tested[i, m, g] - peak[g]))
        for g in range(g_count):
            out[i, g] = confidence[g] * (taken[i, g] - peak[g]) - log(total[g] / m_count)
