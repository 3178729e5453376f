"""Committed likelihood tables and the posterior over them by enumeration. Imports nothing from the package."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from tests.oracles.partitions import crp_probability, table_states, urn_probability

PRIOR = np.array([0.5, 0.3, 0.2])
"""Uneven, so that a forgotten prior shows."""
GENERIC = np.log(np.array([[0.7, 0.2, 0.4], [0.1, 0.6, 0.3], [0.5, 0.4, 0.9], [0.2, 0.8, 0.1]]))
PEAKED = np.log(np.array([[0.98, 0.01, 0.01], [0.01, 0.97, 0.02], [0.02, 0.01, 0.97], [0.96, 0.02, 0.02]]))
TABLES = {"generic": GENERIC, "peaked": PEAKED}


def assignment_posterior(log_table: np.ndarray, eta: float, prior: Sequence[float]) -> dict[tuple[int, ...], float]:
    """p(θ | O) over all G^N assignments of candidates."""
    n, g_count = log_table.shape
    weight = {}
    for theta in itertools.product(range(g_count), repeat=n):
        likelihood = np.exp(sum(log_table[i, g] for i, g in enumerate(theta)))
        weight[theta] = urn_probability(theta, eta, prior) * likelihood
    total = sum(weight.values())
    return {theta: value / total for theta, value in weight.items()}


def table_posterior(log_table: np.ndarray, eta: float, prior: Sequence[float]) -> dict[tuple, float]:
    """p(z, g | O) over all partitions and dishes, states as (labels, dishes)."""
    n, g_count = log_table.shape
    weight = {}
    for labels, dishes in table_states(n, g_count):
        likelihood = np.exp(sum(log_table[i, dishes[label]] for i, label in enumerate(labels)))
        weight[labels, dishes] = crp_probability(labels, eta) * np.prod([prior[g] for g in dishes]) * likelihood
    total = sum(weight.values())
    return {state: value / total for state, value in weight.items()}
