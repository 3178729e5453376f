"""The exact transition laws of five samplers, move by move."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.special import digamma, polygamma

from subgoal import samplers
from subgoal._kernels import blocked, cluster_collapsed, collapsed, split_merge, tempered
from subgoal._kernels.counts import recount
from subgoal.partition.protocol import Chain
from subgoal.partition.tempered import levels_of
from tests.exact.laws import WITH_WALLS, partition_posterior, sweep_law
from tests.exact.replay import matrix, outcomes
from tests.exact.test_compiled_steps import SMALL_PRIOR, likelihood_of
from tests.exact.test_transition_alg4 import Arrays as Tables
from tests.oracles.partitions import canonical
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

CASES = [(name, eta) for name in WITH_WALLS for eta in (0.05, 1.0, 5.0)]


def vector(law: dict) -> tuple[list, np.ndarray]:
    """States that are possible and their probabilities."""
    law = {state: p for state, p in law.items() if p > 0}
    return list(law), np.array(list(law.values()))


def relative_of(log_table: np.ndarray, prior: np.ndarray) -> np.ndarray:
    likelihood = np.exp(log_table)
    return likelihood / (likelihood @ prior)[:, None]


def imbalance(pi: np.ndarray, step: np.ndarray) -> float:
    flow = pi[:, None] * step
    assert np.abs(step.sum(axis=1) - 1).max() <= 1e-12
    return float(np.abs(flow - flow.T).max())


def move_redraw(i: int, theta, table: np.ndarray, eta: float) -> tuple[int, ...]:
    g_count = len(PRIOR)
    counts, active, place = (np.zeros(g_count, np.int64) for _ in range(3))
    drawn, work = np.array(theta, np.int32), np.zeros(max(len(theta), g_count) + 1)
    held, k = np.zeros(g_count), recount(drawn, counts, active, place)
    collapsed.largest_first(counts, active, place, held, k)
    relative = relative_of(table, PRIOR)[i : i + 1]
    collapsed.redraw_rows(i, relative, drawn, active, place, held, k, eta, PRIOR, work, None)
    return tuple(drawn.tolist())


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_collapsed_sites_are_reversible(name: str, eta: float) -> None:
    table = WITH_WALLS[name]
    states, pi = vector(assignment_posterior(table, eta, PRIOR))
    for i in range(len(table)):
        step = matrix(
            states,
            lambda s, i=i: outcomes(collapsed, lambda: move_redraw(i, s, table, eta)),
        )
        assert imbalance(pi, step) <= 1e-13


@pytest.mark.parametrize("name", WITH_WALLS)
def test_collapsed_sweeps_leave_the_posterior_invariant(name: str) -> None:
    table, eta = WITH_WALLS[name][:3, :2], 1.3
    states, pi = vector(assignment_posterior(table, eta, SMALL_PRIOR))
    likelihood = likelihood_of(table, SMALL_PRIOR)
    step = matrix(states, lambda s: sweep_law(samplers.collapsed, s, likelihood, eta))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


class Clusters(Tables):
    """Working arrays of ``cluster_collapsed`` at one partition."""

    def __init__(self, labels: tuple[int, ...], table: np.ndarray) -> None:
        n, g_count = table.shape
        super().__init__((labels, (0,) * (max(labels) + 1)), g_count)
        self.walls, self.support = np.zeros((n, g_count), np.int64), np.zeros((n, g_count), np.int64)
        self.fresh, self.fresh_walls = np.zeros((n, g_count)), np.zeros((n, g_count), np.int64)
        self.share, self.held = np.zeros((n, g_count)), np.zeros(n, np.int64)
        self.work = np.zeros(max(n, g_count) + 1)
        loops = cluster_collapsed
        loops.gather(0, table, self.label, self.sums, self.walls)
        loops.share_all(self.order, self.k, self.sums, self.walls, np.log(PRIOR), self.share, self.support, self.held)

    def rows(self, start: int, stop: int, table: np.ndarray, eta: float) -> tuple[int, ...]:
        cluster_collapsed.reassign_rows(
            start, table[start:stop], relative_of(table, PRIOR)[start:stop], self.label, self.size, self.order,
            self.rank, self.k, eta, np.log(PRIOR), self.sums, self.walls, self.fresh, self.fresh_walls, self.share,
            self.support, self.held, self.work, None,
        )  # fmt: skip
        assert (self.size == np.bincount(self.label, minlength=len(self.size))).all()
        return canonical(self.label.tolist())


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_cluster_sites_are_reversible_and_sweeps_invariant(name: str, eta: float) -> None:
    table = WITH_WALLS[name]
    states, pi = vector(partition_posterior(table, eta, PRIOR))
    for i in range(len(table)):
        step = matrix(
            states,
            lambda s, i=i: outcomes(cluster_collapsed, lambda: Clusters(s, table).rows(i, i + 1, table, eta)),
        )
        assert imbalance(pi, step) <= 1e-13
    sweep = matrix(
        states, lambda s: outcomes(cluster_collapsed, lambda: Clusters(s, table).rows(0, len(table), table, eta))
    )
    assert np.abs(pi @ sweep - pi).sum() <= 1e-12


@pytest.mark.parametrize("name", WITH_WALLS)
def test_clusters_are_reported_with_candidates_of_the_posterior(name: str) -> None:
    """From z drawn of p(z | O), one sweep gives θ of p(θ | O)."""
    table, eta = WITH_WALLS[name][:3, :2], 1.3
    likelihood = likelihood_of(table, SMALL_PRIOR)
    law = {theta: 0.0 for theta, p in assignment_posterior(table, eta, SMALL_PRIOR).items() if p > 0}

    def move(labels: tuple[int, ...]) -> tuple[int, ...]:
        state = {"label": np.array(labels), "dish": np.zeros(len(labels), np.int64)}
        after = samplers.cluster_collapsed(Chain(likelihood, eta, None, state), np.ones(1, bool))
        return tuple(after.assignments[0].tolist())

    for labels, mass in partition_posterior(table, eta, SMALL_PRIOR).items():
        for theta, p in outcomes(cluster_collapsed, lambda labels=labels: move(labels)).items():
            law[theta] += mass * p
    _, pi = vector(assignment_posterior(table, eta, SMALL_PRIOR))
    assert np.abs(np.array(list(law.values())) - pi).sum() <= 1e-12


def move_pair(labels: tuple[int, ...], table: np.ndarray, eta: float) -> tuple[int, ...]:
    n, g_count = table.shape
    table_of, n_tables = np.array(labels, np.int64), max(labels) + 1
    sums = np.zeros((n + 1, g_count))
    for i, label in enumerate(labels):
        sums[label] += table[i]
    others, side_of, wanted = (np.zeros(n, np.int64) for _ in range(3))
    count, sums = split_merge.propose(
        table, relative_of(table, PRIOR), np.log(PRIOR), eta, table_of, n_tables, sums, others, side_of, wanted,
        np.zeros(max(n, g_count) + 2), None,
    )  # fmt: skip
    assert set(table_of.tolist()) == set(range(count))
    for k in range(count):
        np.testing.assert_allclose(sums[k], table[table_of == k].sum(axis=0), atol=1e-12)
    return canonical(table_of.tolist())


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_split_merge_is_reversible(name: str, eta: float) -> None:
    table = WITH_WALLS[name]
    states, pi = vector(partition_posterior(table, eta, PRIOR))
    step = matrix(states, lambda s: outcomes(split_merge, lambda: move_pair(s, table, eta)))
    assert imbalance(pi, step) <= 1e-13
    assert (step > 0).sum() > len(states)


@pytest.mark.parametrize("n", [2, pytest.param(3, marks=pytest.mark.t2)])
def test_split_merge_sweeps_leave_the_posterior_invariant(n: int) -> None:
    table, eta = TABLES["generic"][:n, :2], 1.3
    states, pi = vector(assignment_posterior(table, eta, SMALL_PRIOR))
    likelihood = likelihood_of(table, SMALL_PRIOR)
    step = matrix(states, lambda s: sweep_law(samplers.split_merge, s, likelihood, eta))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


POWERS = (1.0, 0.5, 0.2)


@pytest.mark.parametrize("name", WITH_WALLS)
@pytest.mark.parametrize("a", [0, 1])
def test_swaps_of_levels_are_reversible(name: str, a: int) -> None:
    """On the product of three levels at N = 3, G = 2: 512 states."""
    table, eta = WITH_WALLS[name][:3, :2], 1.3
    laws = [assignment_posterior(beta * table, eta, SMALL_PRIOR) for beta in POWERS]
    possible = [theta for theta, p in laws[0].items() if p > 0]
    states = list(itertools.product(possible, repeat=3))
    pi = np.array([np.prod([law[theta] for law, theta in zip(laws, state, strict=True)]) for state in states])

    def move(state):
        theta = np.array(state, np.int32)
        fits = np.array([table[np.arange(3), level].sum() for level in theta])
        tempered.swap(a, np.array(POWERS), fits, theta, np.zeros(2), None)
        np.testing.assert_allclose(fits, [table[np.arange(3), level].sum() for level in theta])
        return tuple(tuple(level) for level in theta.tolist())

    step = matrix(states, lambda s: outcomes(tempered, lambda: move(s)))
    assert imbalance(pi, step) <= 1e-13


@pytest.mark.parametrize("level", [0, 1, 2])
def test_each_level_keeps_its_own_law(level: int) -> None:
    table, eta = TABLES["peaked"][:3, :2], 1.3
    likelihood = likelihood_of(table, SMALL_PRIOR)
    scaled, relative = levels_of(likelihood, likelihood.dense, likelihood.relative, POWERS)

    def move(theta):
        drawn = np.array(theta, np.int32)
        tempered.advance(
            scaled[level], relative[level], likelihood.edges, SMALL_PRIOR, np.log(SMALL_PRIOR), eta, drawn,
            np.zeros((1, 2)), None,
        )  # fmt: skip
        return tuple(drawn.tolist())

    states, pi = vector(assignment_posterior(POWERS[level] * table, eta, SMALL_PRIOR))
    step = matrix(states, lambda s: outcomes(tempered, lambda: move(s)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


WEIGHTS = {
    "even": [0.0, 0.0, 0.0],
    "uneven": [-0.3, 0.0, -7.0],
    "one too small for a float": [0.0, -2.0, -2000.0],
    "all but one too small": [0.0, -900.0, -901.0],
}


@pytest.mark.parametrize("weights", WEIGHTS.values(), ids=WEIGHTS.keys())
@pytest.mark.parametrize("name", WITH_WALLS)
def test_observations_given_weights_are_drawn_exactly(name: str, weights: list[float]) -> None:
    """Each on its own, ∝ w_g L_ig; also where only candidates of weights below e^−745 are possible."""
    table, log_weights = WITH_WALLS[name], np.array(weights)
    order, work = np.zeros(3, np.int64), np.zeros(3)
    reach, in_order, tail = np.zeros(3), np.zeros(3), np.zeros(4)
    blocked.by_reach(log_weights, PRIOR, reach, order, in_order, tail)

    def move():
        theta = np.zeros(4, np.int32)
        total = blocked.assign_rows(
            0, table, relative_of(table, PRIOR), log_weights, order, in_order, tail, theta, work, 0.0, None
        )
        np.testing.assert_allclose(total, table[np.arange(4), theta].sum(), rtol=1e-13)
        return tuple(theta.tolist())

    found = outcomes(blocked, move)
    log_each = table + log_weights
    each = np.exp(log_each - log_each.max(axis=1, keepdims=True))
    each /= each.sum(axis=1, keepdims=True)
    for theta in itertools.product(range(3), repeat=4):
        np.testing.assert_allclose(found.get(theta, 0.0), each[np.arange(4), theta].prod(), rtol=1e-13, atol=1e-15)


@pytest.mark.parametrize(("eta", "counts"), [(3.0, [0, 2, 1]), (0.05, [0, 3, 1]), (1e-3, [4, 0, 0])])
def test_weights_are_dirichlet(eta: float, counts: list[int]) -> None:
    """Mean and variance of w and of log w, over 40,000 draws: 5 standard errors each, 12 statistics."""
    draws, shape = 40_000, eta * PRIOR + np.array(counts)
    generator, log_w = np.random.default_rng(3), np.empty((draws, 3))
    for row in log_w:
        blocked.draw_weights(np.array(counts), PRIOR, eta, row, generator)
    assert (log_w.max(axis=1) == 0).all()
    log_w -= np.log(np.exp(log_w).sum(axis=1, keepdims=True))
    mean = shape / shape.sum()
    wanted = [
        (np.exp(log_w), mean, mean * (1 - mean) / (shape.sum() + 1)),
        (log_w, digamma(shape) - digamma(shape.sum()), polygamma(1, shape) - polygamma(1, shape.sum())),
    ]
    for values, centre, variance in wanted:
        error = np.sqrt(variance / draws)
        assert (np.abs(values.mean(axis=0) - centre) <= 5 * error + 1e-9).all()
        squares = (values - centre) ** 2
        assert (np.abs(squares.mean(axis=0) - variance) <= 5 * squares.std(axis=0) / np.sqrt(draws) + 1e-9).all()
