"""Loops of Algorithm 4 (thesis 4.3), corrected and as printed. Arrays named as state are written.

State: the table of each observation ``label`` (N,), the candidate of each table ``dish`` (slots,), its ``size``.
Every slot in ``order[:k]`` is an occupied table; free slots wait in ``order[k:]``.
"""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def occupy(label, size, order, rank):
    """Sizes and the list of occupied slots from ``label``; returns the number of tables."""
    size[:] = 0
    for i in range(label.size):
        size[label[i]] += 1
    k = 0
    free = size.size
    for slot in range(size.size):
        if size[slot] > 0:
            order[k] = slot
            rank[slot] = k
            k += 1
    for slot in range(size.size - 1, -1, -1):
        if size[slot] == 0:
            free -= 1
            order[free] = slot
            rank[slot] = free
    return k


@njit(cache=True, nogil=True)
def leave(slot, size, order, rank, k):
    """Take one customer from ``slot``; an emptied table joins the free slots (E6). Returns K."""
    size[slot] -= 1
    if size[slot] > 0:
        return k
    k -= 1
    hole, last = rank[slot], order[k]
    order[hole] = last
    rank[last] = hole
    order[k] = slot
    rank[slot] = k
    return k


@njit(cache=True, nogil=True)
def reassign(i, row, label, dish, size, order, rank, k, concentration, prior, singleton_keeps, work, generator):
    """Neal's Algorithm 8 with one auxiliary table (lines 11-17); a singleton offers its own candidate again (E4).

    Without ``singleton_keeps`` the auxiliary candidate is always drawn afresh, as printed. Returns K.
    """
    slot = label[i]
    alone = size[slot] == 1
    k = leave(slot, size, order, rank, k)
    if alone and singleton_keeps:
        offer = dish[slot]
    else:
        offer = choose(prior, prior.size, generator)
    peak = row[offer]
    for j in range(k):
        peak = max(peak, row[dish[order[j]]])
    if peak == -np.inf:
        peak = 0.0
    for j in range(k):
        work[j] = size[order[j]] * exp(row[dish[order[j]]] - peak)
    work[k] = concentration * exp(row[offer] - peak)
    pick = choose(work, k + 1, generator)
    chosen = order[pick]
    if pick == k:
        dish[chosen] = offer
        k += 1
    size[chosen] += 1
    label[i] = chosen
    return k


@njit(cache=True, nogil=True)
def assign_tile(start, tile, label, dish, size, order, rank, k, concentration, prior, singleton_keeps,
                product, sums, work, generator):  # fmt: skip
    """Reassign start..start+len(tile), adding each row to its table's sum (of logs, or of likelihoods as printed).

    Returns the number of tables and the sums, which grow when a new slot is used.
    """
    for r in range(tile.shape[0]):
        i = start + r
        row = tile[r]
        k = reassign(
            i,
            row,
            label,
            dish,
            size,
            order,
            rank,
            k,
            concentration,
            prior,
            singleton_keeps,
            work,
            generator,
        )
        slot = label[i]
        if slot >= sums.shape[0]:
            larger = np.zeros((2 * slot + 2, sums.shape[1]))
            larger[: sums.shape[0]] = sums
            sums = larger
        target = sums[slot]
        if product:
            for g in range(row.size):
                target[g] += row[g]
        else:
            for g in range(row.size):
                target[g] += exp(row[g])
    return k, sums


@njit(cache=True, nogil=True)
def resample_dishes(dish, order, k, sums, log_prior, product, work, generator):
    """Line 8: every table draws its candidate from p_g·Π L_ig (E1), or from p_g·Σ L_ig as printed in (4.12)."""
    for j in range(k):
        row = sums[order[j]]
        peak = -np.inf
        if product:
            for g in range(row.size):
                peak = max(peak, row[g] + log_prior[g])
        for g in range(row.size):
            work[g] = exp(row[g] + log_prior[g] - peak) if product else exp(log_prior[g]) * row[g]
        dish[order[j]] = choose(work, row.size, generator)


@njit(cache=True, nogil=True)
def seat_to_candidate(label, dish, theta):
    """Write θ (N,): the candidate of the table of each observation."""
    for i in range(label.size):
        theta[i] = dish[label[i]]


@njit(cache=True, nogil=True)
def add_assigned(total, tile, theta):
    """``total`` plus Σ ℓ[i, θ_i] of one tile, in order."""
    for r in range(tile.shape[0]):
        total += tile[r, theta[r]]
    return total


@njit(cache=True, nogil=True)
def sweeps_dense(table, prior, log_prior, concentration, singleton_keeps, product, label, dish, sums, keep, kept,
                 log_likelihood, log_joint, n_active, generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G); writes ``label``, ``dish``, ``kept`` and the traces."""
    n, g_count = table.shape
    counts = np.zeros(g_count, np.int64)
    active = np.empty(g_count, np.int64)
    place = np.empty(g_count, np.int64)
    theta = np.empty(n, np.int32)
    size = np.empty(n, np.int64)
    order = np.empty(n, np.int64)
    rank = np.empty(n, np.int64)
    work = np.empty(max(n, g_count) + 1)
    rows = 0
    for s in range(keep.size):
        k = occupy(label, size, order, rank)
        sums[:] = 0.0
        k, sums = assign_tile(
            0, table, label, dish, size, order, rank, k, concentration, prior, singleton_keeps,
            product, sums, work, generator,
        )  # fmt: skip
        resample_dishes(dish, order, k, sums, log_prior, product, work, generator)
        seat_to_candidate(label, dish, theta)
        n_active[s] = recount(theta, counts, active, place)
        total = add_assigned(0.0, table, theta)
        log_likelihood[s] = total
        log_joint[s] = total + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
    return sums
