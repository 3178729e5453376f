"""Loops of the sampler ``collapsed``: one observation after the other, the weights summed out. Arrays are written."""

from __future__ import annotations

import numpy as np
from numba import njit

from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.collapsed_blocks import largest_first, redraw_rows
from subgoal._kernels.counts import log_assignment_prior, recount


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, prior, concentration, theta, keep, kept, log_likelihood, log_joint, n_active,
                 generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G); writes ``theta``, ``kept`` and the traces."""
    g_count = table.shape[1]
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    held, work = np.empty(g_count), np.empty(g_count + 1)
    rows = 0
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        largest_first(counts, active, place, held, k)
        redraw_rows(0, relative, theta, active, place, held, k, concentration, prior, work, generator)
        log_likelihood[s] = add_assigned(0.0, table, theta)
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
