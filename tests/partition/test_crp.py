"""The prior's draws against its own law, its limits, and bad input."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from scipy.stats import chisquare

from subgoal.partition.crp import (
    draw_partition,
    expected_clusters,
    log_dirichlet_multinomial,
    log_eppf,
    variance_clusters,
)
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream
from tests.oracles.partitions import crp_probability, set_partitions

LEVEL = 3e-6


@pytest.mark.parametrize("eta", [0.4, 1.0, 6.0])
def test_draws_follow_the_prior(eta):
    """20,000 draws over 52 partitions: finds a total variation of 0.03 and more."""
    generator = stream(11, round(10 * eta))
    seen = Counter(tuple(int(k) for k in draw_partition(5, eta, generator)) for _ in range(20_000))
    states = list(set_partitions(5))
    assert set(seen) <= set(states)
    expected = np.array([crp_probability(labels, eta) for labels in states])
    counts = np.array([seen[labels] for labels in states])
    assert chisquare(counts, 20_000 * expected / expected.sum()).pvalue > LEVEL


def test_limits():
    assert draw_partition(0, 1.0, stream(0)).size == 0
    assert log_eppf([], 2.0) == 0.0
    assert expected_clusters(0, 1.0) == variance_clusters(0, 1.0) == 0.0
    assert expected_clusters(1, 1e-9) == 1.0
    assert np.array_equal(draw_partition(50, 1e-12, stream(1)), np.zeros(50))
    assert np.array_equal(draw_partition(50, 1e12, stream(1)), np.arange(50))


def test_a_candidate_of_no_probability_is_impossible():
    assert log_dirichlet_multinomial([1, 2], 1.0, [1.0, 0.0]) == -np.inf
    assert log_dirichlet_multinomial([3, 0], 1.0, [1.0, 0.0]) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("eta", [0.0, -1.0, np.nan, np.inf, "many", None])
def test_concentration_is_checked(eta):
    for call in (
        lambda: log_eppf([1, 2], eta),
        lambda: expected_clusters(3, eta),
        lambda: variance_clusters(3, eta),
        lambda: draw_partition(3, eta, stream(0)),
        lambda: log_dirichlet_multinomial([1, 2], eta, [0.5, 0.5]),
    ):
        with pytest.raises(InputError, match="concentration"):
            call()


@pytest.mark.parametrize("sizes", [[0, 1], [1.5], [-1], [np.nan], [[1, 2]], "ab"])
def test_block_sizes_are_checked(sizes):
    with pytest.raises(InputError, match="block_sizes"):
        log_eppf(sizes, 1.0)


@pytest.mark.parametrize("n", [-1, 2.5, np.nan, True])
def test_the_number_of_customers_is_checked(n):
    for call in (lambda: expected_clusters(n, 1.0), lambda: draw_partition(n, 1.0, stream(0))):
        with pytest.raises(InputError, match="n"):
            call()


@pytest.mark.parametrize(
    ("counts", "prior", "named"),
    [
        ([1, -1], [0.5, 0.5], "counts"),
        ([1, 0.5], [0.5, 0.5], "counts"),
        ([1, np.nan], [0.5, 0.5], "counts"),
        ([1, 2], [0.5, 0.5, 0.0], "prior"),
        ([1, 2], [0.5, 0.6], "prior"),
        ([1, 2], [-0.5, 1.5], "prior"),
        ([1, 2], [np.nan, 1.0], "prior"),
    ],
)
def test_dishes_are_checked(counts, prior, named):
    with pytest.raises(InputError, match=named):
        log_dirichlet_multinomial(counts, 1.0, prior)
