"""Loops of the chains of a stream: some observations redrawn, one table of a restaurant moved. θ is written."""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from subgoal._kernels.collapsed_blocks import NEGLIGIBLE, largest_first, redraw_rows
from subgoal._kernels.counts import recount
from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def redraw_some(rows, relative, theta, prior, concentration, generator):
    """Redraw θ_i of different observations i = rows[r], in that order, each given all others; writes ``theta`` (N,).

    Row r of ``relative`` (B, G) is L_ig / Σ_g p_g L_ig.
    """
    g_count = prior.size
    counts, active, place = np.empty(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    held, work = np.empty(g_count), np.empty(g_count + 1)
    k = recount(theta, counts, active, place)
    largest_first(counts, active, place, held, k)
    some = theta[rows]
    redraw_rows(0, relative, some, active, place, held, k, concentration, prior, work, generator)
    for r in range(rows.size):
        theta[rows[r]] = some[r]


@njit(cache=True, nogil=True)
def move_table(i, table, theta, mass, log_prior, generator):
    """The table of observation i redraws its candidate from p_g·Π L_ig; writes ``theta`` (N,).

    Seated is who shares the candidate of i, in its restaurant of concentration ``mass`` (G,) = ηp_g, i before all
    others. ``table`` (N or more, G or more) is ℓ.
    """
    g_count, own = log_prior.size, theta[i]
    sums, work = table[i, :g_count].copy(), np.empty(max(g_count, 2))
    beside = np.zeros(theta.size, np.bool_)
    beside[i] = True
    seated, here = 1, 1
    for j in range(theta.size):
        if j == i or theta[j] != own:
            continue
        work[0] = here
        work[1] = seated - here + mass[own]
        seated += 1
        if choose(work, 2, generator) == 0:
            here += 1
            beside[j] = True
            for g in range(g_count):
                sums[g] += table[j, g]
    peak = -np.inf
    for g in range(g_count):
        peak = max(peak, sums[g] + log_prior[g])
    for g in range(g_count):
        below = sums[g] + log_prior[g] - peak
        work[g] = exp(below) if below > NEGLIGIBLE else 0.0
    new = choose(work, g_count, generator)
    for j in range(theta.size):
        if beside[j]:
            theta[j] = new
