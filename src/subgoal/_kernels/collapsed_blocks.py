"""Loops of the sampler ``collapsed_blocks``: one pass over the table per sweep. State arrays are written.

For each observation in turn its candidate is redrawn with its own count removed and the new candidate summed out. In
every fourth sweep, by lot, it is then seated at a table of a Chinese restaurant with concentration ηp_g among those of
its candidate, and its row is added to the table's sum; after the pass every table redraws its candidate. Blocks of rows
keep the table in cache; the same blocks serve dense and tiled tables, so that both give the same draws.
"""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose, choose_of
from subgoal._kernels.seating import choose_table

BLOCKS_IN = 0.25
"""Share of the sweeps in which clusters move: sums over their rows cost more than all else in a sweep."""
NEGLIGIBLE = -60.0
"""Weights below e^−60 of the largest vanish in its last binary digit, and in that of their sum."""


@njit(cache=True, nogil=True)
def clusters_move(work, generator):
    """Whether this is a sweep in which clusters move."""
    work[0] = BLOCKS_IN
    work[1] = 1.0 - BLOCKS_IN
    return choose(work, 2, generator) == 0


@njit(cache=True, nogil=True)
def largest_first(counts, active, place, k):
    """Order the active candidates by falling count, so that a search among them is short."""
    order = np.argsort(-counts[active[:k]], kind="mergesort")
    sorted_active = active[:k][order]
    for j in range(k):
        active[j] = sorted_active[j]
        place[sorted_active[j]] = j


@njit(cache=True, nogil=True)
def redraw_rows(start, relative, theta, counts, active, place, k, concentration, prior, work, generator):
    """Draw θ_i from (n_g without i + ηp_g)·L_ig over all G at the cost of the K active ones; returns K.

    Row r of ``relative`` (B, G) is L_ig / Σ_g p_g L_ig for i = start + r, so that a redraw from the base weighs η.
    """
    for r in range(relative.shape[0]):
        i = start + r
        old = theta[i]
        counts[old] -= 1
        if counts[old] == 0:
            k -= 1
            last, hole = active[k], place[old]
            active[hole] = last
            place[last] = hole
            place[old] = -1
        row = relative[r]
        total = concentration
        for j in range(k):
            work[j] = counts[active[j]] * row[active[j]]
            total += work[j]
        work[k] = concentration
        pick = choose_of(work, k + 1, total, generator)
        if pick < k:
            new = active[pick]
        else:
            for g in range(prior.size):
                work[g] = prior[g] * row[g]
            new = choose(work, prior.size, generator)
            if counts[new] == 0:
                active[k] = new
                place[new] = k
                k += 1
        theta[i] = new
        counts[new] += 1
    return k


@njit(cache=True, nogil=True)
def seat_rows(start, tile, theta, prior, concentration, table_of, first, following, sizes, sums, n_tables, work, slots,
              generator):  # fmt: skip
    """Seat start..start+len(tile) among those of their candidate seated before; returns the number of tables.

    Tables of a candidate form a list from ``first`` through ``following``. Each row is added to the sum of its table,
    for which there must be room.
    """
    for r in range(tile.shape[0]):
        g = theta[start + r]
        table = choose_table(first[g], following, sizes, concentration * prior[g], work, slots, generator)
        if table < 0:
            table = n_tables
            following[table] = first[g]
            first[g] = table
            sizes[table] = 0
            for c in range(tile.shape[1]):
                sums[table, c] = 0.0
            n_tables += 1
        table_of[start + r] = table
        sizes[table] += 1
        for c in range(tile.shape[1]):
            sums[table, c] += tile[r, c]
    return n_tables


@njit(cache=True, nogil=True)
def with_room(sums, rows):
    """``sums`` with at least ``rows`` rows."""
    if sums.shape[0] >= rows:
        return sums
    larger = np.empty((max(rows, 2 * sums.shape[0]), sums.shape[1]))
    larger[: sums.shape[0]] = sums
    return larger


@njit(cache=True, nogil=True)
def move_blocks(n_tables, sums, log_prior, table_of, theta, dishes, work, generator):
    """Every table redraws its candidate from p_g·Π L_ig; writes ``theta``; returns the log likelihood."""
    log_likelihood = 0.0
    for t in range(n_tables):
        peak = -np.inf
        for g in range(log_prior.size):
            peak = max(peak, sums[t, g] + log_prior[g])
        for g in range(log_prior.size):
            below = sums[t, g] + log_prior[g] - peak
            work[g] = exp(below) if below > NEGLIGIBLE else 0.0
        dishes[t] = choose(work, log_prior.size, generator)
        log_likelihood += sums[t, dishes[t]]
    for i in range(theta.size):
        theta[i] = dishes[table_of[i]]
    return log_likelihood


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, edges, prior, log_prior, concentration, theta, sums, keep, kept, log_likelihood,
                 log_joint, n_active, generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G) in blocks of rows; writes ``theta``, ``kept`` and the traces."""
    n, g_count = table.shape
    counts = np.zeros(g_count, np.int64)
    active = np.empty(g_count, np.int64)
    place = np.empty(g_count, np.int64)
    table_of = np.empty(n, np.int64)
    following = np.empty(n, np.int64)
    sizes = np.empty(n, np.int64)
    dishes = np.empty(n, np.int64)
    slots = np.empty(n, np.int64)
    work = np.empty(max(n, g_count, 2) + 1)
    rows = 0
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        largest_first(counts, active, place, k)
        first = np.full(g_count, -1, np.int64)
        n_tables = 0
        moving = clusters_move(work, generator)
        fit = 0.0
        for e in range(edges.size - 1):
            a, b = edges[e], edges[e + 1]
            k = redraw_rows(a, relative[a:b], theta, counts, active, place, k, concentration, prior, work, generator)
            if not moving:
                fit = add_assigned(fit, table[a:b], theta[a:b])
                continue
            sums = with_room(sums, n_tables + b - a)
            n_tables = seat_rows(
                a, table[a:b], theta, prior, concentration, table_of, first, following, sizes, sums, n_tables, work,
                slots, generator,
            )  # fmt: skip
        if moving:
            fit = move_blocks(n_tables, sums, log_prior, table_of, theta, dishes, work, generator)
        log_likelihood[s] = fit
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
    return sums
