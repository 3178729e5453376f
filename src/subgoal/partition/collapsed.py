"""Sampler ``collapsed``: one observation at a time, the weights of the candidates summed out."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import collapsed as loops
from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.collapsed_blocks import largest_first, redraw_rows
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal.partition.assignments import advance_assignment
from subgoal.partition.protocol import Chain, Int32s, Recorder, Stretch
from subgoal.runtime.checks import Bools


def collapsed(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of dish-level collapsed Gibbs.

    A sweep redraws each θ_i ∝ (n_g without i + ηp_g)·L_ig over all G candidates. The plainest exact sampler, against
    which the others are held (Neal 2000, Algorithm 3, for the finite Dirichlet mixture). A cluster changes its
    candidate only observation by observation, so that neighbouring candidates with nearly equal columns mix slowly.
    """
    return advance_assignment(chain, keep, loops.sweeps_dense, _sweeps_tiled)


def _sweeps_tiled(chain: Chain, theta: Int32s, keep: Bools, record: Recorder) -> None:
    """The same sweeps with the table computed tile by tile: same moves, same draws."""
    table, concentration, generator = chain.table, chain.concentration, chain.generator
    g_count, prior = table.n_candidates, np.exp(table.log_prior)
    counts, active, place = (np.empty(g_count, np.int64) for _ in range(3))
    held, work = np.empty(g_count), np.empty(g_count + 1)
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        largest_first(counts, active, place, held, k)
        total = 0.0
        for start, tile in table.tiles():
            relative = table.relative_tile(start, tile)
            k = redraw_rows(start, relative, theta, active, place, held, k, concentration, prior, work, generator)
            total = add_assigned(total, tile, theta[start : start + len(tile)])
        k = recount(theta, counts, active, place)
        record.sweep(s, keep[s], theta, k, total, total + log_assignment_prior(counts, prior, concentration))
