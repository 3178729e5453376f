"""Loops of the sampler ``collapsed_blocks``: one pass over the table per sweep. State arrays are written.

For each observation in turn its candidate is redrawn with its own count removed and the new candidate summed out,
the observation is seated at a table of a Chinese restaurant with concentration ηp_g among those of its candidate
already redrawn, and its row is added to the table's sum. After the pass every table redraws its candidate.
"""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose

NEGLIGIBLE = -60.0
"""Weights below e^−60 of the largest vanish in its last binary digit, and in that of their sum."""


@njit(cache=True, nogil=True, inline="always")
def redraw_candidate(i, r, relative, theta, counts, active, place, k, concentration, prior, work, generator):
    """Draw θ_i from (n_g without i + ηp_g)·L_ig over all G at the cost of the K active ones; returns K.

    Row ``r`` of ``relative`` (B, G) is L_ig / Σ_g p_g L_ig, so that the weight of a redraw from the base is η.
    """
    old = theta[i]
    counts[old] -= 1
    if counts[old] == 0:
        k -= 1
        last, hole = active[k], place[old]
        active[hole] = last
        place[last] = hole
        place[old] = -1
    total = 0.0
    for j in range(k):
        g = active[j]
        total += counts[g] * relative[r, g]
        work[j] = total
    work[k] = total + concentration
    pick = choose(work, k + 1, generator)
    if pick < k:
        new = active[pick]
    else:
        total = 0.0
        for g in range(prior.size):
            total += prior[g] * relative[r, g]
            work[g] = total
        new = choose(work, prior.size, generator)
        if counts[new] == 0:
            active[k] = new
            place[new] = k
            k += 1
    theta[i] = new
    counts[new] += 1
    return k


@njit(cache=True, nogil=True, inline="always")
def seat(i, r, tile, theta, mass, table_of, seen, first, following, sizes, sums, n_tables, work, slots, generator):
    """Seat observation i among those of its candidate seated before it: Chinese restaurant of concentration ``mass``.

    Tables of a candidate form a list from ``first`` through ``following``. Adds row ``r`` of the tile to the table's
    sum, for which there must be room. Returns the number of tables.
    """
    g = theta[i]
    table = n_tables
    if seen[g] > 0:
        total, count = 0.0, 0
        other = first[g]
        while other >= 0:
            total += sizes[other]
            work[count] = total
            slots[count] = other
            count += 1
            other = following[other]
        work[count] = total + mass
        pick = choose(work, count + 1, generator)
        if pick < count:
            table = slots[pick]
    if table == n_tables:
        following[table] = first[g]
        first[g] = table
        sizes[table] = 0
        for c in range(tile.shape[1]):
            sums[table, c] = 0.0
        n_tables += 1
    seen[g] += 1
    table_of[i] = table
    sizes[table] += 1
    for c in range(tile.shape[1]):
        sums[table, c] += tile[r, c]
    return n_tables


@njit(cache=True, nogil=True)
def pass_tile(start, tile, relative, prior, concentration, theta, counts, active, place, k,
              table_of, seen, first, following, sizes, sums, n_tables, work, slots, generator):  # fmt: skip
    """Redraw and seat the observations start..start+len(tile); returns K, the number of tables and their sums."""
    for r in range(tile.shape[0]):
        i = start + r
        k = redraw_candidate(i, r, relative, theta, counts, active, place, k, concentration, prior, work, generator)
        if n_tables == sums.shape[0]:
            larger = np.empty((2 * n_tables, sums.shape[1]))
            larger[:n_tables] = sums
            sums = larger
        n_tables = seat(
            i, r, tile, theta, concentration * prior[theta[i]], table_of, seen, first, following, sizes, sums,
            n_tables, work, slots, generator,
        )  # fmt: skip
    return k, n_tables, sums


@njit(cache=True, nogil=True)
def move_blocks(n_tables, sums, log_prior, table_of, theta, dishes, work, generator):
    """Every table redraws its candidate from p_g·Π L_ig; writes ``theta``; returns the log likelihood."""
    log_likelihood = 0.0
    for t in range(n_tables):
        row = sums[t]
        peak = -np.inf
        for g in range(row.size):
            if row[g] + log_prior[g] > peak:
                peak = row[g] + log_prior[g]
        total = 0.0
        for g in range(row.size):
            below = row[g] + log_prior[g] - peak
            if below > NEGLIGIBLE:
                total += exp(below)
            work[g] = total
        dishes[t] = choose(work, row.size, generator)
        log_likelihood += row[dishes[t]]
    for i in range(theta.size):
        theta[i] = dishes[table_of[i]]
    return log_likelihood


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, prior, log_prior, concentration, theta, sums, keep, kept, log_likelihood,
                 log_joint, n_active, generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G); writes ``theta``, ``kept`` and the three traces."""
    n, g_count = table.shape
    counts = np.zeros(g_count, np.int64)
    active = np.empty(g_count, np.int64)
    place = np.empty(g_count, np.int64)
    table_of = np.empty(n, np.int64)
    following = np.empty(n, np.int64)
    sizes = np.empty(n, np.int64)
    dishes = np.empty(n, np.int64)
    slots = np.empty(n, np.int64)
    work = np.empty(max(n, g_count) + 1)
    rows = 0
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        seen = np.zeros(g_count, np.int64)
        first = np.full(g_count, -1, np.int64)
        k, n_tables, sums = pass_tile(
            0, table, relative, prior, concentration, theta, counts, active, place, k,
            table_of, seen, first, following, sizes, sums, 0, work, slots, generator,
        )  # fmt: skip
        log_likelihood[s] = move_blocks(n_tables, sums, log_prior, table_of, theta, dishes, work, generator)
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
    return sums
