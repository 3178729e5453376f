"""What samplers whose state is the assignment alone have in common."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from subgoal.partition.protocol import Chain, Int32s, Recorder, Stretch, starting_assignment
from subgoal.runtime.checks import Bools


def advance_assignment(
    chain: Chain,
    keep: Bools,
    dense: Callable[..., object],
    tiled: Callable[[Chain, Int32s, Bools, Recorder], None],
) -> Stretch:
    """Advance θ by compiled loops over the whole table, or by those that go through it tile by tile."""
    table = chain.table
    theta = np.array((chain.state or {"theta": starting_assignment(table, chain.generator)})["theta"], np.int32)
    record = Recorder(table, keep)
    if table.dense is None:
        tiled(chain, theta, keep, record)
    else:
        dense(
            table.dense, table.relative, np.exp(table.log_prior), chain.concentration, theta, keep, record.kept,
            record.log_likelihood, record.log_joint, record.n_active, chain.generator,
        )  # fmt: skip
    return record.stretch({"theta": theta})
