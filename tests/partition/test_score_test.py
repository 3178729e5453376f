"""The score test of one subgoal against mixtures found by brute force."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.partition.convex_weights import convex_weights
from subgoal.partition.score_test import score_test
from tests.oracles.convex_mixture import mixture_log_likelihood
from tests.partition.given_tables import directions, held, problems

PROBLEMS = dict(problems())
COST = np.array([[0.1, 0.9, 0.5], [0.2, 0.7, 0.4], [0.3, 1.1, 0.2], [0.9, 0.2, 0.8], [0.1, 0.6, 0.9], [0.2, 0.3, 0.35]])
"""Distances of six actions from those of three controllers; at confidence α the table is −α times them."""


def two_atoms_gain(table: np.ndarray, best: int) -> float:
    """How much some mixture of the best candidate and one other exceeds it, over weights down to 1e-9."""
    single = table[:, best].sum()
    gains = []
    for g in range(table.shape[1]):
        for t in np.geomspace(1e-9, 1.0, 2000):
            weights = np.zeros(table.shape[1])
            weights[best] += 1 - t
            weights[g] += t
            mixed = np.log1p(t * np.expm1(table[:, g] - table[:, best])).sum()
            gains.append(mixed)
            if t == 1.0:
                assert mixed == pytest.approx(mixture_log_likelihood(table, weights) - single, abs=1e-9)
    return max(gains)


def last_false(holds, low: float, high: float) -> float:
    """Where ``holds`` turns true between low and high, by halving."""
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return (low + high) / 2


def test_the_confidence_at_which_a_second_atom_helps_is_that_of_brute_force() -> None:
    """V10. A gain of 1e-15 at weight 1e-9 is a derivative of 1e-6, hence the tolerance."""
    by_score = last_false(lambda alpha: not score_test(held(-alpha * COST)).one_suffices, 0.01, 20.0)
    best = int(np.argmin(COST.sum(axis=0)))
    by_force = last_false(lambda alpha: two_atoms_gain(-alpha * COST, best) > 1e-15, 0.01, 20.0)
    assert 0.5 < by_score < 10
    assert by_score == pytest.approx(by_force, abs=2e-5)
    assert score_test(held(-(by_score - 1e-3) * COST)).one_suffices
    assert two_atoms_gain(-(by_score + 1e-2) * COST, best) > 1e-12


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_verdict_is_that_of_the_convex_weights(name: str) -> None:
    table = PROBLEMS[name]
    found = score_test(held(table))
    gain = convex_weights(held(table), gap=1e-11).upper_bound - table.sum(axis=0).max()
    assert found.log_likelihood == pytest.approx(table.sum(axis=0).max())
    if found.one_suffices:
        assert gain < 1e-8 * len(table)
    else:
        assert gain > 0


@pytest.mark.parametrize("confidence", [0.05, 1.0, 5.0])
def test_derivatives_are_those_of_differences(confidence: float) -> None:
    table = directions(40, 9, 1, confidence)
    found = score_test(held(table))
    for g in range(9):
        weights = 1e-7 * (np.arange(9) == g) + (1 - 1e-7) * (np.arange(9) == found.best)
        slope = (mixture_log_likelihood(table, weights) - found.log_likelihood) / 40e-7
        assert slope == pytest.approx(found.derivative[g], rel=1e-3, abs=1e-4)
    assert found.statistic == found.derivative.max()


def test_one_candidate_for_all_and_no_candidate_for_all() -> None:
    one = score_test(held(np.array([[-1.0, -2.0], [-3.0, -4.0]])))
    assert (one.best, one.one_suffices) == (0, True)
    none = score_test(held(np.array([[0.0, -np.inf], [-np.inf, 0.0]])))
    assert (none.best, none.one_suffices, none.log_likelihood) == (None, False, -np.inf)
    far = score_test(held(np.array([[0.0, -1e4], [-2e4, 0.0], [0.0, -2e4]])))
    assert far.statistic == np.inf and np.isfinite(far.log_ratio).all() and not far.one_suffices
