"""Five samplers compiled: their Python form, their exact one-step law, long runs, tiles, and chains that go on."""

from __future__ import annotations

import itertools
import pickle
from math import exp

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import beta, chi2

from subgoal import samplers
from subgoal.partition.protocol import Chain
from subgoal.runtime.errors import InputError
from tests.exact.laws import LOOPS, MORE, WALLED, state_at, sweep_law
from tests.exact.replay import python_form
from tests.exact.test_compiled_steps import SMALL_PRIOR, likelihood_of, wide_table
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

TILED = [samplers.blocked, samplers.collapsed, samplers.cluster_collapsed]
WHOLE = [samplers.split_merge, samplers.tempered]


def name_of(sampler) -> str:
    return sampler.__name__


def walled_table() -> np.ndarray:
    """(60, 17) with a fifth of the entries impossible, no row entirely."""
    table = wide_table()
    table[np.random.default_rng(6).random(table.shape) < 0.2] = -np.inf
    assert np.isfinite(table).any(axis=1).all()
    return table


@pytest.mark.parametrize("table", [wide_table(), walled_table()], ids=["finite", "walled"])
@pytest.mark.parametrize("sampler", TILED, ids=name_of)
def test_tiled_table_gives_the_draws_of_the_whole_one(sampler, table: np.ndarray) -> None:
    prior, keep = np.full(17, 1 / 17), np.ones(30, bool)
    whole, tiled = likelihood_of(table, prior), likelihood_of(table, prior, dense_entries=50)
    answers = [sampler(Chain(each, 3.0, np.random.default_rng(2)), keep) for each in (whole, tiled)]
    np.testing.assert_array_equal(answers[0].assignments, answers[1].assignments)
    np.testing.assert_array_equal(answers[0].log_joint, answers[1].log_joint)
    np.testing.assert_array_equal(answers[0].n_active, answers[1].n_active)


@pytest.mark.parametrize("sampler", WHOLE, ids=name_of)
def test_tiled_table_is_refused_and_another_sampler_named(sampler) -> None:
    tiled = likelihood_of(wide_table(), np.full(17, 1 / 17), dense_entries=50)
    with pytest.raises(InputError, match=r"60 × 17 computed in tiles.*collapsed_blocks") as told:
        sampler(Chain(tiled, 3.0, np.random.default_rng(2)), np.ones(2, bool))
    assert sampler.__name__ in str(told.value)


@pytest.mark.parametrize("sampler", MORE, ids=name_of)
def test_compiled_is_the_python_form_bit_for_bit(sampler) -> None:
    keep, likelihood = np.ones(4, bool), likelihood_of(walled_table()[:12, :5], np.full(5, 0.2))
    compiled = sampler(Chain(likelihood, 2.0, np.random.default_rng(3)), keep)
    with python_form(LOOPS[sampler]):
        plain = sampler(Chain(likelihood, 2.0, np.random.default_rng(3)), keep)
    np.testing.assert_array_equal(compiled.assignments, plain.assignments)
    np.testing.assert_allclose(compiled.log_joint, plain.log_joint, rtol=1e-14)


@pytest.mark.parametrize("sampler", MORE, ids=name_of)
def test_a_chain_goes_on_from_its_state_bit_for_bit(sampler) -> None:
    likelihood, generator = likelihood_of(walled_table(), np.full(17, 1 / 17)), np.random.default_rng(3)
    whole = sampler(Chain(likelihood, 4.0, np.random.default_rng(3)), np.ones(40, bool))
    state, parts = None, []
    for sweeps in (1, 14, 25):
        parts.append(sampler(Chain(likelihood, 4.0, generator, state), np.ones(sweeps, bool)))
        state = {name: values.copy() for name, values in parts[-1].state.items()}
    for trace in ("assignments", "log_joint", "log_likelihood", "n_active"):
        np.testing.assert_array_equal(np.concatenate([getattr(p, trace) for p in parts]), getattr(whole, trace))
    for name, values in whole.state.items():
        np.testing.assert_array_equal(values, state[name])


@pytest.mark.parametrize("sampler", MORE, ids=name_of)
def test_traces_are_those_of_the_assignments(sampler) -> None:
    table, prior, eta = walled_table(), np.arange(1, 18) / 153, 4.0
    drawn = sampler(Chain(likelihood_of(table, prior), eta, np.random.default_rng(3)), np.ones(20, bool))
    for theta, k, fit, joint in zip(
        drawn.assignments, drawn.n_active, drawn.log_likelihood, drawn.log_joint, strict=True
    ):
        chain_rule, seen = 0.0, np.zeros(17)
        for i, g in enumerate(theta):
            chain_rule += np.log((seen[g] + eta * prior[g]) / (i + eta))
            seen[g] += 1
        assert k == np.unique(theta).size
        np.testing.assert_allclose(fit, table[np.arange(60), theta].sum(), rtol=0, atol=1e-11)
        np.testing.assert_allclose(joint, fit + chain_rule, rtol=0, atol=1e-11)
    kept = sampler(Chain(likelihood_of(table, prior), eta, np.random.default_rng(3)), np.arange(20) % 3 == 1)
    np.testing.assert_array_equal(kept.assignments, drawn.assignments[1::3])


def law_of_blocked(theta, table: np.ndarray, eta: float) -> dict[tuple[int, ...], float]:
    """Two candidates: the product of the observations' laws, integrated over the weight of the first."""
    a = eta * SMALL_PRIOR + np.bincount(theta, minlength=2)
    likelihood = np.exp(table)

    def given(w: float, drawn: tuple[int, ...]) -> float:
        each = likelihood * (w, 1 - w)
        return float((each / each.sum(axis=1, keepdims=True))[np.arange(len(table)), list(drawn)].prod())

    law = {}
    for drawn in itertools.product(range(2), repeat=len(table)):
        law[drawn] = quad(lambda u, d=drawn: given(beta.ppf(u, *a), d), 0, 1, limit=200, epsabs=1e-6)[0]
    return law


def law_of_tempered(theta, table: np.ndarray, eta: float) -> dict[tuple[int, ...], float]:
    """Two levels that both stand at θ: sweeps of each, then the exchange, of which the first is seen."""
    beta_b = PAIR.powers[1]
    cold, hot = (sweep_law(ALONE, theta, likelihood_of(b * table, SMALL_PRIOR), eta) for b in (1.0, beta_b))
    fit = {drawn: table[np.arange(len(table)), list(drawn)].sum() for drawn in cold}
    law = dict.fromkeys(cold, 0.0)
    for (x, p), (y, q) in itertools.product(cold.items(), hot.items()):
        exchanged = min(1.0, exp((1 - beta_b) * (fit[y] - fit[x])))
        law[y] += p * q * exchanged
        law[x] += p * q * (1 - exchanged)
    return law


PAIR = samplers.Tempering((1.0, 0.4))
ALONE = samplers.Tempering((1.0,))
LOOPS[ALONE] = LOOPS[samplers.tempered]
ONE_STEP = {
    "blocked": (samplers.blocked, 3, law_of_blocked),
    "collapsed": (samplers.collapsed, 3, None),
    "cluster_collapsed": (samplers.cluster_collapsed, 3, None),
    "split_merge": (samplers.split_merge, 2, None),
    "tempered": (PAIR, 3, law_of_tempered),
}


@pytest.mark.parametrize(
    "name", [n if n in ("collapsed", "split_merge") else pytest.param(n, marks=pytest.mark.t2) for n in ONE_STEP]
)
def test_compiled_steps_follow_their_exact_law(name: str) -> None:
    """10,000 one-sweep draws from every state, pooled chi-square; level 1e-6, notices cell errors of about 0.02."""
    sampler, n, law_of = ONE_STEP[name]
    table, eta, draws = TABLES["generic"][:n, :2], 1.3, 10_000
    likelihood, generator = likelihood_of(table, SMALL_PRIOR), np.random.default_rng(11)
    statistic, freedom = 0.0, 0
    for state in assignment_posterior(table, eta, SMALL_PRIOR):
        law = law_of(state, table, eta) if law_of else sweep_law(sampler, state, likelihood, eta)
        assert abs(sum(law.values()) - 1) <= 1e-5
        start, seen = state_at(sampler, state), dict.fromkeys(law, 0)
        for _ in range(draws):
            after = sampler(Chain(likelihood, eta, generator, start), np.ones(1, bool))
            seen[tuple(after.assignments[0].tolist())] += 1
        statistic += sum((seen[s] - draws * p) ** 2 / (draws * p) for s, p in law.items())
        freedom += len(law) - 1
    assert chi2.sf(statistic, freedom) >= 1e-6


@pytest.mark.parametrize("table", [TABLES["generic"], WALLED], ids=["generic", "walled"])
@pytest.mark.parametrize("sampler", MORE, ids=name_of)
def test_long_runs_reach_the_enumerated_posterior(sampler, table: np.ndarray) -> None:
    """Total variation at most 3 times that of as many independent draws as the run is worth (thinned by 10)."""
    eta, sweeps, digits = 1.0, 100_000, 3 ** np.arange(3, -1, -1)
    law = assignment_posterior(table, eta, PRIOR)
    pi = np.zeros(81)
    pi[[np.dot(state, digits) for state in law]] = list(law.values())
    stretch = sampler(Chain(likelihood_of(table, PRIOR), eta, np.random.default_rng(7)), np.ones(sweeps, bool))
    reached = np.bincount(stretch.assignments @ digits, minlength=81) / sweeps
    independent = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    assert (reached[pi == 0] == 0).all()
    assert 0.5 * np.abs(reached - pi).sum() <= 3 * np.mean(0.5 * np.abs(independent - pi).sum(axis=1))


@pytest.mark.parametrize("powers", [(), (0.9, 0.5), (1.0, 0.5, 0.5), (1.0, 0.0), (1.0, np.nan), "much"], ids=str)
def test_powers_fall_from_one(powers) -> None:
    with pytest.raises(InputError, match="powers"):
        samplers.Tempering(powers)


def test_tempering_is_named_equal_and_sent_to_processes() -> None:
    other = samplers.Tempering((1, 0.5))
    assert (samplers.tempered.__name__, other.__name__) == ("tempered", "tempered(1, 0.5)")
    assert pickle.loads(pickle.dumps(other)) == other != samplers.tempered
