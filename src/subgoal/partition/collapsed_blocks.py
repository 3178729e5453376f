"""Sampler ``collapsed_blocks``: the new subgoal summed out, whole clusters move at once."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import collapsed_blocks as loops
from subgoal._kernels import seating as restaurants
from subgoal._kernels.alg4 import add_assigned
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal.partition.protocol import FIRST_TABLES, Chain, Int32s, Recorder, Stretch, starting_assignment
from subgoal.runtime.checks import Bools


def collapsed_blocks(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of dish-level collapsed Gibbs with table block moves.

    A sweep redraws each θ_i ∝ (n_g without i + ηp_g)·L_ig with all G candidates in play at the cost of the active
    ones. One sweep in four, by lot, then seats the observations of each candidate by a Chinese restaurant of
    concentration ηp_g, and redraws the candidate of every table ∝ p_g·Π L_ig. Exact: both leave p(θ | O) of the finite
    Dirichlet mixture invariant that the Dirichlet process with a finite base is (Neal 2000, Algorithm 2, with the dish
    integral a finite sum).
    """
    table = chain.table
    state = chain.state or {"theta": starting_assignment(table, chain.generator)}
    theta = np.array(state["theta"], np.int32)
    record = Recorder(table, keep)
    if table.dense is None:
        _sweeps_tiled(chain, theta, keep, record)
    else:
        loops.sweeps_dense(
            table.dense, table.relative, table.edges, np.exp(table.log_prior), table.log_prior, chain.concentration,
            theta, np.empty((FIRST_TABLES, table.n_candidates)), keep, record.kept, record.log_likelihood,
            record.log_joint, record.n_active, chain.generator,
        )  # fmt: skip
    return record.stretch({"theta": theta})


def _sweeps_tiled(chain: Chain, theta: Int32s, keep: Bools, record: Recorder) -> None:
    """The same sweeps with the table computed tile by tile: same moves, same draws."""
    table, concentration, generator = chain.table, chain.concentration, chain.generator
    n, g_count = table.n_observations, table.n_candidates
    prior, log_prior = np.exp(table.log_prior), table.log_prior
    counts, active, place = (np.empty(g_count, np.int64) for _ in range(3))
    seating, dishes = restaurants.seating_for(n, g_count), np.empty(n, np.int64)
    held, work = np.empty(g_count), np.empty(max(n, g_count, 2) + 1)
    sums, mass = np.empty((FIRST_TABLES, g_count)), concentration * prior
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        loops.largest_first(counts, active, place, held, k)
        restaurants.clear(seating)
        n_tables = 0
        moving, value = loops.clusters_move(work, generator), 0.0
        for start, tile in table.tiles():
            relative = table.relative_tile(start, tile)
            k = loops.redraw_rows(start, relative, theta, active, place, held, k, concentration, prior, work, generator)
            if not moving:
                value = add_assigned(value, tile, theta[start : start + len(tile)])
                continue
            sums = loops.with_room(sums, n_tables + len(tile))
            n_tables = restaurants.seat_rows(start, tile, theta, mass, seating, sums, n_tables, generator)
        if moving:
            value = loops.move_blocks(n_tables, sums, log_prior, seating.table_of, theta, dishes, work, generator)
        k = recount(theta, counts, active, place)
        record.sweep(s, keep[s], theta, k, value, value + log_assignment_prior(counts, prior, concentration))
