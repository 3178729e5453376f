"""Convex weights against an interior-point solver, their certificate, and candidates proved idle."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from subgoal.partition import scaled_table
from subgoal.partition.convex_weights import convex_weights
from subgoal.partition.outcome import Outcome
from subgoal.partition.scaled_table import ScaledTable
from subgoal.partition.screening import proved_idle
from subgoal.partition.simplex_newton import _curvature, nonnegative_quadratic
from subgoal.runtime.errors import InputError
from tests.oracles.convex_mixture import conic_optimum, expectation_maximisation, mixture_log_likelihood
from tests.partition.given_tables import directions, held, problems

PROBLEMS = dict(problems())


@cache
def conic_value(name: str) -> float:
    """log likelihood of the interior-point solver's weights, a lower bound of the optimum and near it."""
    return mixture_log_likelihood(PROBLEMS[name], conic_optimum(PROBLEMS[name]))


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_optimum_and_its_bound_against_an_interior_point_solver(name: str) -> None:
    table = PROBLEMS[name]
    ours = convex_weights(held(table), gap=1e-9)
    theirs = conic_value(name)
    n = len(table)
    rounding = 1e-12 * n * (1 + np.abs(table[np.isfinite(table)]).max())
    assert ours.outcome is Outcome.CONVERGED
    assert 0 <= ours.gap <= 1e-9 * n
    assert theirs <= ours.upper_bound + rounding
    assert ours.log_likelihood >= theirs - 1e-6 * n
    assert ours.log_likelihood == pytest.approx(mixture_log_likelihood(table, ours.weights), rel=1e-12, abs=1e-9)
    assert ours.weights.min() >= 0
    assert ours.weights.sum() == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("name", PROBLEMS)
def test_the_fitted_vector_is_that_of_every_optimum(name: str) -> None:
    """Where columns repeat the weights may differ, their mixture may not: |log r − log r*|² / 4 ≤ gap near it."""
    table = PROBLEMS[name]
    ours = convex_weights(held(table), gap=1e-10)
    with np.errstate(divide="ignore"):
        theirs = np.logaddexp.reduce(table + np.log(conic_optimum(table)), axis=1)
    assert np.abs(ours.fitted - theirs).max() < 2e-3


@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("rounds", [1, 2, 3])
def test_the_bound_holds_however_early_the_search_ends(name: str, rounds: int) -> None:
    table = PROBLEMS[name]
    early = convex_weights(held(table), gap=1e-11, most_iterations=rounds)
    best = conic_value(name)
    assert best <= early.upper_bound + 1e-12 * len(table) * (1 + abs(best))
    assert early.log_likelihood <= best + 1e-6 * len(table)
    assert early.outcome in (Outcome.OUT_OF_ITERATIONS, Outcome.CONVERGED)
    assert early.iterations == len(early.trace) <= rounds


def test_running_out_is_told_and_its_gap_is_not_small() -> None:
    early = convex_weights(held(directions(80, 60, 1)), most_iterations=1)
    assert early.outcome is Outcome.OUT_OF_ITERATIONS
    assert early.gap > 1e-6 * 80


def test_a_gap_below_rounding_is_stalled_or_reached_but_ends() -> None:
    found = convex_weights(held(directions(300, 90, 2)), gap=1e-300, most_iterations=200)
    assert found.outcome in (Outcome.STALLED, Outcome.CONVERGED)
    assert found.gap < 1e-9 * 300


def test_gradient_is_that_of_the_log_likelihood() -> None:
    table = directions(50, 12, 3)
    found = convex_weights(held(table), most_iterations=2, gap=1e-12)
    for g in range(12):
        towards = 1e-6 * (np.arange(12) == g)
        rise = mixture_log_likelihood(table, found.weights + towards) - found.log_likelihood
        assert rise / 1e-6 == pytest.approx(found.gradient[g], rel=1e-4)


def test_expectation_maximisation_comes_no_higher() -> None:
    table = directions(200, 40, 4)
    by_em = mixture_log_likelihood(table, expectation_maximisation(table, 3000))
    found = convex_weights(held(table), gap=1e-10)
    assert by_em <= found.upper_bound
    assert found.log_likelihood - by_em < 0.05


@pytest.mark.parametrize("seed", range(60))
def test_no_candidate_of_some_optimum_is_ever_proved_idle(seed: int) -> None:
    """From the first, rough weights to the last: the optimum's own support stays."""
    generator = np.random.default_rng(seed)
    if seed % 2:
        table = directions(int(generator.integers(20, 300)), int(generator.integers(3, 60)), seed)
    else:
        table = generator.normal(scale=2.0, size=(generator.integers(3, 200), generator.integers(2, 40)))
    exact = convex_weights(held(table), gap=1e-12)
    needed = exact.weights > 1e-6
    assert needed.any()
    for rounds in range(1, 6):
        assert not (convex_weights(held(table), gap=1e-12, most_iterations=rounds).idle & needed).any()
    scaled = ScaledTable(held(table))
    for share in (0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-6):
        # A point near the optimum, by its true gap: the smallest that may be certified.
        weights = (1 - share) * exact.weights + share * generator.dirichlet(np.ones(table.shape[1]))
        gap = max(exact.upper_bound - mixture_log_likelihood(table, weights), 0.0)
        fitted = scaled.fitted(weights)
        idle = proved_idle(scaled.gradient(fitted), *scaled.spread(fitted), len(table), gap)
        assert not (idle & needed).any()


def test_most_candidates_are_proved_idle_near_the_optimum() -> None:
    shares = [convex_weights(held(directions(2000, 200, seed)), gap=1e-9).idle.mean() for seed in range(5)]
    assert min(shares) > 0.8


def test_a_tiled_table_gives_the_same_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    table = directions(400, 30, 5)
    whole = convex_weights(held(table), gap=1e-9)
    monkeypatch.setattr(scaled_table, "GROUP", 1000)
    monkeypatch.setattr(ScaledTable.__init__, "__defaults__", (0,))
    tiled = convex_weights(held(table, dense_entries=0), gap=1e-9)
    assert tiled.log_likelihood == pytest.approx(whole.log_likelihood, abs=2e-9 * 400)
    np.testing.assert_allclose(tiled.gradient, whole.gradient, rtol=1e-3)
    np.testing.assert_array_equal(tiled.idle, whole.idle)
    fitted = np.exp(whole.fitted - table.max(axis=1))
    ratio = np.exp(table - whole.fitted[:, None])
    for scaled in (ScaledTable(held(table)), ScaledTable(held(table, dense_entries=0), 2**20)):
        squares, largest = scaled.spread(fitted)
        np.testing.assert_allclose(squares, (ratio**2).sum(axis=0), rtol=1e-12)
        np.testing.assert_allclose(largest, ratio.max(axis=0), rtol=1e-12)


@pytest.mark.parametrize(("size", "n"), [(1, 1), (2, 256), (5, 257), (8, 1000), (33, 70_000)])
def test_curvature_is_that_of_the_ratios(size: int, n: int) -> None:
    generator = np.random.default_rng(size)
    columns, fitted = generator.random((size, n)), generator.random(n) + 0.1
    found, slope = _curvature(columns, fitted)
    np.testing.assert_allclose(found, (columns / fitted) @ (columns / fitted).T, rtol=1e-11)
    np.testing.assert_allclose(slope, (columns / fitted).sum(axis=1), rtol=1e-11)


def test_the_quadratic_step_satisfies_its_own_conditions() -> None:
    for seed in range(40):
        generator = np.random.default_rng(seed)
        size = int(generator.integers(1, 25))
        factor = generator.normal(size=(size, generator.integers(1, 40)))
        if seed % 3 == 0:
            factor[-1] = factor[0]
        h, q = factor @ factor.T, factor @ generator.normal(size=factor.shape[1])
        x = nonnegative_quadratic(h, q, np.abs(generator.normal(size=size)))
        slope = h @ x - q
        scale = 1e-6 * (1 + np.abs(h).max() + np.abs(q).max())
        assert x.min() >= 0
        assert slope.min() > -scale
        assert np.abs(slope[x > 0]).max(initial=0.0) < scale


@pytest.mark.parametrize("wrong", [0, -1.0, np.nan, np.inf, "small"])
def test_gaps_that_are_none(wrong: object) -> None:
    with pytest.raises(InputError, match="gap"):
        convex_weights(held(np.zeros((2, 2))), gap=wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [0, 2.5, True])
def test_iterations_that_are_none(wrong: object) -> None:
    with pytest.raises(InputError, match="most_iterations"):
        convex_weights(held(np.zeros((2, 2))), most_iterations=wrong)  # type: ignore[arg-type]


def test_an_observation_that_nothing_allows_is_named() -> None:
    table = np.zeros((4, 3))
    table[2] = -np.inf
    with pytest.raises(InputError, match="observation 2"):
        convex_weights(held(table))


def test_the_table_is_left_as_it_was_and_the_answer_is_frozen() -> None:
    table = directions(30, 8, 6)
    likelihood, before = held(table), table.copy()
    found = convex_weights(likelihood)
    np.testing.assert_array_equal(table, before)
    with pytest.raises(ValueError, match="read-only"):
        found.weights[0] = 1.0
