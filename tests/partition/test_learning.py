"""Concentration and persistence learned with the assignment: against quadrature and enumeration, and cut anyhow."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.special import expit
from scipy.stats import kstest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.noise import NoiseLevels, OneConfidence
from subgoal.partition import learning
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.concentration import draw_concentration, log_counts
from subgoal.partition.learning import EVERY, Learning, assignment
from subgoal.partition.persistence import Persistent, draw_keep
from subgoal.partition.priors import Beta, Gamma, LogNormal
from subgoal.partition.protocol import Chain
from subgoal.runtime.errors import InputError
from tests.exact.test_transition_persistence import ARRIVED, STARTS, temporal_table
from tests.oracles.partitions import urn_probability
from tests.oracles.persistence import paths, posterior, step_probability
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

LEVEL = 3e-6
LOGS = np.linspace(-14, 6, 4001)
"""Grid of log η: the densities used here are below 1e-6 of their largest at both ends."""


def on_grid(log_density: np.ndarray) -> np.ndarray:
    """Probabilities of the cells of a grid."""
    mass = np.exp(log_density - log_density.max())
    return mass / mass.sum()


def urn(theta: tuple[int, ...], etas: np.ndarray) -> np.ndarray:
    """p(θ | η) for each η, observation by observation."""
    value, seen = np.ones(etas.size), np.zeros(PRIOR.size)
    for i, g in enumerate(theta):
        value *= (seen[g] + etas * PRIOR[g]) / (i + etas)
        seen[g] += 1
    return value


@pytest.mark.parametrize("eta", [0.2, 1.0, 9.0])
def test_counts_have_the_probability_of_the_urn(eta: float) -> None:
    for theta in [(0, 0, 1, 2, 0), (2, 2, 2), (1,), (0, 1, 0, 1, 2, 2, 1)]:
        counts = np.bincount(theta, minlength=3)
        assert log_counts(counts, PRIOR, eta) == pytest.approx(math.log(urn_probability(theta, eta, PRIOR)), abs=1e-12)


@pytest.mark.parametrize("counts", [(5, 0, 0), (3, 1, 2), (40, 0, 9)])
def test_concentrations_are_those_of_quadrature(counts: tuple[int, ...]) -> None:
    """800 chains of 10 draws each, from η = 1: the last is a draw from p(η | counts) (Kolmogorov-Smirnov, 3e-6)."""
    law, counts = Gamma(2.0, 0.5), np.array(counts)
    etas = np.exp(LOGS)
    theta = tuple(np.repeat(np.arange(3), counts))
    mass = on_grid(np.log(urn(theta, etas)) + [law.log_density(x) for x in etas] + LOGS)
    generator, reached = np.random.default_rng(4), np.ones(800)
    for k in range(reached.size):
        for _ in range(10):
            reached[k] = draw_concentration(reached[k], law, counts, PRIOR, generator)
    assert kstest(np.log(reached), lambda x: np.interp(x, LOGS, np.cumsum(mass))).pvalue >= LEVEL


@pytest.mark.parametrize(("repeats", "changes"), [((0, 0, 0), 0), ((7, 0, 2), 3), ((0, 0, 30), 1)])
def test_persistence_is_that_of_quadrature(repeats: tuple[int, ...], changes: int) -> None:
    """Π_g (ρ + (1 − ρ)w_g)^{repeats of g} (1 − ρ)^changes under a Beta prior (Kolmogorov-Smirnov, 3e-6)."""
    law, weights, repeats = Beta(2.0, 1.5), np.array([0.6, 0.3, 0.1]), np.array(repeats)
    logits = np.linspace(-15, 15, 4001)
    rho = expit(logits)
    fit = (repeats * np.log(rho[:, None] + (1 - rho[:, None]) * weights)).sum(axis=1) + changes * np.log1p(-rho)
    mass = on_grid(fit + [law.log_density(x) for x in rho] + np.log(rho) + np.log1p(-rho))
    generator, reached = np.random.default_rng(6), np.full(800, 0.5)
    for k in range(reached.size):
        for _ in range(10):
            reached[k] = draw_keep(reached[k], law, repeats, changes, weights, generator)
    cumulative = np.cumsum(mass)
    assert kstest(np.log(reached / (1 - reached)), lambda x: np.interp(x, logits, cumulative)).pvalue >= LEVEL


def exchangeable_law(name: str, law: Gamma) -> tuple[dict[tuple[int, ...], float], float]:
    """p(θ | O) and E[η | O] with η on a grid."""
    etas = np.exp(LOGS)
    width = np.exp([law.log_density(x) for x in etas]) * etas
    fit = assignment_posterior(TABLES[name], 1.0, PRIOR)
    joint = {theta: urn(theta, etas) * width * p / urn(theta, np.ones(1))[0] for theta, p in fit.items()}
    total = sum(each.sum() for each in joint.values())
    return {t: each.sum() / total for t, each in joint.items()}, sum(each @ etas for each in joint.values()) / total


def persistent_law(name: str, law: Gamma, keep: float) -> tuple[dict[tuple[int, ...], float], float]:
    """The same for subgoals that persist."""
    etas = np.exp(LOGS)
    width = np.exp([law.log_density(x) for x in etas]) * etas
    given = posterior(TABLES[name], STARTS, 1.0, PRIOR, lambda s: step_probability(s, STARTS, keep, keep, ARRIVED))
    paths: dict[tuple[int, ...], float] = {}
    total = mean = 0.0
    for (theta, redrawn), p in given.items():
        drawn = tuple(g for g, r in zip(theta, redrawn, strict=True) if r)
        joint = urn(drawn, etas) * width * p / urn(drawn, np.ones(1))[0]
        paths[theta] = paths.get(theta, 0.0) + joint.sum()
        total, mean = total + joint.sum(), mean + joint @ etas
    return {theta: p / total for theta, p in paths.items()}, mean / total


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("base", ["mixture", pytest.param("persistent", marks=pytest.mark.t2)])
def test_assignment_and_concentration_have_their_joint_law(name: str, base: str) -> None:
    """Total variation of θ at most 3 times that of a tenth as many independent draws; the mean of η within 8 %.

    η has a standard deviation below 0.6 of its mean (its prior's) and is drawn every fifth sweep; at an
    autocorrelation time of three draws 8 % is five standard errors of the shorter run.
    """
    law, sweeps, table = Gamma(3.0, 1.5), 60_000, temporal_table(name)
    wanted, mean = exchangeable_law(name, law) if base == "mixture" else persistent_law(name, law, 0.6)
    if base == "persistent":
        sweeps = 20_000
    sampler = Learning(collapsed_blocks if base == "mixture" else Persistent(keep=0.6), law)
    run = sampler(Chain(table, 77.0, np.random.default_rng(5)), np.ones(sweeps, bool))
    place = {state: k for k, state in enumerate(wanted)}
    pi = np.array(list(wanted.values()))
    reached = np.bincount([place[tuple(t)] for t in run.assignments.tolist()], minlength=pi.size) / sweeps
    independent = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    assert 0.5 * np.abs(reached - pi).sum() <= 3 * np.mean(0.5 * np.abs(independent - pi).sum(axis=1))
    assert abs(run.parameters["concentration"].mean() / mean - 1) <= 0.08


def spatial() -> subgoal.LogLikelihood:
    """Four directions in space, whose normaliser is closed, against three goals."""
    actions = np.array([[1.0, 0.2, 0.0], [0.9, -0.3, 0.2], [0.1, 1.0, 0.4], [0.5, 0.5, 0.6]])
    demos = Demonstrations.from_arrays(np.zeros((4, 3)), actions, [0, 4])
    return subgoal.action_comparison(demos, Candidates(9 * np.eye(3), np.log(PRIOR)))


def noise_on_grid(kind: str) -> tuple[object, np.ndarray, np.ndarray, np.ndarray]:
    """What is learned, a grid of its first number, prior mass of each point, and p_ig at each (points, N, G)."""
    source = spatial().source
    if kind == "one confidence":
        law, logs = LogNormal(2.0, 0.8), np.linspace(-4, 6, 801)
        grid = np.exp(logs)
        tables = np.exp([source.log_density(0, 4, a) for a in grid])
        return OneConfidence(law), grid, np.exp([law.log_density(a) for a in grid]) * grid, tables
    grid = (np.arange(800) + 0.5) / 800
    low, high = (np.exp(source.log_density(0, 4, a)) for a in (0.5, 10.0))
    tables = grid[:, None, None] * low + (1 - grid[:, None, None]) * high
    return NoiseLevels((0.5, 10.0)), grid, np.ones(800), tables


@pytest.mark.parametrize("kind", ["one confidence", "two levels"])
@pytest.mark.parametrize(
    "base", [collapsed_blocks, pytest.param(Persistent(keep=0.6), marks=pytest.mark.t2)], ids=["mixture", "persistent"]
)
def test_assignment_and_noise_have_their_joint_law(kind: str, base) -> None:
    """θ by enumeration and the noise on a grid; E[noise], E[noise | θ_3 = θ_0], and total variation of θ.

    20,000 sweeps with a draw of the noise every fifth: means within five standard errors at an autocorrelation time
    of three draws; total variation as above.
    """
    spec, grid, mass, tables = noise_on_grid(kind)
    likelihood, sweeps = spatial(), 20_000
    thetas = list(itertools.product(range(3), repeat=4))
    prior = dict.fromkeys(thetas, 0.0)
    for state in paths(4, 3, (0,)):
        if base is collapsed_blocks and not all(state[1]):
            continue
        keep = 0.0 if base is collapsed_blocks else 0.6
        drawn = [g for g, r in zip(*state, strict=True) if r]
        chance = step_probability(state, (0,), keep, keep, np.zeros((4, 3), bool))
        prior[state[0]] += chance * urn_probability(drawn, 1.5, PRIOR)
    joint = np.array([prior[t] * mass * tables[:, np.arange(4), list(t)].prod(axis=1) for t in thetas])
    joint /= joint.sum()
    run = Learning(base, None, spec.of(likelihood))(
        Chain(likelihood, 1.5, np.random.default_rng(5)), np.ones(sweeps, bool)
    )
    place = {state: k for k, state in enumerate(thetas)}
    pi = joint.sum(axis=1)
    reached = np.bincount([place[tuple(t)] for t in run.assignments.tolist()], minlength=81) / sweeps
    independent = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    assert 0.5 * np.abs(reached - pi).sum() <= 3 * np.mean(0.5 * np.abs(independent - pi).sum(axis=1))
    noise = run.parameters["confidence" if kind == "one confidence" else "noise levels"].reshape(sweeps, -1)[:, 0]
    alike = np.array([t[3] == t[0] for t in thetas])
    for inside, seen in ((np.ones(81, bool), slice(None)), (alike, run.assignments[:, 3] == run.assignments[:, 0])):
        law = joint[inside].sum(axis=0) / joint[inside].sum()
        mean = law @ grid
        error = math.sqrt(3 * (law @ grid**2 - mean**2) / (noise[seen].size / EVERY))
        assert abs(noise[seen].mean() - mean) <= 5 * error


@pytest.mark.parametrize("base", [collapsed_blocks, Persistent()], ids=["mixture", "persistent"])
def test_the_joint_density_has_the_prior_of_the_concentration(base) -> None:
    """log p(θ, η, O) less that of a sampler whose η is fixed there is the log prior density of η."""
    table, law = temporal_table("generic"), Gamma(2.0, 1.0)
    run = Learning(base, law)(Chain(table, 1.0, np.random.default_rng(1)), np.ones(EVERY, bool))
    plain = base(Chain(table, law.start, np.random.default_rng(1)), np.ones(EVERY, bool))
    np.testing.assert_array_equal(run.assignments, plain.assignments)
    np.testing.assert_allclose(run.log_joint - plain.log_joint, law.log_density(law.start), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(run.log_likelihood, plain.log_likelihood)


@pytest.mark.parametrize("base", [collapsed_blocks, Persistent()], ids=["mixture", "persistent"])
@pytest.mark.parametrize("cuts", [(1,) * 23, (5, 5, 13), (4, 1, 7, 11), (22, 1)])
def test_how_sweeps_are_cut_does_not_change_the_draws(base, cuts: tuple[int, ...]) -> None:
    """Each call goes on from the state the last one left, as a resumed run does; kept are every third."""
    table, sampler = temporal_table("generic"), Learning(base, Gamma())
    keep = np.arange(23) % 3 == 2
    whole = sampler(Chain(table, 1.0, np.random.default_rng(9)), keep)
    generator, state, parts = np.random.default_rng(9), None, []
    for start, count in zip(np.cumsum((0, *cuts)), cuts, strict=False):
        parts.append(sampler(Chain(table, 1.0, generator, state), keep[start : start + count]))
        state = {name: np.array(value) for name, value in parts[-1].state.items()}
    for name in ("assignments", "n_active", "log_likelihood", "log_joint"):
        np.testing.assert_array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(whole, name))
    for name, values in whole.parameters.items():
        np.testing.assert_array_equal(np.concatenate([part.parameters[name] for part in parts]), values)
    if whole.redraws is not None:
        np.testing.assert_array_equal(np.concatenate([part.redraws for part in parts]), whole.redraws)
    assert np.unique(whole.parameters["concentration"]).size >= 3
    assert len(whole.assignments) == len(whole.parameters["concentration"]) == keep.sum()


def test_the_concentration_starts_at_the_mean_of_its_prior_and_moves_between_sweeps() -> None:
    run = Learning(collapsed_blocks, Gamma(6.0, 2.0))(
        Chain(temporal_table("peaked"), 50.0, np.random.default_rng(2)), np.ones(3 * EVERY, bool)
    )
    values = run.parameters["concentration"].reshape(3, EVERY)
    assert (values[0] == 3.0).all()
    assert (values == values[:, :1]).all()
    assert np.unique(values).size == 3
    assert run.state["learned_concentration"][0] not in values


def test_the_concentration_is_drawn_given_the_redraws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of subgoals that persist only redraws are drawn from the shared weights; in the mixture all observations are."""
    given = []

    def recorded(eta, law, counts, prior, generator):
        given.append((counts.copy(), prior))
        return eta

    monkeypatch.setattr(learning, "draw_concentration", recorded)
    table = temporal_table("peaked")
    for base in (Persistent(keep=0.9), collapsed_blocks):
        given.clear()
        run = Learning(base, Gamma())(Chain(table, 1.0, np.random.default_rng(3)), np.ones(20 * EVERY, bool))
        ends = slice(EVERY - 1, None, EVERY)
        counts = [np.bincount(theta, minlength=3) for theta in run.assignments[ends]]
        wanted = counts if run.redraws is None else run.redraws[ends]
        np.testing.assert_array_equal([each for each, _ in given], wanted)
        assert (np.sum(wanted, axis=1) < 4).any() == (run.redraws is not None)
        np.testing.assert_allclose(given[0][1], PRIOR, atol=1e-12)


def test_keeping_only_where_one_has_arrived_is_refused() -> None:
    """With ρ = 0 elsewhere a subgoal could not be carried to where it is kept."""
    for there in (0.3, Beta()):
        with pytest.raises(InputError, match="persistence"):
            Persistent(keep=0.0, keep_there=there)
    assert Persistent(keep=0.0, keep_there=0.0).keep_there == 0.0
    assert Persistent(keep=0.0).keep_there is None


def test_nothing_learned_is_the_base_itself() -> None:
    chain = [Chain(temporal_table("generic"), 0.7, np.random.default_rng(3)) for _ in range(2)]
    one, two = Learning(collapsed_blocks)(chain[0], np.ones(12, bool)), collapsed_blocks(chain[1], np.ones(12, bool))
    np.testing.assert_array_equal(one.assignments, two.assignments)
    np.testing.assert_array_equal(one.log_joint, two.log_joint)
    assert one.parameters == {}


def test_an_assignment_is_read_from_tables_too() -> None:
    state = {"dish": np.array([4, 2]), "label": np.array([1, 0, 0])}
    assert assignment(state).tolist() == [2, 4, 4]
    assert assignment({"theta": np.array([1, 1])}).tolist() == [1, 1]
