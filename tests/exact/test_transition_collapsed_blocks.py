"""The exact transition law of ``collapsed_blocks``: reversible site moves, invariant block moves and sweeps."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal._kernels import collapsed_blocks as loops
from subgoal._kernels.counts import recount
from subgoal._kernels.seating import seating_for
from tests.exact.replay import matrix, outcomes
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

EDGES = np.array([0, 2, 3])
"""The whole sweep goes through its table in two blocks."""
CASES = [(name, eta) for name in TABLES for eta in (0.05, 1.0, 5.0)]


class Arrays:
    """Working arrays of the loops for one state."""

    def __init__(self, theta: tuple[int, ...], log_table: np.ndarray, prior: np.ndarray) -> None:
        n, g_count = log_table.shape
        self.log_table, self.prior, self.log_prior = log_table, prior, np.log(prior)
        marginal = np.log(np.exp(log_table) @ prior)
        self.relative = np.exp(log_table - marginal[:, None])
        self.theta = np.array(theta, np.int32)
        self.counts, self.active, self.place = (np.zeros(g_count, np.int64) for _ in range(3))
        self.seating, self.dishes, self.held = seating_for(n, g_count), np.zeros(n, np.int64), np.zeros(g_count)
        self.work, self.sums = np.zeros(max(n, g_count) + 1), np.zeros((n + 1, g_count))
        self.k = int(recount(self.theta, self.counts, self.active, self.place))
        loops.largest_first(self.counts, self.active, self.place, self.held, self.k)


def move_site(i: int, theta, log_table, prior, eta):
    a = Arrays(theta, log_table, prior)
    k = loops.redraw_rows(i, a.relative[i : i + 1], a.theta, a.active, a.place, a.held, a.k, eta, prior, a.work, None)
    check = Arrays(tuple(a.theta), log_table, prior)
    assert dict(zip(a.active[:k], a.held[:k], strict=True)) == {g: n for g, n in enumerate(check.counts) if n > 0}
    assert [int(a.place[g]) for g in a.active[:k]] == list(range(k))
    assert (a.place[check.counts == 0] == -1).all()
    return tuple(int(g) for g in a.theta)


def move_all_blocks(theta, log_table, prior, eta):
    a = Arrays(theta, log_table, prior)
    n_tables = loops.seat_rows(0, log_table, a.theta, eta * prior, a.seating, a.sums, 0, None)
    loops.move_blocks(n_tables, a.sums, a.log_prior, a.seating.table_of, a.theta, a.dishes, a.work, None)
    return tuple(int(g) for g in a.theta)


def sweep(theta, log_table, prior, eta):
    a = Arrays(theta, log_table, prior)
    keep, trace = np.ones(1, bool), [np.zeros(1) for _ in range(2)]
    kept, active = np.zeros((1, len(theta)), np.int32), np.zeros(1, np.int64)
    loops.sweeps_dense(
        log_table, a.relative, EDGES, prior, a.log_prior, eta, a.theta, a.sums[:1], keep, kept, *trace, active, None
    )
    return tuple(int(g) for g in kept[0])


def posterior_vector(log_table, eta, prior):
    law = assignment_posterior(log_table, eta, prior)
    return list(law), np.array(list(law.values()))


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_every_site_move_is_reversible(name: str, eta: float) -> None:
    table = TABLES[name]
    states, pi = posterior_vector(table, eta, PRIOR)
    for i in range(len(table)):
        step = matrix(states, lambda s, i=i: outcomes(loops, lambda: move_site(i, s, table, PRIOR, eta)))
        flow = pi[:, None] * step
        assert np.abs(flow - flow.T).max() <= 1e-13
        assert np.abs(step.sum(axis=1) - 1).max() <= 1e-12


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_block_move_leaves_the_posterior_invariant(name: str, eta: float) -> None:
    table = TABLES[name]
    states, pi = posterior_vector(table, eta, PRIOR)
    step = matrix(states, lambda s: outcomes(loops, lambda: move_all_blocks(s, table, PRIOR, eta)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


@pytest.mark.parametrize(("name", "eta"), [("generic", 1.0), ("peaked", 5.0)])
def test_whole_shipped_sweep_leaves_the_posterior_invariant(name: str, eta: float) -> None:
    table, prior = TABLES[name][:3, :2], np.array([0.7, 0.3])
    states, pi = posterior_vector(table, eta, prior)
    step = matrix(states, lambda s: outcomes(loops, lambda: sweep(s, table, prior, eta)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


def test_a_slightly_wrong_likelihood_would_be_noticed() -> None:
    """The power of the check: L to the power 0.95 moves the invariant law by about 1e-2."""
    table, eta = TABLES["peaked"], 1.0
    states, pi = posterior_vector(table, eta, PRIOR)
    step = matrix(states, lambda s: outcomes(loops, lambda: move_all_blocks(s, 0.95 * table, PRIOR, eta)))
    assert np.abs(pi @ step - pi).sum() >= 1e-3
