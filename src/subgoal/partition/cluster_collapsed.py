"""Sampler ``cluster_collapsed``: the state is a partition of the observations, candidates summed out."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import cluster_collapsed as loops
from subgoal._kernels.alg4 import occupy
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal.partition.alg4 import seated
from subgoal.partition.protocol import Chain, Recorder, Stretch, starting_assignment
from subgoal.runtime.checks import Bools, Ints


def cluster_collapsed(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of table-level Gibbs with the candidate of every table summed out.

    A sweep redraws the table of each observation: C with weight n_C·m(C with i)/m(C), a new one with weight η·m({i}),
    where m(C) = Σ_g p_g Π_{i∈C} L_ig (Neal 2000, Algorithm 3). Then the candidate of every table is drawn ∝ p_g·ΠL,
    so that what is reported is a draw of p(θ | O) at dish level; the next sweep does without it. A whole cluster so
    moves between neighbouring candidates at no cost. Sums are held of K tables × G candidates, six times over.
    """
    table = chain.table
    state = chain.state or seated(starting_assignment(table, chain.generator))
    label, dish = np.array(state["label"], np.int64), np.array(state["dish"], np.int64)
    record = Recorder(table, keep)
    if table.dense is None:
        _sweeps_tiled(chain, label, dish, keep, record)
    else:
        loops.sweeps_dense(
            table.dense, table.relative, np.exp(table.log_prior), table.log_prior, chain.concentration, label, dish,
            keep, record.kept, record.log_likelihood, record.log_joint, record.n_active, chain.generator,
        )  # fmt: skip
    return record.stretch({"label": label, "dish": dish})


def _sweeps_tiled(chain: Chain, label: Ints, dish: Ints, keep: Bools, record: Recorder) -> None:
    """The same sweeps with the table computed tile by tile: same moves, same draws; one more pass to begin with."""
    table, concentration, generator, log_prior = (
        chain.table,
        chain.concentration,
        chain.generator,
        chain.table.log_prior,
    )
    n, g_count, prior = table.n_observations, table.n_candidates, np.exp(table.log_prior)
    counts, active, place = (np.empty(g_count, np.int64) for _ in range(3))
    size, order, rank, held = (np.empty(n, np.int64) for _ in range(4))
    theta, work, spare = np.empty(n, np.int32), np.empty(max(n, g_count) + 1), np.empty((1, g_count))
    dishes = np.empty(1, np.int64)
    sums, walls = np.zeros((1, g_count)), np.zeros((1, g_count), np.int64)
    for start, tile in table.tiles():
        sums, walls = loops.gather(start, tile, label, sums, walls)
    fresh, fresh_walls = np.zeros(sums.shape), np.zeros(walls.shape, np.int64)
    share, support = np.empty(sums.shape), np.empty(walls.shape, np.int64)
    for s in range(keep.size):
        k = occupy(label, size, order, rank)
        loops.share_all(order, k, sums, walls, log_prior, share, support, held)
        fresh[:], fresh_walls[:] = 0.0, 0
        for start, tile in table.tiles():
            k, sums, walls, fresh, fresh_walls, share, support = loops.reassign_rows(
                start, tile, table.relative_tile(start, tile), label, size, order, rank, k, concentration, log_prior,
                sums, walls, fresh, fresh_walls, share, support, held, work, generator,
            )  # fmt: skip
        value = loops.draw_dishes(
            order, k, fresh, fresh_walls, log_prior, label, dish, theta, dishes, spare, work, generator
        )
        sums, walls, fresh, fresh_walls = fresh, fresh_walls, sums, walls
        k = recount(theta, counts, active, place)
        record.sweep(s, keep[s], theta, k, value, value + log_assignment_prior(counts, prior, concentration))
