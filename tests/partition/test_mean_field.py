"""Variational Bayes against the evidence by enumeration."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import digamma

from subgoal.partition import row_blocks
from subgoal.partition.mean_field import mean_field
from subgoal.partition.outcome import Outcome
from subgoal.runtime.errors import InputError
from tests.oracles.convex_mixture import log_evidence
from tests.partition.given_tables import directions, held, problems

PROBLEMS = dict(problems())
PRIOR = np.array([0.5, 0.3, 0.2])


def small(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(scale=2.0, size=(6, 3))


@pytest.mark.parametrize("concentration", [0.01, 0.3, 1.0, 5.0, 1e4])
@pytest.mark.parametrize("seed", range(6))
def test_the_bound_is_below_the_evidence_and_near_it(seed: int, concentration: float) -> None:
    table = small(seed)
    evidence = log_evidence(table, concentration * PRIOR)
    found = mean_field(held(table, PRIOR), concentration, tolerance=1e-12)
    assert found.evidence_bound <= evidence + 1e-10
    # A local optimum: with η = 0.01 the start keeps candidates open that the prior would rather have shut.
    assert evidence - found.evidence_bound < (5.0 if concentration < 0.1 else 3.0)
    for seed_of_start in range(5):
        start = np.random.default_rng(seed_of_start).dirichlet(np.ones(3))
        other = mean_field(held(table, PRIOR), concentration, start=start, most_iterations=3)
        assert other.evidence_bound <= evidence + 1e-10


def test_with_known_weights_the_bound_is_the_evidence() -> None:
    """η → ∞ fixes the weights at the prior."""
    table = small(9)
    found = mean_field(held(table, PRIOR), 1e9, tolerance=1e-14)
    assert found.evidence_bound == pytest.approx(np.logaddexp.reduce(table + np.log(PRIOR), axis=1).sum(), abs=1e-6)


def test_one_observation_on_one_candidate_is_exact() -> None:
    assert mean_field(held(np.array([[-2.5]])), 0.7).evidence_bound == pytest.approx(-2.5, abs=1e-12)


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("concentration", [0.05, 2.0])
def test_the_bound_never_falls(name: str, concentration: float) -> None:
    table = PROBLEMS[name]
    g_count = table.shape[1]
    for start in (None, np.full(g_count, 1 / g_count)):
        found = mean_field(held(table), concentration, start=start, tolerance=0.0, most_iterations=100)
        assert np.diff(found.trace).min(initial=0.0) >= -1e-12 * (1 + np.abs(found.trace).max())


def test_the_answer_is_a_fixed_point() -> None:
    table = directions(120, 15, 2)
    found = mean_field(held(table), 1.5, tolerance=1e-13, most_iterations=20000)
    assert found.outcome is Outcome.CONVERGED
    share = np.exp(table + digamma(found.shape))
    share /= share.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(found.shape, 0.1 + share.sum(axis=0), atol=1e-3)
    np.testing.assert_allclose(found.responsibilities(table), share, atol=1e-10)
    np.testing.assert_allclose(found.counts, share.sum(axis=0), atol=1e-8)
    assert found.shape.sum() == pytest.approx(121.5)
    assert found.weights.sum() == pytest.approx(1)


def test_running_out_is_told() -> None:
    found = mean_field(held(directions(100, 20, 3)), 1.0, tolerance=0.0, most_iterations=2)
    assert found.outcome is Outcome.OUT_OF_ITERATIONS
    assert found.iterations == 2


def test_a_tiled_table_gives_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    table, start = directions(300, 20, 4), np.full(20, 0.05)
    whole = mean_field(held(table), 1.0, start=start)
    monkeypatch.setattr(row_blocks, "GROUP", 500)
    tiled = mean_field(held(table, dense_entries=0), 1.0, start=start)
    np.testing.assert_allclose(tiled.shape, whole.shape, rtol=1e-9)
    assert tiled.evidence_bound == pytest.approx(whole.evidence_bound, rel=1e-12)


@pytest.mark.parametrize("start", [[1.0], [0.5, 0.6], [1.5, -0.5], [np.nan, 1.0], "x"])
def test_starts_that_are_none(start: object) -> None:
    with pytest.raises(InputError, match="start"):
        mean_field(held(np.zeros((3, 2))), 1.0, start=start)


@pytest.mark.parametrize("wrong", [0, -1.0, np.nan, 1e-300])
def test_concentrations_that_are_none(wrong: float) -> None:
    with pytest.raises(InputError, match="concentration"):
        mean_field(held(np.zeros((3, 2))), wrong)


def test_an_observation_that_nothing_allows_is_told() -> None:
    table = np.zeros((4, 3))
    table[2] = -np.inf
    with pytest.raises(InputError, match="observations 0 to 3"):
        mean_field(held(table), 1.0, start=np.full(3, 1 / 3))
