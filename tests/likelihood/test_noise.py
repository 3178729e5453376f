"""Learned noise: the table at any confidence, moves against quadrature, truths covered."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import kstest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import noise as noises
from subgoal.likelihood.noise import NoiseLevels, OneConfidence, OwnConfidence
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.priors import LogNormal
from subgoal.runtime.errors import InputError
from tests.likelihood.test_action_comparison import METRICS, scene
from tests.likelihood.test_planned_actions import walks
from tests.mdp.small_worlds import world
from tests.posterior.worlds import quiet_sample

LEVEL = 3e-6
KINDS = ("plain 2-D", "angle", "3-D, an angle", "weights", "direction", "action", "planned")


def made(kind: str, n: int = 30, g_count: int = 5) -> LogLikelihood:
    """A small table of each kind of source."""
    if kind == "planned":
        mdp, _ = world(3, 0.9, n_states=9, illegal=True)
        return planned_actions(walks(mdp, 3, n), Candidates.from_states([[0], [3], [8], [1, 2], [4]]), mdp)
    if kind in ("direction", "action"):
        demos, candidates = still(METRICS["weights"], n, g_count)
        way = subgoal.controllers.straight_to_goal(candidates.metric)
        return subgoal.action_comparison(demos, candidates, controller=way, compare=kind)
    demos, candidates = still(METRICS[kind], n, g_count)
    return subgoal.action_comparison(demos, candidates)


def still(metric: Metric, n: int, g_count: int) -> tuple[Demonstrations, Candidates]:
    """A scene in which every tenth observation hardly moves."""
    demos, candidates = scene(metric, 2, n, g_count)
    actions = np.where(np.arange(n)[:, None] % 10 == 6, 1e-5, 1.0) * demos.actions
    return Demonstrations.from_arrays(demos.states, actions), candidates


def assignments(likelihood: LogLikelihood, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, likelihood.candidates.n_candidates, likelihood.n_observations)


def planar(confidences: np.ndarray, theta: np.ndarray, seed: int = 0) -> LogLikelihood:
    """Directions from (0, 0) to three far goals, each with its own α: exp(−2α sin(φ/2)), drawn by inversion."""
    generator = np.random.default_rng(seed)
    angle = np.linspace(0, np.pi, 20_001)
    turn = np.empty(theta.size)
    for i, alpha in enumerate(confidences):
        density = np.exp(-2 * alpha * np.sin(angle / 2))
        mass = np.append(0, np.cumsum((density[1:] + density[:-1]) / 2))
        turn[i] = np.interp(generator.random(), mass / mass[-1], angle) * generator.choice([-1, 1])
    goals = 100 * np.array([[1.0, 0.0], [-0.5, 0.8], [-0.3, -0.9]])
    heading = np.arctan2(goals[theta, 1], goals[theta, 0]) + turn
    demos = Demonstrations.from_arrays(np.zeros((theta.size, 2)), np.column_stack([np.cos(heading), np.sin(heading)]))
    return subgoal.action_comparison(demos, Candidates(goals))


def chain_of(noise: object, theta: np.ndarray, draws: int, seed: int = 1) -> np.ndarray:
    """(draws, k) values, after a tenth as many more."""
    generator, values, out = np.random.default_rng(seed), noise.start(), []
    for k in range(draws + draws // 10):
        values = noise.draw(values, theta, generator)
        if k >= draws // 10:
            out.append(values)
    return np.array(out)


@pytest.mark.parametrize("alpha", [0.7, 3.0, 20.0])
def test_one_confidence_covers_the_truth(alpha: float) -> None:
    """2,000 directions: the truth within 4.7 posterior standard deviations, which are below 6 % of it."""
    theta = np.arange(2000) % 3
    drawn = chain_of(OneConfidence().of(planar(np.full(2000, alpha), theta)), theta, 150)[:, 0]
    assert abs(drawn.mean() - alpha) <= 4.7 * drawn.std()
    assert 0.005 * alpha < drawn.std() < 0.1 * alpha


def test_each_candidate_has_its_own_confidence() -> None:
    """And one that nothing serves keeps the prior (Kolmogorov-Smirnov on its logarithm, 3e-6)."""
    theta, truth = np.arange(1600) % 2, np.array([1.5, 12.0])
    drawn = chain_of(OwnConfidence(LogNormal(3.0, 0.8)).of(planar(truth[theta], theta)), theta, 400)
    for g in range(2):
        assert abs(drawn[:, g].mean() - truth[g]) <= 4.7 * drawn[:, g].std()
        assert drawn[:, g].std() < 0.12 * truth[g]
    assert kstest((np.log(drawn[:, 2]) - math.log(3.0)) / 0.8, "norm").pvalue >= LEVEL


def test_shares_of_levels_cover_the_truth() -> None:
    theta, levels = np.arange(2400) % 3, np.array([0.5, 8.0])
    truth = np.array([0.3, 0.7])
    which = np.random.default_rng(3).choice(2, size=theta.size, p=truth)
    drawn = chain_of(NoiseLevels((0.5, 8.0)).of(planar(levels[which], theta)), theta, 400)
    np.testing.assert_allclose(drawn.sum(axis=1), 1, atol=1e-12)
    assert abs(drawn[:, 0].mean() - truth[0]) <= 4.7 * drawn[:, 0].std()
    assert drawn[:, 0].std() < 0.04


def cumulative_of(grid: np.ndarray, log_density: np.ndarray) -> object:
    mass = np.exp(log_density - log_density.max())
    return lambda x: np.interp(x, grid, np.cumsum(mass) / mass.sum())


@pytest.mark.parametrize("weight", [None, 0.4])
@pytest.mark.parametrize("kind", ["one", "own"])
def test_confidence_given_the_assignment_is_that_of_quadrature(kind: str, weight: float | None) -> None:
    """Of 9 directions with a weight, one of them background: every third of 1,200 draws (3e-6)."""
    theta = np.array([0, 0, 0, 1, 0, 2, 0, 0, 3])
    likelihood = planar(np.full(9, 3.0), np.minimum(theta, 2), 5).with_background(0.1)
    likelihood = likelihood if weight is None else likelihood.weighted(weight)
    law = LogNormal(2.0, 0.7)
    rows = theta < 3 if kind == "one" else theta == 0
    logs = np.linspace(-4, 6, 601)
    plain = likelihood.source
    fit = np.array([plain.log_density(0, 9, a)[rows, theta[rows]].sum() for a in np.exp(logs)]) * (weight or 1.0)
    noise = (OneConfidence if kind == "one" else OwnConfidence)(law).of(likelihood)
    drawn = np.log(chain_of(noise, theta, 1200)[::3, 0])
    density = fit + [law.log_density(a) for a in np.exp(logs)] + logs
    assert kstest(drawn, cumulative_of(logs, density)).pvalue >= LEVEL


@pytest.mark.parametrize("weight", [None, 0.4])
def test_shares_given_the_assignment_are_those_of_quadrature(weight: float | None) -> None:
    """Two levels: uniform beforehand, Π (π_1 p_i1 + π_2 p_i2)^weight."""
    theta = np.array([0, 0, 0, 1, 0, 2, 0, 0, 3])
    likelihood = planar(np.array([1.0] * 5 + [16.0] * 4), np.minimum(theta, 2), 6).with_background(0.1)
    likelihood = likelihood if weight is None else likelihood.weighted(weight)
    serving = np.flatnonzero(theta < 3)
    parts = np.exp([likelihood.source.log_density(0, 9, a)[serving, theta[serving]] for a in (1.0, 16.0)])
    share = (np.arange(2000) + 0.5) / 2000
    fit = np.log(np.outer(share, parts[0]) + np.outer(1 - share, parts[1])).sum(axis=1) * (weight or 1.0)
    drawn = chain_of(NoiseLevels((1.0, 16.0)).of(likelihood), theta, 2400)[::3, 0]
    assert kstest(drawn, cumulative_of(share + 0.5 / 2000, fit)).pvalue >= LEVEL


def test_without_data_the_shares_are_uniform_on_the_simplex() -> None:
    """All background: the first share of three is Beta(1, 2) (Kolmogorov-Smirnov, 3e-6)."""
    likelihood = planar(np.full(4, 3.0), np.zeros(4, int)).with_background(0.1)
    drawn = chain_of(NoiseLevels((1.0, 4.0, 16.0)).of(likelihood), np.full(4, 3), 2400)[::3]
    assert kstest(drawn[:, 0], lambda x: 1 - (1 - x) ** 2).pvalue >= LEVEL
    assert kstest(drawn[:, 2], lambda x: 1 - (1 - x) ** 2).pvalue >= LEVEL


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("background", "weight"), [(0.0, False), (0.2, True)])
def test_the_table_of_levels_is_a_mixture_of_tables(kind: str, background: float, weight: bool, monkeypatch) -> None:
    """Held as one product of densities, and made row by row: log Σ_m share_m p_m, then background, then weights."""
    plain = made(kind)
    weights = np.random.default_rng(1).uniform(0.2, 1.5, plain.n_observations) if weight else None
    likelihood = replace(plain, background=background, weight=weights)
    shares = np.array([0.2, 0.5, 0.3])
    levels = np.array([0.5, 2.0, 12.0]) * plain.source.unit
    n = plain.n_observations
    each = [plain.source.log_density(0, n, a) + math.log(s) for a, s in zip(levels, shares, strict=True)]
    wanted = logsumexp(each, axis=0)
    if background:
        wanted = np.column_stack([wanted, plain.source.log_flat(0, n)])
    wanted = wanted if weights is None else wanted * weights[:, None]
    spec = NoiseLevels((0.5, 2.0, 12.0))
    held = spec.of(likelihood).table(shares)
    assert "dense" in held.__dict__
    np.testing.assert_allclose(held.dense, wanted, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(held.rows(4, 17), wanted[4:17], rtol=1e-11, atol=1e-11)
    monkeypatch.setattr(noises, "STACK", 0)
    slow = spec.of(likelihood).table(shares)
    assert "dense" not in slow.__dict__
    np.testing.assert_allclose(slow.dense, wanted, rtol=1e-11, atol=1e-11)
    tiled = replace(likelihood, dense_entries=1)
    assert spec.of(tiled).table(shares).dense is None


def test_levels_of_no_share_are_left_out() -> None:
    plain = made("plain 2-D")
    mixed = plain.at(Levels(np.array([2.0, 9.0]), np.array([0.0, 1.0])))
    np.testing.assert_allclose(mixed.dense, plain.at(9.0).dense, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_tables_of_one_and_own_confidence_are_rows_at_that_confidence(kind: str) -> None:
    plain = made(kind)
    one, own = OneConfidence().of(plain), OwnConfidence().of(plain)
    assert one.start()[0] == pytest.approx(3 * plain.source.unit)
    values = np.random.default_rng(0).uniform(0.5, 6, plain.candidates.n_candidates)
    n = plain.n_observations
    np.testing.assert_array_equal(one.table(values[:1]).dense, plain.source.log_density(0, n, float(values[0])))
    table = own.table(values).dense
    for g, alpha in enumerate(values.tolist()):
        wanted = plain.source.log_density(0, n, alpha)[:, g]
        np.testing.assert_allclose(table[:, g], wanted, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_background_is_one_more_column_of_its_prior(kind: str) -> None:
    plain = made(kind)
    wide = plain.with_background(0.25)
    assert wide.n_candidates == plain.n_candidates + 1
    assert np.exp(wide.log_prior).sum() == pytest.approx(1, abs=1e-12)
    assert np.exp(wide.log_prior[-1]) == pytest.approx(0.25, abs=1e-12)
    np.testing.assert_allclose(wide.log_prior[:-1] - plain.log_prior, math.log(0.75), atol=1e-12)
    np.testing.assert_array_equal(wide.dense[:, :-1], plain.dense)
    np.testing.assert_array_equal(wide.dense[:, -1], plain.source.log_flat(0, plain.n_observations))
    slow = np.flatnonzero(plain.source.uninformative)
    np.testing.assert_allclose(wide.dense[slow, -1], wide.dense[slow, 0], atol=1e-12)
    marginal = logsumexp(wide.dense + wide.log_prior, axis=1)
    np.testing.assert_allclose(wide.log_marginal, marginal, atol=1e-12)
    np.testing.assert_allclose(replace(wide, dense_entries=1).log_marginal, marginal, atol=1e-12)
    assert wide.arrived.shape == (plain.n_observations, wide.n_candidates)
    assert not wide.arrived.toarray()[:, -1].any()


def test_weighted_rows_are_raised_to_their_power() -> None:
    plain = made("plain 2-D").with_background(0.1)
    weight = np.random.default_rng(0).uniform(0.1, 2, plain.n_observations)
    table = plain.weighted(weight)
    np.testing.assert_array_equal(table.dense, plain.dense * weight[:, None])
    np.testing.assert_array_equal(plain.weighted(0.5).dense, plain.dense * 0.5)
    tiled = replace(table, dense_entries=1)
    np.testing.assert_allclose(tiled.log_marginal, logsumexp(table.dense + plain.log_prior, axis=1), atol=1e-12)
    np.testing.assert_array_equal(tiled.rows(3, 9), table.dense[3:9])


def test_priors_of_the_noise_are_per_unit_of_the_confidence() -> None:
    """p(α) = p(α / unit) / unit, for each candidate; uniform on the simplex: Γ(M)."""
    plain = made("planned")
    unit, law = plain.source.unit, LogNormal(2.0, 0.5)
    assert unit != pytest.approx(1.0)
    values = np.array([1.0, 2.0, 3.0, 4.0, 5.0]) * unit
    wanted = [LogNormal(2.0 * unit, 0.5).log_density(x) for x in values]
    assert OneConfidence(law).of(plain).log_density(values[:1]) == pytest.approx(wanted[0], abs=1e-12)
    assert OwnConfidence(law).of(plain).log_density(values) == pytest.approx(sum(wanted), abs=1e-12)
    assert NoiseLevels((1.0, 2.0, 3.0, 4.0)).of(plain).log_density(np.full(4, 0.25)) == pytest.approx(math.log(6))


def test_the_gate_judges_noise_by_its_mean_logarithm() -> None:
    plain = made("planned")
    levels, shares = np.array([1.0, 2.0, 8.0]), np.random.default_rng(0).dirichlet(np.ones(3), (4, 7))
    found = NoiseLevels(tuple(levels)).of(plain).summary(shares)
    np.testing.assert_allclose(found, shares @ np.log(levels * plain.source.unit))
    np.testing.assert_allclose(OwnConfidence().of(plain).summary(shares), np.log(shares).mean(axis=2))
    posterior = quiet_sample(plain, confidence=NoiseLevels(), chains=2, draws=8, warmup=2, thin=1)
    assert posterior.diagnostics["mean log noise levels"].ess_bulk > 0


@pytest.mark.parametrize("unit", [1e-12, 1e12])
@pytest.mark.parametrize("spec", [OneConfidence(), OwnConfidence()])
def test_a_confidence_can_start_and_move_whatever_its_unit(spec: object, unit: float) -> None:
    """Strongly discounted worlds have tiny action values, and α of 1e9 and more; draws scale with the unit."""

    def chain(scale: float) -> np.ndarray:
        plain = made("planned")
        plan = replace(plain.source.plan, action_values=plain.source.plan.action_values / scale)
        scaled = replace(plain, source=replace(plain.source, plan=plan))
        return chain_of(spec.of(scaled), assignments(scaled), 20) / scale

    np.testing.assert_allclose(chain(unit), chain(1.0), rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: NoiseLevels((1.0,)), "noise levels"),
        (lambda: NoiseLevels((2.0, 1.0)), "noise levels"),
        (lambda: NoiseLevels((0.0, 1.0)), "noise levels"),
        (lambda: NoiseLevels((1.0, np.nan)), "noise levels"),
        (lambda: made("plain 2-D").with_background(1.0), "background"),
        (lambda: made("plain 2-D").with_background(-0.1), "background"),
        (lambda: made("plain 2-D").weighted(0.0), "weight"),
        (lambda: made("plain 2-D").weighted([1.0, np.nan] * 15), "weight"),
        (lambda: made("plain 2-D").weighted([1.0, 2.0]), "weight"),
        (lambda: made("plain 2-D").weighted("much"), "weight"),
        (lambda: made("plain 2-D").at(np.ones(3)), "confidence"),
        (lambda: made("plain 2-D").at(np.array([1.0, 1, 1, 1, -1])), "confidence"),
        (lambda: LogLikelihood.from_table(np.zeros((3, 2))).with_background(0.1).dense, "background|table"),
        (lambda: subgoal.sample(LogLikelihood.from_table(np.zeros((3, 2))), confidence=OneConfidence()), "table|conf"),
        (lambda: subgoal.sample(made("plain 2-D"), confidence=2.0), "confidence"),
    ],
)
def test_bad_noise_is_named(make: object, word: str) -> None:
    with pytest.raises(InputError, match=word):
        make()


def test_metrics_of_the_scenes_wrap() -> None:
    """So that "angle" is a test of periodic axes: some way to a goal is shorter around."""
    demos, candidates = scene(METRICS["angle"], 2, 30, 5)
    flat = Metric(candidates.metric.weights, np.full(2, np.inf))
    around = candidates.metric.distance(demos.states[:, None], candidates.points[None])
    assert (around < flat.distance(demos.states[:, None], candidates.points[None]) - 0.1).any()
