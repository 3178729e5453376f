"""Loops of the sampler ``tempered``: one chain per level of the likelihood's power β, and swaps. Arrays are written.

State: ``theta`` (levels, N), the assignment at each level; level 0 is the posterior itself, β = 1.
"""

from __future__ import annotations

from math import exp

import numpy as np
from numba import njit

from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.collapsed_blocks import sweeps_dense as blocks_dense
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def advance(scaled, relative, edges, prior, log_prior, concentration, theta, sums, generator):
    """One sweep of ``collapsed_blocks`` of one level, on its table β·ℓ; writes ``theta`` (N,); returns the sums."""
    keep, kept, active = np.zeros(1, np.bool_), np.empty((0, theta.size), np.int32), np.empty(1, np.int64)
    fit, joint = np.empty(1), np.empty(1)
    return blocks_dense(
        scaled, relative, edges, prior, log_prior, concentration, theta, sums, keep, kept, fit, joint, active, generator
    )


@njit(cache=True, nogil=True)
def swap(a, powers, fits, theta, work, generator):
    """Exchange levels a and a + 1 with probability min(1, e^{(β_a − β_b)(ℓ(θ_b) − ℓ(θ_a))}).

    Writes ``theta`` (levels, N) and ``fits`` (levels,), the untempered log likelihoods; whether they were exchanged.
    """
    b = a + 1
    work[0] = exp(min((powers[a] - powers[b]) * (fits[b] - fits[a]), 0.0))
    work[1] = 1.0 - work[0]
    if choose(work, 2, generator) == 1:
        return False
    for i in range(theta.shape[1]):
        theta[a, i], theta[b, i] = theta[b, i], theta[a, i]
    fits[a], fits[b] = fits[b], fits[a]
    return True


@njit(cache=True, nogil=True)
def sweeps_dense(table, powers, scaled, relative, edges, prior, log_prior, concentration, theta, sums, keep, kept,
                 log_likelihood, log_joint, n_active, swaps, generator):  # fmt: skip
    """``len(keep)`` sweeps of all levels, on tables ``scaled`` and ``relative`` (levels, N, G).

    Writes ``theta``, of level 0 ``kept`` and the traces, and counts the exchanges in ``swaps`` (levels − 1,).
    """
    g_count = table.shape[1]
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    fits, work = np.empty(powers.size), np.empty(2)
    rows = 0
    for s in range(keep.size):
        for level in range(powers.size):
            sums = advance(
                scaled[level], relative[level], edges, prior, log_prior, concentration, theta[level], sums, generator
            )
            fits[level] = add_assigned(0.0, table, theta[level])
        for a in range(powers.size - 1):
            swaps[a] += swap(a, powers, fits, theta, work, generator)
        log_likelihood[s] = fits[0]
        n_active[s] = recount(theta[0], counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta[0]
            rows += 1
