"""Loops over partitions: co-clustering, and the greedy descent of the expected variation of information.

``weight[n]`` is n·log n throughout. A partition of N things at its contingency with T draws: ``sizes`` (K,) things per
cluster, ``cross`` (T, K, L) things per cluster and cluster of the draw.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def count_together(labels, start, stop, out):
    """Write into rows start..stop of ``out`` (N, N) how many of the draws ``labels`` (N, T) hold i and j together."""
    n, draws = labels.shape
    for i in range(start, stop):
        for j in range(n):
            same = 0
            for t in range(draws):
                same += labels[i, t] == labels[j, t]
            out[i, j] = same


@njit(cache=True, nogil=True)
def cross_counts(labels, draws, clusters, widest):
    """(T, L, K) contingency of ``labels`` (N,) with each of ``draws`` (T, N)."""
    table = np.zeros((draws.shape[0], widest, clusters), np.int32)
    for t in range(draws.shape[0]):
        for i in range(labels.size):
            table[t, draws[t, i], labels[i]] += 1
    return table


@njit(cache=True, nogil=True)
def mutual_sum(labels, draws, clusters, widest, weight):
    """Σ_t Σ_ab n_ab log n_ab over the draws, without holding more than one contingency."""
    table = np.zeros((clusters, widest), np.int32)
    total = 0.0
    for t in range(draws.shape[0]):
        table[:] = 0
        for i in range(labels.size):
            table[labels[i], draws[t, i]] += 1
        for a in range(clusters):
            for b in range(widest):
                total += weight[table[a, b]]
    return total


@njit(cache=True, nogil=True)
def move_singles(labels, sizes, cross, draws, weight):
    """One pass of best moves of single things; writes labels, sizes, cross. Returns the fall of N times expected VI.

    Moving to an empty cluster opens it; the pass opens no more than there are empty ones.
    """
    n_draws, clusters = cross.shape[0], sizes.size
    gain = np.empty(clusters)
    fall = 0.0
    for i in range(labels.size):
        a = labels[i]
        gain[:] = 0.0
        for t in range(n_draws):
            k = draws[t, i]
            for b in range(clusters):
                there = cross[t, k, b] - (b == a)
                gain[b] += weight[there + 1] - weight[there]
        leave = weight[sizes[a] - 1] - weight[sizes[a]] + 2.0 * gain[a] / n_draws
        best, target, empty_seen = -1e-9, a, sizes[a] == 1
        for b in range(clusters):
            if b == a or (sizes[b] == 0 and empty_seen):
                continue
            empty_seen = empty_seen or sizes[b] == 0
            change = leave + weight[sizes[b] + 1] - weight[sizes[b]] - 2.0 * gain[b] / n_draws
            if change < best:
                best, target = change, b
        if target != a:
            for t in range(n_draws):
                cross[t, draws[t, i], a] -= 1
                cross[t, draws[t, i], target] += 1
            sizes[a] -= 1
            sizes[target] += 1
            labels[i] = target
            fall -= best
    return fall


@njit(cache=True, nogil=True)
def best_merger(sizes, cross, weight):
    """The pair of clusters whose merger lowers N times expected VI most: (change, a, b), change 0 if none does."""
    n_draws, widest, clusters = cross.shape
    gain = np.zeros((clusters, clusters))
    for t in range(n_draws):
        for k in range(widest):
            for a in range(clusters):
                one = cross[t, k, a]
                if one == 0:
                    continue
                for b in range(a):
                    other = cross[t, k, b]
                    if other > 0:
                        gain[a, b] += weight[one + other] - weight[one] - weight[other]
    best, first, second = -1e-9, -1, -1
    for a in range(clusters):
        for b in range(a):
            if sizes[a] == 0 or sizes[b] == 0:
                continue
            change = weight[sizes[a] + sizes[b]] - weight[sizes[a]] - weight[sizes[b]] - 2.0 * gain[a, b] / n_draws
            if change < best:
                best, first, second = change, b, a
    return best if first >= 0 else 0.0, first, second
