"""The law of one sweep of a shipped sampler, by replay; and committed tables with impossible entries."""

from __future__ import annotations

import numpy as np

from subgoal import samplers
from subgoal._kernels import blocked, cluster_collapsed, collapsed, split_merge, tempered
from subgoal.partition.alg4 import seated
from subgoal.partition.protocol import Chain
from tests.exact.replay import outcomes
from tests.oracles.tables import TABLES, table_posterior

LOOPS = {
    samplers.blocked: blocked,
    samplers.collapsed: collapsed,
    samplers.cluster_collapsed: cluster_collapsed,
    samplers.split_merge: split_merge,
    samplers.tempered: tempered,
}
"""The module of each sampler's loops."""
MORE = list(LOOPS)
WALLED = TABLES["generic"].copy()
WALLED[0, 1] = WALLED[2, 2] = WALLED[3, 0] = WALLED[3, 2] = -np.inf
WITH_WALLS = {**TABLES, "walled": WALLED}


def state_at(sampler, theta) -> dict[str, np.ndarray]:
    """The state of a sampler at assignment θ; one table per candidate, all levels alike."""
    theta = np.array(theta, np.int32)
    if sampler is samplers.cluster_collapsed:
        return seated(theta)
    if isinstance(sampler, samplers.Tempering):
        return {"theta": theta, "hotter": np.tile(theta, (len(sampler.powers) - 1, 1))}
    return {"theta": theta}


def sweep_law(sampler, theta, likelihood, eta: float) -> dict[tuple[int, ...], float]:
    """Law of the assignment after one sweep from the state at θ."""

    def move() -> tuple[int, ...]:
        after = sampler(Chain(likelihood, eta, None, state_at(sampler, theta)), np.ones(1, bool))
        return tuple(after.assignments[0].tolist())

    return outcomes(LOOPS[sampler], move)


def partition_posterior(log_table: np.ndarray, eta: float, prior: np.ndarray) -> dict[tuple[int, ...], float]:
    """p(z | O) over all set partitions that are possible, as labels in order of first appearance."""
    law: dict[tuple[int, ...], float] = {}
    for (labels, _), weight in table_posterior(log_table, eta, prior).items():
        if weight > 0:
            law[labels] = law.get(labels, 0.0) + weight
    return law
