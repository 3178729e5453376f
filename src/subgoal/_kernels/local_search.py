"""Loops of the search for the likeliest assignment and of its upper bound. Arrays named in docstrings are written."""

from __future__ import annotations

from math import lgamma, log

import numpy as np
from numba import njit


@njit(cache=True, nogil=True)
def move_rows(start, tile, theta, counts, mass, level, least):
    """Move each of the rows to where ℓ_ih + log(n_h without i + ηp_h) is largest; returns how many moved.

    Writes ``theta`` (N,), ``counts`` (G,) and ``level`` (G,), which is log(counts + mass).
    """
    moved = 0
    for r in range(tile.shape[0]):
        i = start + r
        old = theta[i]
        best, target = tile[r, old] + log(counts[old] - 1 + mass[old]) + least, old
        for g in range(mass.size):
            value = tile[r, g] + level[g]
            if value > best and g != old:
                best, target = value, g
        if target != old:
            theta[i] = target
            counts[old] -= 1
            counts[target] += 1
            level[old] = log(counts[old] + mass[old])
            level[target] = log(counts[target] + mass[target])
            moved += 1
    return moved


@njit(cache=True, nogil=True)
def sums_of_clusters(start, tile, theta, place, sums):
    """Add each row to ``sums`` (K, G) at the place of its candidate."""
    for r in range(tile.shape[0]):
        k = place[theta[start + r]]
        for g in range(tile.shape[1]):
            sums[k, g] += tile[r, g]


@njit(cache=True, nogil=True)
def gains_of_growing(start, tile, theta, place, own, level, gain, moved):
    """Who would go to h if it were at ``level`` (G,): ℓ_ih + level_h above ℓ_iθ + own_θ (G,).

    Adds Σ (ℓ_ih − ℓ_iθ) over them to ``gain`` (G,), and how many come from each cluster to ``moved`` (K, G).
    """
    for r in range(tile.shape[0]):
        g = theta[start + r]
        k, here = place[g], tile[r, g]
        least = here + own[g]
        for h in range(tile.shape[1]):
            if tile[r, h] + level[h] > least and h != g:
                gain[h] += tile[r, h] - here
                moved[k, h] += 1


@njit(cache=True, nogil=True)
def best_groups(columns, price, mass, first, stop, used):
    """Σ_g max(0, max over sets M of Σ_{i∈M} (ℓ_ig − v_i) + log Γ(m + ηp_g) − log Γ(ηp_g)), for columns first..stop.

    ``columns`` (G, N) is ℓ turned and ``price`` (N,) v. Adds one to ``used`` (N,) for each member of a best set. The
    best set of a size takes the largest ℓ_ig − v_i; the m-th adds log(m − 1 + ηp_g), at most log(N − 1 + ηp_g).
    """
    n = price.size
    surplus, who = np.empty(n), np.empty(n, np.int64)
    whole = 0.0
    for g in range(first, stop):
        least = -log(n - 1 + mass[g])
        count = 0
        for i in range(n):
            value = columns[g, i] - price[i]
            if value > least:
                surplus[count] = value
                who[count] = i
                count += 1
        order = np.argsort(-surplus[:count])
        total, best, size = 0.0, 0.0, 0
        for m in range(count):
            total += surplus[order[m]] + log(m + mass[g])
            if total > best:
                best, size = total, m + 1
        whole += best
        for m in range(size):
            used[who[order[m]]] += 1
    return whole


@njit(cache=True, nogil=True)
def log_joint_of_counts(counts, mass):
    """log p(θ) of counts (G,) with weights Dirichlet(mass)."""
    n, whole, value = 0, 0.0, 0.0
    for g in range(mass.size):
        whole += mass[g]
        if counts[g] > 0:
            value += lgamma(counts[g] + mass[g]) - lgamma(mass[g])
            n += counts[g]
    return value + lgamma(whole) - lgamma(n + whole)
