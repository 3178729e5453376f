"""Bayesian inverse reinforcement learning: its draws against enumeration, its summaries, its optimum, bad input."""

from __future__ import annotations

import itertools
import warnings

import numpy as np
import pytest
from scipy.special import softmax

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bayesian import anneal_reward, bayesian_irl, cooling
from subgoal.irl.reward_priors import Gaussian
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.errors import InputError
from tests.irl.test_reward_walk import (
    ACTIONS,
    CONFIDENCE,
    DISCOUNT,
    LEVELS,
    LOG_PRIOR,
    STATES,
    STEP,
    TRANSITION,
    WORLD,
    Levels,
    Wide,
)
from tests.oracles import rewards as oracle


class Alone:
    """One level and nothing else."""

    start = 0.0

    def log_density(self, values: np.ndarray) -> np.ndarray:
        return np.where(values == 0, 0.0, -np.inf)


DEMOS = Demonstrations.from_arrays(STATES, ACTIONS)
SETTINGS = {"prior": Levels(), "confidence": CONFIDENCE, "step": STEP}


def fitted(**changes):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return bayesian_irl(DEMOS, WORLD, **({"draws": 200, "warmup": 50} | SETTINGS | changes))


@pytest.fixture(scope="module")
def long():
    return fitted(draws=4_000, warmup=200, thin=2)


@pytest.fixture(scope="module")
def exact():
    return oracle.posterior(
        TRANSITION, DISCOUNT, STATES, ACTIONS, CONFIDENCE, "product", np.eye(4), LEVELS, LOG_PRIOR
    )  # fmt: skip


def test_draws_have_the_enumerated_posterior(long, exact) -> None:
    """Total variation at most 3 times that of as many independent draws as the run is worth (a fifth)."""
    levels = np.rint(long.weights.reshape(-1, 4) / STEP).astype(int) + 1
    seen: dict[tuple[int, ...], int] = {}
    for row in levels:
        seen[tuple(row)] = seen.get(tuple(row), 0) + 1
    pi = np.array(list(exact.values()))
    distance = sum(abs(seen.get(p, 0) / len(levels) - q) for p, q in exact.items()) / 2
    independent = np.random.default_rng(0).multinomial(len(levels) // 5, pi, size=50) / (len(levels) // 5)
    assert distance <= 3 * np.abs(independent - pi).sum(axis=1).mean() / 2
    assert long.status is Status.CONVERGED
    assert 0 < long.error_bound <= 1e-12


def test_summaries_are_those_of_the_enumerated_posterior(long, exact) -> None:
    """Mean within 6 standard errors (of a fifth of the draws)."""
    points = np.array(list(itertools.product(LEVELS, repeat=4)))
    pi = np.array([exact[tuple(LEVELS.index(v) for v in point)] for point in points])
    mean = pi @ points
    error = np.sqrt(pi @ (points - mean) ** 2 / (long.weights.size / 4 / 5))
    assert (np.abs(long.mean_reward - mean) <= 6 * error).all()
    low, high = long.interval(0.9)
    assert ((low <= mean) & (mean <= high)).all()


def test_the_predictive_distribution_is_the_mean_over_the_draws() -> None:
    found = fitted(draws=60)
    tables = [
        softmax(CONFIDENCE * DISCOUNT * TRANSITION @ oracle.optimal_values(TRANSITION, reward, DISCOUNT), axis=1)
        for reward in found.weights.reshape(-1, 4)
    ]
    np.testing.assert_allclose(found.predictive, np.mean(tables, axis=0), atol=1e-12)


def test_the_policy_is_optimal_for_the_mean_reward(long) -> None:
    ahead = TRANSITION @ oracle.optimal_values(TRANSITION, long.mean_reward, DISCOUNT)
    np.testing.assert_array_equal(long.policy.argmax(axis=1), ahead.argmax(axis=1))
    np.testing.assert_allclose(long.policy.sum(axis=1), 1)
    point = long.point()
    np.testing.assert_array_equal(point.policy, long.policy)
    assert "Ramachandran" in point.reference


def test_no_more_workers_and_the_same_seed_give_the_same_draws() -> None:
    one, two = (fitted(workers=k, chains=3) for k in (1, 2))
    np.testing.assert_array_equal(one.weights, two.weights)
    np.testing.assert_array_equal(fitted(chains=2).weights, one.weights[:2])
    assert (one.weights[1] != one.weights[2]).any()
    assert (fitted(seed=1).weights[0] != one.weights[0]).any()


def test_a_chain_too_short_says_so() -> None:
    with pytest.warns(ConvergenceWarning):
        found = bayesian_irl(DEMOS, WORLD, draws=20, warmup=0, **SETTINGS)
    assert found.status is Status.NOT_CONVERGED
    assert fitted(chains=1).status is Status.FEW_CHAINS


@pytest.mark.filterwarnings("ignore:NOT CONVERGED")
def test_a_chain_that_hardly_moves_says_what_to_try() -> None:
    """Steps of 50 under a normal law of scale 1: not one is accepted, and all chains agree."""
    one = {"prior": Gaussian(1.0), "step": 50.0, "relevance": [1.0, 0.0, 0.0, 0.0]}
    with pytest.warns(ConvergenceWarning, match=r"accepted 0.00% .* Try: step=5, or a smaller confidence"):
        found = bayesian_irl(DEMOS, WORLD, draws=50, warmup=50, **SETTINGS | one)
    assert found.acceptance.min() == 0
    assert found.status is Status.NOT_CONVERGED
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        bayesian_irl(DEMOS, WORLD, draws=50, warmup=50, **SETTINGS)
    assert not [each for each in told if "accepted" in str(each.message)]


def test_chains_that_never_moved_have_not_converged() -> None:
    """All of them stand where the prior is highest: to the gate they look alike."""
    found = fitted(prior=Alone(), relevance=[1.0, 0.0, 0.0, 0.0])
    assert all(each.passes for each in found.diagnostics.values())
    assert found.status is Status.NOT_CONVERGED


def test_what_is_never_proposed_stays_at_the_mode_of_the_prior() -> None:
    found = fitted(relevance=[1.0, 0.0, 1.0, 0.0], draws=300)
    assert (found.weights[:, :, [1, 3]] == 0).all()
    assert (found.weights[:, :, [0, 2]] != 0).any(axis=(0, 1)).all()
    assert not any("weight 1" in name for name in found.diagnostics)


def test_annealing_finds_the_likeliest_reward_and_is_not_called_a_posterior(exact) -> None:
    best = max(exact, key=lambda point: exact[point])
    found = anneal_reward(DEMOS, WORLD, steps=3_000, schedule=cooling(1.0, 1 / 50), seed=2, **SETTINGS)
    np.testing.assert_allclose(found.reward, [LEVELS[k] for k in best])
    assert found.outcome is Outcome.OUT_OF_ITERATIONS
    assert found.trace.shape == (3_000, 4)
    assert (np.abs(np.diff(found.trace[-500:], axis=0)) > 0).any(axis=1).mean() < 0.2
    assert "annealed" in found.method


def test_annealing_keeps_the_best_it_saw() -> None:
    """A hot chain leaves the best reward again."""
    found = anneal_reward(DEMOS, WORLD, steps=400, schedule=lambda i: 0.2 + 0 * i, **SETTINGS)
    heights = [
        oracle.log_likelihood(TRANSITION, reward, DISCOUNT, STATES, ACTIONS, CONFIDENCE, "product")
        + Levels().log_density(reward).sum()
        for reward in found.trace
    ]
    np.testing.assert_allclose(found.reward, found.trace[int(np.argmax(heights))])
    assert heights[-1] < max(heights)


def test_cooling_is_that_of_the_thesis() -> None:
    np.testing.assert_allclose(cooling()(np.array([0.0, 50.0, 1200.0])), [25, 26, 49])


def test_a_hot_chain_moves_more_than_a_cold_one() -> None:
    settings = SETTINGS | {"prior": Wide(), "steps": 2_000}
    hot, cold = (anneal_reward(DEMOS, WORLD, schedule=lambda i, h=h: h + 0 * i, **settings) for h in (0.0, 50.0))
    moved = [(np.diff(found.trace, axis=0) != 0).any(axis=1).mean() for found in (hot, cold)]
    assert moved[0] == 1.0
    assert moved[1] < 0.5


def test_features_that_do_not_determine_the_reward_are_told() -> None:
    features = np.column_stack([np.ones(4), np.arange(4.0)])
    with pytest.warns(ConvergenceWarning):
        found = bayesian_irl(DEMOS, WORLD, features, draws=50, warmup=0, **SETTINGS | {"prior": Wide()})
    np.testing.assert_allclose(np.abs(found.undetermined[:, 0]), [1, 0], atol=1e-12)


BAD = {
    "demonstrations": lambda: bayesian_irl(Demonstrations.from_arrays([0], [7]), WORLD, **SETTINGS),
    "observation": lambda: bayesian_irl(
        Demonstrations(np.array([0, 0]), np.array([0, 0]), np.array([0, 2])),
        TabularMDP.from_dense(np.eye(2)[[[1], [0]]], 0.5), **SETTINGS
    ),
    "features": lambda: bayesian_irl(DEMOS, WORLD, np.full((4, 2), np.nan), **SETTINGS),
    "prior": lambda: bayesian_irl(DEMOS, WORLD, prior="flat"),
    "step": lambda: bayesian_irl(DEMOS, WORLD, prior=Wide(), step=float("nan")),
    "confidence": lambda: bayesian_irl(DEMOS, WORLD, prior=Wide(), confidence=-1),
    "likelihood": lambda: bayesian_irl(DEMOS, WORLD, prior=Wide(), likelihood="sum"),
    "draws": lambda: bayesian_irl(DEMOS, WORLD, prior=Wide(), draws=0),
    "schedule": lambda: anneal_reward(DEMOS, WORLD, prior=Wide(), schedule=lambda i: i * np.nan),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_bad_input_is_named(what: str) -> None:
    with pytest.raises(InputError, match=what):
        BAD[what]()
