"""Sampler ``split_merge``: ``collapsed_blocks`` with proposals to split a table in two or to make one of two."""

from __future__ import annotations

import numpy as np

from subgoal._kernels import split_merge as loops
from subgoal.partition.protocol import FIRST_TABLES, Chain, Recorder, Stretch, Table, starting_assignment
from subgoal.runtime.checks import Bools, Floats
from subgoal.runtime.errors import InputError

PROPOSALS = 1
"""Split-merge proposals in a sweep; each goes over the rows of two tables twice."""


def split_merge(chain: Chain, keep: Bools) -> Stretch:
    """Advance one chain by ``len(keep)`` sweeps of ``collapsed_blocks`` with split-merge proposals among them.

    After observations are seated at tables, and before tables redraw their candidate, two observations are drawn: if
    they sit together their table is proposed to be split, else theirs to be merged. Candidates are summed out, and
    the split is proposed by one restricted Gibbs scan from a launch state made observation by observation (Jain &
    Neal 2004; Dahl 2005). Exact: Metropolis-Hastings on p(z | O).

    Raises ``InputError`` for a table that is not held whole: a proposal needs rows from everywhere.
    """
    table = chain.table
    dense, relative = held(table, "split_merge")
    theta = np.array((chain.state or {"theta": starting_assignment(table, chain.generator)})["theta"], np.int32)
    record = Recorder(table, keep)
    loops.sweeps_dense(
        dense, relative, table.edges, np.exp(table.log_prior), table.log_prior, chain.concentration, PROPOSALS, theta,
        np.empty((FIRST_TABLES, table.n_candidates)), keep, record.kept, record.log_likelihood, record.log_joint,
        record.n_active, chain.generator,
    )  # fmt: skip
    return record.stretch({"theta": theta})


def held(table: Table, sampler: str) -> tuple[Floats, Floats]:
    """The whole table and its rows relative to their marginals. Raises ``InputError`` when it is tiled."""
    dense, relative = table.dense, table.relative
    if dense is None or relative is None:
        raise InputError(
            "likelihood", found=f"a table of {table.n_observations} × {table.n_candidates} computed in tiles",
            wanted=f"one held whole, for the sampler {sampler}",
            hint="the sampler collapsed_blocks, a larger dense_entries, or fewer candidates",
        )  # fmt: skip
    return dense, relative
