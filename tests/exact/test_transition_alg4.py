"""The exact transition law of Algorithm 4: the corrected form is right, the printed forms are measurably wrong."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal._kernels import alg4 as loops
from tests.exact.replay import matrix, outcomes, stationary
from tests.oracles.partitions import canonical
from tests.oracles.tables import PRIOR, TABLES, table_posterior

CASES = [(name, eta) for name in TABLES for eta in (0.05, 1.0, 5.0)]
LITERAL = [("peaked", 1.0, False, True), ("peaked", 1.0, True, False), ("peaked", 1.0, False, False)]


class Arrays:
    """Working arrays of the loops for one state (labels, dishes)."""

    def __init__(self, state, g_count: int) -> None:
        labels, dishes = state
        n = len(labels)
        self.label, self.dish = np.array(labels, np.int64), np.zeros(n, np.int64)
        self.dish[: len(dishes)] = dishes
        self.size, self.order, self.rank = (np.zeros(n, np.int64) for _ in range(3))
        self.work, self.sums = np.zeros(max(n, g_count) + 1), np.zeros((n, g_count))
        self.k = int(loops.occupy(self.label, self.size, self.order, self.rank))

    def state(self):
        names = canonical(self.label.tolist())
        dishes = [0] * (max(names) + 1)
        for i, name in enumerate(names):
            dishes[name] = int(self.dish[self.label[i]])
        return names, tuple(dishes)


def move_site(i, state, table, eta, keeps):
    a = Arrays(state, table.shape[1])
    loops.reassign(i, table[i], a.label, a.dish, a.size, a.order, a.rank, a.k, eta, PRIOR, keeps, a.work, None)
    assert (a.size == np.bincount(a.label, minlength=len(a.size))).all()
    return a.state()


def move_dishes(state, table, product):
    a = Arrays(state, table.shape[1])
    for i, slot in enumerate(a.label):
        a.sums[slot] += table[i] if product else np.exp(table[i])
    loops.resample_dishes(a.dish, a.order, a.k, a.sums, np.log(PRIOR), product, a.work, None)
    return a.state()


def sweep_matrix(states, table, eta, keeps, product):
    step = np.eye(len(states))
    for i in range(len(table)):
        step = step @ matrix(states, lambda s, i=i: outcomes(loops, lambda: move_site(i, s, table, eta, keeps)))
    return step @ matrix(states, lambda s: outcomes(loops, lambda: move_dishes(s, table, product)))


@pytest.mark.parametrize(("name", "eta"), CASES)
def test_corrected_site_moves_are_reversible_and_dish_moves_invariant(name: str, eta: float) -> None:
    table = TABLES[name]
    law = table_posterior(table, eta, PRIOR)
    states, pi = list(law), np.array(list(law.values()))
    for i in range(len(table)):
        step = matrix(states, lambda s, i=i: outcomes(loops, lambda: move_site(i, s, table, eta, True)))
        flow = pi[:, None] * step
        assert np.abs(flow - flow.T).max() <= 1e-13
    dishes = matrix(states, lambda s: outcomes(loops, lambda: move_dishes(s, table, True)))
    flow = pi[:, None] * dishes
    assert np.abs(flow - flow.T).max() <= 1e-13


@pytest.mark.parametrize(("name", "eta"), [("generic", 1.0), ("peaked", 1.0)])
def test_corrected_sweep_is_invariant(name: str, eta: float) -> None:
    table = TABLES[name]
    law = table_posterior(table, eta, PRIOR)
    pi = np.array(list(law.values()))
    assert np.abs(pi @ sweep_matrix(list(law), table, eta, True, True) - pi).sum() <= 1e-12


@pytest.mark.parametrize(("name", "eta", "keeps", "product"), LITERAL)
def test_printed_forms_fail(name: str, eta: float, keeps: bool, product: bool) -> None:
    """Line 14 with a fresh draw, (4.12) with a sum, and both: at least 0.02 total variation from the posterior."""
    table = TABLES[name]
    law = table_posterior(table, eta, PRIOR)
    pi = np.array(list(law.values()))
    reached = stationary(sweep_matrix(list(law), table, eta, keeps, product))
    distance = 0.5 * np.abs(reached - pi).sum()
    print(f"{name} eta={eta} singleton_keeps={keeps} product={product}: total variation {distance:.3f}")
    assert distance >= 0.02
