"""Whole sweeps of subgoals that persist with known probabilities, over a table in one block: nothing leaves the loop.

Arrays named as written are state. For a small table a sweep in Python takes ten times as long as its arithmetic.
"""

from __future__ import annotations

from math import exp, log, log1p

import numpy as np
from numba import njit

from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.collapsed_blocks import sweeps_dense
from subgoal._kernels.counts import log_assignment_prior
from subgoal._kernels.persistence import add_to_runs, count_steps, draw_rows, filter_rows, normalise_runs


@njit(cache=True, nogil=True)
def draw_weights(shape, least, generator, out):
    """Write ``out`` (G,): a draw from Dirichlet(shape), logarithms cut at ``least``; Gamma(a) is Gamma(a + 1)·U^1/a."""
    peak = -np.inf
    for g in range(shape.size):
        out[g] = log(generator.standard_gamma(shape[g] + 1.0))
    for g in range(shape.size):
        out[g] += log1p(-generator.random()) / shape[g]
        peak = max(peak, out[g])
    total = 0.0
    for g in range(shape.size):
        total += exp(out[g] - peak)
    for g in range(shape.size):
        out[g] = exp(max(out[g] - peak - log(total), least))


@njit(cache=True, nogil=True)
def list_runs(theta, redrawn, run, candidate, counts):
    """Write the run of each row, the candidate of each run, and how often each was drawn; returns how many runs."""
    counts[:] = 0
    last = -1
    for i in range(theta.size):
        if redrawn[i]:
            last += 1
            candidate[last] = theta[i]
            counts[theta[i]] += 1
        run[i] = last
    return last + 1


@njit(cache=True, nogil=True)
def distinct(counts):
    """How many candidates are in use."""
    used = 0
    for g in range(counts.size):
        used += counts[g] > 0
    return used


@njit(cache=True, nogil=True)
def log_of_steps(steps, keep, keep_there):
    """log p(which steps keep their subgoal), from the numbers that ``count_steps`` wrote."""
    value = 0.0
    for at in range(2):
        chance = keep_there if at == 1 else keep
        if steps[0, at] > 0:
            value += steps[0, at] * log(chance)
        if steps[1, at] > 0:
            value += steps[1, at] * log(1.0 - chance)
    return value


@njit(cache=True, nogil=True)
def sweeps_of_runs(table, relative, first, there_from, there, prior, log_prior, concentration, keep, keep_there,
                   log_kept, log_left, least, inner, theta, redrawn, counts, wanted, kept, redraws, log_likelihood,
                   log_joint, n_active, generator):  # fmt: skip
    """``len(wanted)`` sweeps: weights, path, and ``inner`` sweeps over its runs; writes ``theta``, ``redrawn``,
    ``counts`` (G,) of redraws, the assignments and redraws of sweeps that are ``wanted``, and the traces.
    """
    n, g_count = table.shape
    weights, entering, filtered = np.empty(g_count), np.zeros(g_count), np.empty((n, g_count))
    work, log_total = np.empty(max(g_count, 2)), np.empty(n)
    run, candidates, steps = np.empty(n, np.int64), np.empty(n, np.int32), np.empty((2, 2), np.int64)
    runs_sums, runs_relative, tables = np.empty((n, g_count)), np.empty((n, g_count)), np.empty((64, g_count))
    fit, joint, active = np.empty(inner), np.empty(inner), np.empty(inner, np.int64)
    none, nothing = np.zeros(inner, np.bool_), np.empty((0, n), np.int32)
    rows = 0
    for s in range(wanted.size):
        draw_weights(concentration * prior + counts, least, generator, weights)
        filter_rows(0, relative, first, there_from, there, weights, keep, keep_there, entering, filtered, log_total)
        draw_rows(0, filtered, first, there_from, there, weights, keep, keep_there, theta, redrawn, work, generator)
        k = list_runs(theta, redrawn, run, candidates, counts)
        sums, own, candidate = runs_sums[:k], runs_relative[:k], candidates[:k]
        sums[:] = 0.0
        add_to_runs(0, table, run, there_from, there, first, redrawn, log_kept, log_left, sums)
        normalise_runs(sums, log_prior, own)
        tables = sweeps_dense(sums, own, np.array([0, k]), prior, log_prior, concentration, candidate, tables, none,
                              nothing[:, :k], fit, joint, active, generator)  # fmt: skip
        for i in range(n):
            theta[i] = candidate[run[i]]
        list_runs(theta, redrawn, run, candidates, counts)
        count_steps(theta, redrawn, first, there_from, there, steps)
        log_likelihood[s] = add_assigned(0.0, table, theta)
        log_joint[s] = (
            log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
            + log_of_steps(steps, keep, keep_there)
        )  # fmt: skip
        n_active[s] = distinct(counts)
        if wanted[s]:
            kept[rows], redraws[rows] = theta, counts
            rows += 1
