"""Every sampler gives one posterior: against each other, and where the answer is known beforehand."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from arviz_stats import base

from subgoal import samplers
from subgoal.partition.protocol import Chain
from tests.exact.test_compiled_steps import likelihood_of
from tests.oracles.finite_mixture import distinct_law
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

ALL = [
    samplers.alg4_corrected, samplers.collapsed_blocks, samplers.blocked, samplers.collapsed,
    samplers.cluster_collapsed, samplers.split_merge, samplers.tempered,
]  # fmt: skip
SUMMARIES = ("log joint", "K", "share 1", "share 2", "share 3")


def name_of(sampler) -> str:
    return sampler.__name__


def directions(n: int = 60, g_count: int = 17, confidence: float = 3.0) -> np.ndarray:
    """(N, G) log densities −α‖u − û_g‖ of ways in the plane: four goals visited, the other places stand about."""
    generator = np.random.default_rng(4)
    places = np.vstack([[[0, 0], [10, 0], [0, 10], [10, 10]], generator.uniform(-1, 11, (g_count - 4, 2))])
    states = generator.uniform(-1, 11, (n, 2))
    ways = places[None] - states[:, None]
    ways /= np.linalg.norm(ways, axis=2, keepdims=True)
    goal = generator.choice(4, n, p=[0.4, 0.3, 0.2, 0.1])
    turn = generator.laplace(scale=1 / confidence, size=n)
    way = ways[np.arange(n), goal]
    taken = np.column_stack([
        way[:, 0] * np.cos(turn) - way[:, 1] * np.sin(turn), way[:, 0] * np.sin(turn) + way[:, 1] * np.cos(turn)
    ])  # fmt: skip
    return -confidence * np.linalg.norm(taken[:, None] - ways, axis=2)


def summaries(sampler, table: np.ndarray, prior: np.ndarray, eta: float, sweeps: int) -> np.ndarray:
    """(summaries, 4 chains, sweeps) of label-invariant summaries after a tenth as many sweeps left out."""
    likelihood, chains, g_count = likelihood_of(table, prior), [], len(prior)
    for k in range(4):
        keep = np.arange(sweeps * 11 // 10) >= sweeps // 10
        drawn = sampler(Chain(likelihood, eta, np.random.default_rng([9, k])), keep)
        cells = drawn.assignments + g_count * np.arange(sweeps)[:, None]
        counts = np.bincount(cells.ravel(), minlength=g_count * sweeps).reshape(sweeps, g_count)
        largest = np.zeros((sweeps, 3))
        ordered = np.sort(counts, axis=1)[:, ::-1][:, :3] / len(table)
        largest[:, : ordered.shape[1]] = ordered
        chains.append(np.vstack([drawn.log_joint[keep], drawn.n_active[keep], largest.T]))
    return np.stack(chains, axis=1)


def mean_and_error(values: np.ndarray) -> tuple[float, float]:
    """Mean of (chains, draws) values and its Monte-Carlo standard error."""
    worth = float(base.array_stats.ess(values, method="mean"))
    return float(values.mean()), float(values.std() / np.sqrt(worth))


@pytest.fixture(scope="module")
def found() -> dict[str, np.ndarray]:
    table, prior = directions(), np.arange(17, 0, -1) / 153
    return {name_of(sampler): summaries(sampler, table, prior, 2.0, 5000) for sampler in ALL}


@pytest.mark.parametrize(("one", "other"), list(combinations(map(name_of, ALL), 2)))
def test_two_samplers_one_posterior(one: str, other: str, found: dict[str, np.ndarray]) -> None:
    """Within 5 Monte-Carlo standard errors on each of five summaries; level 6e-7 each."""
    for k, what in enumerate(SUMMARIES):
        (a, error_a), (b, error_b) = (mean_and_error(found[name][k]) for name in (one, other))
        assert abs(a - b) <= 5 * np.hypot(error_a, error_b), what


@pytest.mark.parametrize("sampler", ALL, ids=name_of)
def test_a_flat_table_gives_the_prior(sampler) -> None:
    """The mean number of candidates in use is that of the prior, within 5 standard errors."""
    prior, eta = np.array([0.4, 0.3, 0.15, 0.1, 0.05]), 1.5
    mean, error = mean_and_error(summaries(sampler, np.full((20, 5), -3.0), prior, eta, 5000)[1])
    assert abs(mean - distinct_law(20, eta, prior) @ np.arange(6)) <= 5 * error


def variation(sampler, table: np.ndarray, prior: np.ndarray, into: list[int], law: dict) -> tuple[float, float]:
    """Total variation of 60,000 sweeps from the law of places, and 3 times that of a tenth as many true draws."""
    eta, sweeps, g_count = 1.0, 60_000, 3
    digits = g_count ** np.arange(len(table))
    pi = np.zeros(g_count ** len(table))
    pi[[np.dot(state, digits) for state in law]] = list(law.values())
    drawn = sampler(Chain(likelihood_of(table, prior), eta, np.random.default_rng(7)), np.ones(sweeps, bool))
    reached = np.bincount(np.array(into)[drawn.assignments] @ digits, minlength=pi.size) / sweeps
    true = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    return 0.5 * np.abs(reached - pi).sum(), 3 * float(np.mean(0.5 * np.abs(true - pi).sum(axis=1)))


@pytest.mark.parametrize("sampler", ALL, ids=name_of)
def test_a_candidate_twice_at_half_its_prior_changes_nothing_about_places(sampler) -> None:
    table = TABLES["generic"]
    law = assignment_posterior(table, 1.0, PRIOR)
    twice, halves = table[:, [0, 0, 1, 2]], np.array([0.25, 0.25, 0.3, 0.2])
    distance, limit = variation(sampler, twice, halves, [0, 0, 1, 2], law)
    assert distance <= limit


@pytest.mark.parametrize("sampler", ALL, ids=name_of)
def test_one_observation_is_drawn_from_prior_times_likelihood(sampler) -> None:
    table = TABLES["generic"][:1]
    weight = PRIOR * np.exp(table[0])
    law = {(g,): p for g, p in enumerate(weight / weight.sum())}
    distance, limit = variation(sampler, table, PRIOR, [0, 1, 2], law)
    assert distance <= limit


@pytest.mark.parametrize("sampler", ALL, ids=name_of)
def test_one_candidate_explains_everything(sampler) -> None:
    table = np.log([[0.3], [0.9], [0.2]])
    drawn = sampler(Chain(likelihood_of(table, np.ones(1)), 1.0, np.random.default_rng(1)), np.ones(50, bool))
    assert not drawn.assignments.any()
    assert (drawn.n_active == 1).all()
    np.testing.assert_allclose(drawn.log_joint, table.sum(), rtol=1e-13)


@pytest.mark.parametrize("eta", [1e-6, 1e6])
@pytest.mark.parametrize("sampler", ALL, ids=name_of)
def test_extreme_numbers_stay_possible(sampler, eta: float) -> None:
    """Confidence beyond reason and concentrations far from 1: every draw is possible, every trace finite."""
    generator = np.random.default_rng(3)
    table = 1e6 * generator.normal(size=(30, 8))
    table[generator.random(table.shape) < 0.3] = -np.inf
    table[np.arange(30), generator.integers(0, 8, 30)] = -1e5
    drawn = sampler(Chain(likelihood_of(table, np.full(8, 1 / 8)), eta, generator), np.ones(300, bool))
    assert np.isfinite(drawn.log_joint).all()
    assert np.isfinite(table[np.arange(30), drawn.assignments]).all()
    best = table.max(axis=1)
    assert (drawn.log_likelihood <= best.sum() + 1e-6).all()
