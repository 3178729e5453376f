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
from subgoal._kernels.seating import clear, seat_rows, seating_for

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
def largest_first(counts, active, place, held, k):
    """Order the active candidates by falling count, so that a search among them is short; writes their counts, held."""
    order = np.argsort(-counts[active[:k]], kind="mergesort")
    sorted_active = active[:k][order]
    for j in range(k):
        active[j] = sorted_active[j]
        place[sorted_active[j]] = j
        held[j] = counts[sorted_active[j]]


@njit(cache=True, nogil=True)
def redraw_rows(start, relative, theta, active, place, held, k, concentration, prior, work, generator):
    """Draw θ_i from (n_g without i + ηp_g)·L_ig over all G at the cost of the K active ones; returns K.

    ``active`` lists the candidates in use, ``held`` their counts, and ``place`` (G,) where in the list each stands, −1
    for nowhere. Row r of ``relative`` (B, G) is L_ig / Σ_g p_g L_ig for i = start + r, so that a redraw from the base
    weighs η.
    """
    for r in range(relative.shape[0]):
        i = start + r
        p = place[theta[i]]
        held[p] -= 1.0
        if held[p] == 0.0:
            k -= 1
            last, old = active[k], active[p]
            active[p] = last
            held[p] = held[k]
            place[last] = p
            place[old] = -1
        row = relative[r]
        total = concentration
        for j in range(k):
            work[j] = held[j] * row[active[j]]
            total += work[j]
        work[k] = concentration
        pick = choose_of(work, k + 1, total, generator)
        if pick == k:
            for g in range(prior.size):
                work[g] = prior[g] * row[g]
            new = choose(work, prior.size, generator)
            pick = place[new]
            if pick < 0:
                pick = k
                active[k] = new
                place[new] = k
                held[k] = 0.0
                k += 1
        theta[i] = active[pick]
        held[pick] += 1.0
    return k


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
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    seating, dishes = seating_for(n, g_count), np.empty(n, np.int64)
    held, work = np.empty(g_count), np.empty(max(n, g_count, 2) + 1)
    mass = concentration * prior
    rows = 0
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        largest_first(counts, active, place, held, k)
        clear(seating)
        n_tables = 0
        moving = clusters_move(work, generator)
        fit = 0.0
        for e in range(edges.size - 1):
            a, b = edges[e], edges[e + 1]
            k = redraw_rows(a, relative[a:b], theta, active, place, held, k, concentration, prior, work, generator)
            if not moving:
                fit = add_assigned(fit, table[a:b], theta[a:b])
                continue
            sums = with_room(sums, n_tables + b - a)
            n_tables = seat_rows(a, table[a:b], theta, mass, seating, sums, n_tables, generator)
        if moving:
            fit = move_blocks(n_tables, sums, log_prior, seating.table_of, theta, dishes, work, generator)
        log_likelihood[s] = fit
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
    return sums
