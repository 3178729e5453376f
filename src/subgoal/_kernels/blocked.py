"""Loops of the sampler ``blocked``: weights given counts, then every observation given the weights. Arrays are written.

With ηp_g far below 1 the weights of unused candidates are smaller than any float can be, so they are held as logs;
where the likelihoods alone do not tell apart zero and very small, an observation is drawn from sums of logs.
"""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit

from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose

VANISHING = 2.0**-80
"""What is below this share of a sum is lost in its last binary digit, whatever the number of terms."""
SMALLEST = 1e-250
"""Sums below this may have lost terms to underflow."""


@njit(cache=True, nogil=True)
def draw_weights(counts, prior, concentration, log_weights, generator):
    """Write ``log_weights`` (G,): w ~ Dirichlet(ηp + n) up to a factor, the largest 0, by Γ(a) = Γ(a + 1)·U^{1/a}."""
    peak = -np.inf
    for g in range(counts.size):
        shape = concentration * prior[g] + counts[g]
        log_weights[g] = -np.inf
        if shape > 0.0:
            log_weights[g] = log(generator.standard_gamma(shape + 1.0)) - generator.standard_exponential() / shape
        peak = max(peak, log_weights[g])
    for g in range(counts.size):
        log_weights[g] -= peak


@njit(cache=True, nogil=True)
def by_reach(log_weights, prior, reach, order, weights, tail):
    """Order the candidates by falling w_g/p_g, the most that w_g·L_ig/Σ p_g L_ig can be.

    Writes ``order`` (G,), ``weights`` (G,) in that order and ``tail`` (G+1,), sums of what is still to come.
    """
    for g in range(prior.size):
        weights[g] = exp(log_weights[g])
        reach[g] = weights[g] / prior[g] if weights[g] > 0.0 else 0.0
    falling = np.argsort(-reach, kind="mergesort")
    tail[prior.size] = 0.0
    for j in range(prior.size - 1, -1, -1):
        order[j] = falling[j]
        tail[j] = tail[j + 1] + reach[falling[j]]
    for j in range(prior.size):
        weights[j] = exp(log_weights[order[j]])


@njit(cache=True, nogil=True)
def assign_rows(start, tile, relative, log_weights, order, weights, tail, theta, work, total, generator):
    """Draw θ_i ∝ w_g L_ig for the rows of ``tile`` (B, G); returns ``total`` plus their Σ ℓ[i, θ_i].

    Row r of ``relative`` (B, G) is L_ig / Σ_g p_g L_ig for i = start + r. Candidates are gone through until those to
    come cannot matter.
    """
    for r in range(tile.shape[0]):
        mass = 0.0
        count = 0
        while count < order.size and tail[count] > VANISHING * mass:
            work[count] = weights[count] * relative[r, order[count]]
            mass += work[count]
            count += 1
        if mass > SMALLEST:
            new = order[choose(work, count, generator)]
        else:
            peak = -np.inf
            for g in range(log_weights.size):
                peak = max(peak, log_weights[g] + tile[r, g])
            for g in range(log_weights.size):
                work[g] = exp(log_weights[g] + tile[r, g] - peak)
            new = choose(work, log_weights.size, generator)
        theta[start + r] = new
        total += tile[r, new]
    return total


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, prior, concentration, theta, keep, kept, log_likelihood, log_joint, n_active,
                 generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G); writes ``theta``, ``kept`` and the traces."""
    g_count = table.shape[1]
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    order = np.empty(g_count, np.int64)
    log_weights, reach, weights = np.empty(g_count), np.empty(g_count), np.empty(g_count)
    tail, work = np.empty(g_count + 1), np.empty(g_count)
    rows = 0
    recount(theta, counts, active, place)
    for s in range(keep.size):
        draw_weights(counts, prior, concentration, log_weights, generator)
        by_reach(log_weights, prior, reach, order, weights, tail)
        log_likelihood[s] = assign_rows(
            0, table, relative, log_weights, order, weights, tail, theta, work, 0.0, generator
        )
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
