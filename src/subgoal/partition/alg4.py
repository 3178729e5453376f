"""Algorithm 4 of the thesis: corrected, and as printed under names that say so (docs/errata: E1, E4)."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import alg4 as loops
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal.partition.protocol import (
    FIRST_TABLES,
    Chain,
    Int32s,
    Recorder,
    Stretch,
    starting_assignment,
)
from subgoal.runtime.checks import Bools, Ints

PRINTED_FORMS = frozenset({"alg4_literal", "alg4_literal_fresh_draw", "alg4_literal_sum"})
"""Samplers whose invariant law is not the posterior."""


def alg4_corrected(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of Algorithm 4 with its two errors mended.

    The subgoal of a cluster is drawn from p_g times the *product* of its observations' likelihoods (4.11 prints a
    sum), and an observation alone at its table keeps its own subgoal as the auxiliary one (Neal 2000, Algorithm 8,
    m = 1). Invariant for p(z, g | O); draws are reported at dish level, θ_i = g_{z_i}.
    """
    return _advance(chain, keep, singleton_keeps=True, product=True)


def alg4_literal_fresh_draw(chain: Chain, keep: Bools) -> Stretch:
    """Line 14 as printed: a fresh subgoal for singletons too. Biased; for demonstration only."""
    return _advance(chain, keep, singleton_keeps=False, product=True)


def alg4_literal_sum(chain: Chain, keep: Bools) -> Stretch:
    """Equations (4.11)-(4.12) as printed: a sum over observations. Biased; for demonstration only."""
    return _advance(chain, keep, singleton_keeps=True, product=False)


def alg4_literal(chain: Chain, keep: Bools) -> Stretch:
    """Algorithm 4 entirely as printed. Biased; for demonstration only."""
    return _advance(chain, keep, singleton_keeps=False, product=False)


def _advance(chain: Chain, keep: Bools, *, singleton_keeps: bool, product: bool) -> Stretch:
    table = chain.table
    state = chain.state or seated(starting_assignment(table, chain.generator))
    label, dish = np.array(state["label"], np.int64), np.array(state["dish"], np.int64)
    record = Recorder(table, keep)
    if table.dense is None:
        _sweeps_tiled(chain, label, dish, keep, record, singleton_keeps, product)
    else:
        loops.sweeps_dense(
            table.dense, np.exp(table.log_prior), table.log_prior, chain.concentration, singleton_keeps, product,
            label, dish, np.zeros((FIRST_TABLES, table.n_candidates)), keep, record.kept, record.log_likelihood,
            record.log_joint, record.n_active, chain.generator,
        )  # fmt: skip
    return record.stretch({"label": label, "dish": dish})


def seated(theta: Int32s) -> dict[str, Ints]:
    """The state in which all observations of a candidate sit at one table: ``label`` and ``dish``, both (N,)."""
    candidates, label = np.unique(theta, return_inverse=True)
    dish = np.zeros(theta.size, np.int64)
    dish[: candidates.size] = candidates
    return {"label": label.astype(np.int64), "dish": dish}


def _sweeps_tiled(
    chain: Chain, label: Ints, dish: Ints, keep: Bools, record: Recorder, singleton_keeps: bool, product: bool
) -> None:
    """The same sweeps with the table computed tile by tile: same moves, same draws."""
    table, concentration, generator = chain.table, chain.concentration, chain.generator
    n, g_count = table.n_observations, table.n_candidates
    prior = np.exp(table.log_prior)
    size, order, rank = (np.empty(n, np.int64) for _ in range(3))
    counts, active, place = (np.empty(g_count, np.int64) for _ in range(3))
    theta, work = np.empty(n, np.int32), np.empty(max(n, g_count) + 1)
    sums = np.zeros((FIRST_TABLES, g_count))
    for s in range(keep.size):
        k = loops.occupy(label, size, order, rank)
        sums[:] = 0.0
        for start, tile in table.tiles():
            k, sums = loops.assign_tile(
                start, tile, label, dish, size, order, rank, k, concentration, prior, singleton_keeps,
                product, sums, work, generator,
            )  # fmt: skip
        loops.resample_dishes(dish, order, k, sums, table.log_prior, product, work, generator)
        loops.seat_to_candidate(label, dish, theta)
        total = 0.0
        for start, tile in table.tiles():
            total = loops.add_assigned(total, tile, theta[start : start + len(tile)])
        active_count = recount(theta, counts, active, place)
        joint = total + log_assignment_prior(counts, prior, concentration)
        record.sweep(s, keep[s], theta, active_count, total, joint)
