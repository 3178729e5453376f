"""Sampler ``blocked``: the weights of the candidates drawn, then every observation on its own."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import blocked as loops
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal.partition.assignments import advance_assignment
from subgoal.partition.protocol import Chain, Int32s, Recorder, Stretch
from subgoal.runtime.checks import Bools


def blocked(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of blocked Gibbs over weights and assignments.

    A sweep draws w | θ ~ Dirichlet(ηp + n) and then every θ_i ∝ w_g·L_ig independently. Exact: the Dirichlet process
    with a finite base is the finite mixture with Dirichlet(ηp) weights (Ishwaran & James 2001, with no truncation).
    Observations share nothing but the counts; neighbouring candidates with nearly equal columns mix slowly.
    """
    return advance_assignment(chain, keep, loops.sweeps_dense, _sweeps_tiled)


def _sweeps_tiled(chain: Chain, theta: Int32s, keep: Bools, record: Recorder) -> None:
    """The same sweeps with the table computed tile by tile: same moves, same draws."""
    table, concentration, generator = chain.table, chain.concentration, chain.generator
    g_count, prior = table.n_candidates, np.exp(table.log_prior)
    counts, active, place, order = (np.empty(g_count, np.int64) for _ in range(4))
    log_weights, reach, weights, work = (np.empty(g_count) for _ in range(4))
    tail = np.empty(g_count + 1)
    recount(theta, counts, active, place)
    for s in range(keep.size):
        loops.draw_weights(counts, prior, concentration, log_weights, generator)
        loops.by_reach(log_weights, prior, reach, order, weights, tail)
        total = 0.0
        for start, tile in table.tiles():
            total = loops.assign_rows(
                start, tile, table.relative_tile(start, tile), log_weights, order, weights, tail, theta, work, total,
                generator,
            )  # fmt: skip
        k = recount(theta, counts, active, place)
        record.sweep(s, keep[s], theta, k, total, total + log_assignment_prior(counts, prior, concentration))
