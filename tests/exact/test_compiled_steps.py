"""The compiled loops against their Python form, against their exact law, and tiles against the whole table."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from subgoal import samplers
from subgoal._kernels import alg4, collapsed_blocks
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Chain
from tests.exact.replay import outcomes, python_form
from tests.exact.test_transition_collapsed_blocks import sweep
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

SMALL_PRIOR = np.array([0.7, 0.3])
SHIPPED = [samplers.collapsed_blocks, samplers.alg4_corrected]


def likelihood_of(table: np.ndarray, prior: np.ndarray, **fields: int) -> LogLikelihood:
    points = np.arange(len(prior), dtype=float)[:, None]
    return LogLikelihood.from_table(table, candidates=Candidates(points, np.log(prior)), **fields)


def wide_table(n: int = 60, g_count: int = 17) -> np.ndarray:
    return np.random.default_rng(5).normal(scale=2.0, size=(n, g_count))


@pytest.mark.parametrize("sampler", [*SHIPPED, samplers.alg4_literal], ids=lambda s: s.__name__)
def test_tiled_table_gives_the_draws_of_the_whole_one(sampler) -> None:
    table, prior, keep = wide_table(), np.full(17, 1 / 17), np.ones(30, bool)
    whole, tiled = likelihood_of(table, prior), likelihood_of(table, prior, dense_entries=50)
    assert whole.is_dense
    assert tiled.dense is None
    answers = [sampler(Chain(each, 3.0, np.random.default_rng(2)), keep) for each in (whole, tiled)]
    np.testing.assert_array_equal(answers[0].assignments, answers[1].assignments)
    np.testing.assert_array_equal(answers[0].log_joint, answers[1].log_joint)


@pytest.mark.parametrize(("sampler", "module"), list(zip(SHIPPED, [collapsed_blocks, alg4], strict=True)))
def test_compiled_is_the_python_form_bit_for_bit(sampler, module) -> None:
    keep, likelihood = np.ones(4, bool), likelihood_of(wide_table(12, 5), np.full(5, 0.2))
    compiled = sampler(Chain(likelihood, 2.0, np.random.default_rng(3)), keep)
    with python_form(module):
        plain = sampler(Chain(likelihood, 2.0, np.random.default_rng(3)), keep)
    np.testing.assert_array_equal(compiled.assignments, plain.assignments)
    np.testing.assert_allclose(compiled.log_joint, plain.log_joint, rtol=1e-14)


def test_compiled_steps_follow_their_exact_law() -> None:
    """10,000 one-sweep draws from every state, pooled chi-square; level 1e-6, notices cell errors of about 0.02."""
    table, eta, draws = TABLES["generic"][:3, :2], 1.0, 10_000
    likelihood = likelihood_of(table, SMALL_PRIOR)
    generator = np.random.default_rng(11)
    statistic, freedom = 0.0, 0
    for state in assignment_posterior(table, eta, SMALL_PRIOR):
        law = outcomes(collapsed_blocks, lambda state=state: sweep(state, table, SMALL_PRIOR, eta))
        seen: dict[tuple[int, ...], int] = {}
        start = {"theta": np.array(state, np.int32)}
        for _ in range(draws):
            after = samplers.collapsed_blocks(Chain(likelihood, eta, generator, start), np.ones(1, bool))
            key = tuple(int(g) for g in after.assignments[0])
            seen[key] = seen.get(key, 0) + 1
        statistic += sum((seen.get(s, 0) - draws * p) ** 2 / (draws * p) for s, p in law.items())
        freedom += len(law) - 1
    assert chi2.sf(statistic, freedom) >= 1e-6


@pytest.mark.parametrize("sampler", SHIPPED, ids=lambda s: s.__name__)
def test_long_runs_reach_the_enumerated_posterior(sampler) -> None:
    """Total variation at most 3 times that of as many independent draws as the run is worth (thinned by 10)."""
    table, eta, sweeps = TABLES["generic"], 1.0, 200_000
    law = assignment_posterior(table, eta, PRIOR)
    states, pi = list(law), np.array(list(law.values()))
    stretch = sampler(Chain(likelihood_of(table, PRIOR), eta, np.random.default_rng(7)), np.ones(sweeps, bool))
    code = stretch.assignments @ (3 ** np.arange(3, -1, -1))
    order = np.array([np.dot(s, 3 ** np.arange(3, -1, -1)) for s in states])
    reached = np.bincount(code, minlength=81)[order] / sweeps
    independent = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    assert 0.5 * np.abs(reached - pi).sum() <= 3 * np.mean(0.5 * np.abs(independent - pi).sum(axis=1))
    np.testing.assert_allclose([np.unique(s).size for s in stretch.assignments[:50]], stretch.n_active[:50])
