"""The partition prior against enumeration of every partition: no seed, no threshold to argue about."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest

from subgoal.partition.crp import (
    expected_clusters,
    log_dirichlet_multinomial,
    log_eppf,
    variance_clusters,
)
from tests.oracles.partitions import (
    block_sizes,
    canonical,
    crp_probability,
    set_partitions,
    table_states,
    urn_probability,
)

BELL = (1, 1, 2, 5, 15, 52, 203, 877, 4140)
CONCENTRATIONS = (1e-3, 0.3, 1.0, 7.5, 1e4)


def probability(labels: tuple[int, ...], eta: float) -> float:
    return math.exp(log_eppf(block_sizes(labels), eta))


@pytest.mark.parametrize("n", range(9))
def test_the_oracle_lists_every_partition_once(n):
    listed = list(set_partitions(n))
    assert len(listed) == len(set(listed)) == BELL[n]
    assert all(canonical(labels) == labels for labels in listed)


@pytest.mark.parametrize("eta", CONCENTRATIONS)
@pytest.mark.parametrize("n", range(9))
def test_sums_to_one(n, eta):
    assert abs(math.fsum(probability(labels, eta) for labels in set_partitions(n)) - 1) <= 1e-12


@pytest.mark.parametrize("eta", CONCENTRATIONS)
def test_equals_the_chain_rule(eta):
    for labels in set_partitions(7):
        np.testing.assert_allclose(probability(labels, eta), crp_probability(labels, eta), rtol=1e-12)


@pytest.mark.parametrize("eta", [0.3, 7.5])
def test_exchangeable(eta):
    for labels in set_partitions(5):
        chain = [crp_probability(order, eta) for order in permutations(labels)]
        np.testing.assert_allclose(chain, probability(labels, eta), rtol=1e-13)


@pytest.mark.parametrize("eta", CONCENTRATIONS)
def test_consistent_when_a_customer_leaves(eta):
    """Summing out the last customer gives the prior of one fewer (a marginal, not a truncation)."""
    total: dict[tuple[int, ...], float] = {}
    for labels in set_partitions(6):
        total[labels[:-1]] = total.get(labels[:-1], 0.0) + probability(labels, eta)
    for labels, mass in total.items():
        np.testing.assert_allclose(mass, probability(labels, eta), rtol=1e-12)


@pytest.mark.parametrize("eta", CONCENTRATIONS)
@pytest.mark.parametrize("n", range(9))
def test_moments_of_the_number_of_tables(n, eta):
    tables = [(len(block_sizes(labels)), probability(labels, eta)) for labels in set_partitions(n)]
    mean = math.fsum(k * p for k, p in tables)
    variance = math.fsum((k - mean) ** 2 * p for k, p in tables)
    np.testing.assert_allclose(expected_clusters(n, eta), mean, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(variance_clusters(n, eta), variance, rtol=1e-10, atol=1e-12)


def test_the_number_quoted_for_a_large_concentration():
    """At η = 1e4 the prior alone expects 296 of 300 observations in their own cluster."""
    assert round(expected_clusters(300, 1e4)) == 296


@pytest.mark.parametrize("eta", [0.05, 1.0, 5.0])
def test_finite_base_is_the_dirichlet_multinomial(eta):
    """All 52 partitions of five, with every choice of three dishes, summed to the sequences of dishes."""
    prior = np.array([0.5, 0.3, 0.2])
    by_dishes: dict[tuple[int, ...], list[float]] = {}
    for labels, dishes in table_states(5, 3):
        served = tuple(dishes[table] for table in labels)
        weight = probability(labels, eta) * math.prod(prior[dish] for dish in dishes)
        by_dishes.setdefault(served, []).append(weight)
    assert len(by_dishes) == 3**5
    for served, weights in by_dishes.items():
        exact = math.exp(log_dirichlet_multinomial(np.bincount(served, minlength=3), eta, prior))
        np.testing.assert_allclose(exact, math.fsum(weights), rtol=1e-12)
        np.testing.assert_allclose(exact, urn_probability(served, eta, prior), rtol=1e-12)
