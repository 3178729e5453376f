"""Exact transition matrices of every move of the mixture samplers, over every state: no seed, no luck.

The matrices are built by the very ``leave``, ``law``, ``join`` that the samplers run; the stationary law comes from
the chain rule and from densities computed here. Wrong variants are planted to see the test catch them.
"""

from __future__ import annotations

import math
from copy import deepcopy
from itertools import product

import numpy as np
import pytest
from scipy.stats import multivariate_t

from subgoal.partition.crp_seating import Collapsed, Uncollapsed, choose
from subgoal.partition.normal_inverse_wishart import NormalInverseWishart
from tests.oracles.partitions import blocks, canonical, crp_probability, set_partitions, table_states
from tests.partition.finite_base import FiniteBase, a_base

POINTS = {1: [[-1.0], [-0.8], [0.1], [1.2], [1.3]], 2: [[-1.0, 0.0], [-0.8, 0.3], [0.9, 0.4], [1.2, -0.7]]}


def normalised(log_weight: np.ndarray) -> np.ndarray:
    weight = np.exp(log_weight - log_weight.max())
    return weight / weight.sum()


def student_t_marginal(prior: NormalInverseWishart, points: np.ndarray) -> float:
    density = 1.0
    for n, x in enumerate(points):
        d, now = points.shape[1], prior.posterior(points[:n])
        freedom = now.degrees - d + 1
        shape = now.scale * (now.strength + 1) / (now.strength * freedom)
        density *= math.exp(multivariate_t(now.mean, shape, df=freedom).logpdf(x))
    return density


def collapsed_site(kind: type[Collapsed], points, base, eta, i) -> np.ndarray:
    """(states, states) matrix of one collapsed update of point ``i``."""
    states = list(set_partitions(len(points)))
    place = {state: row for row, state in enumerate(states)}
    matrix = np.zeros((len(states), len(states)))
    for row, state in enumerate(states):
        room = kind(points, base, np.array(state), eta)
        room.leave(i)
        for table, chance in enumerate(normalised(room.law(i))):
            after = deepcopy(room)
            after.join(i, table)
            matrix[row, place[canonical(after.tables.label.tolist())]] += chance
    return matrix


def worst(law: np.ndarray, sites: list[np.ndarray]) -> tuple[float, float]:
    """Largest breach of detailed balance of a site, and |πP − π|₁ of the sweep."""
    flows = [law[:, None] * site for site in sites]
    balance = max(float(np.abs(flow - flow.T).max()) for flow in flows)
    after = law
    for site in sites:
        np.testing.assert_allclose(site.sum(axis=1), 1.0, rtol=1e-13)
        after = after @ site
    return balance, float(np.abs(after - law).sum())


class CountsItself(Collapsed):
    """Planted bug: the weight of the cluster that i left counts i still."""

    def leave(self, i):
        self.own = int(self.tables.label[i])
        self.closed = self.tables.count[self.own] == 1
        super().leave(i)

    def law(self, i):
        weight = super().law(i)
        if not self.closed:
            weight[self.own] += np.log1p(1 / self.tables.count[self.own])
        return weight


class Tempered(Collapsed):
    """Planted bug, the subtle kind: the likelihood to the power 0.95."""

    def law(self, i):
        prior = np.log(np.append(self.tables.count[: self.tables.size], self.eta))
        return prior + 0.95 * (super().law(i) - prior)


def gaussian_case(d: int, eta: float):
    points = np.array(POINTS[d])
    base = NormalInverseWishart(np.full(d, 0.2), 0.3, 0.2 * np.eye(d), d + 2.0)
    law = np.array(
        [
            crp_probability(z, eta) * math.prod(student_t_marginal(base, points[block]) for block in blocks(z))
            for z in set_partitions(len(points))
        ]
    )
    return points, base, law / law.sum()


@pytest.mark.parametrize("eta", [0.3, 1.0, 8.0])
@pytest.mark.parametrize("d", [1, 2])
def test_collapsed_keeps_the_posterior(d, eta):
    points, base, law = gaussian_case(d, eta)
    balance, drift = worst(law, [collapsed_site(Collapsed, points, base, eta, i) for i in range(len(points))])
    assert balance <= 1e-13
    assert drift <= 1e-12


@pytest.mark.parametrize("planted", [CountsItself, Tempered])
def test_planted_bugs_in_the_collapsed_law_are_seen(planted):
    points, base, law = gaussian_case(1, 1.0)
    balance, drift = worst(law, [collapsed_site(planted, points, base, 1.0, i) for i in range(len(points))])
    assert balance > 1e-4
    assert drift > 1e-3


def test_collapsed_over_a_finite_base():
    base = a_base(5, 3)
    law = np.array([crp_probability(z, 1.4) for z in set_partitions(5)])
    for row, z in enumerate(set_partitions(5)):
        for block in blocks(z):
            law[row] *= sum(p * np.exp(base.table[block, g].sum()) for g, p in enumerate(base.prior))
    law /= law.sum()
    balance, drift = worst(law, [collapsed_site(Collapsed, base.points, base, 1.4, i) for i in range(5)])
    assert balance <= 1e-13
    assert drift <= 1e-12


def auxiliary_law(base: FiniteBase, i: int, fitted: bool) -> np.ndarray:
    """(G,) law of one fresh parameter: the prior, or (as printed) the posterior given x_i alone."""
    weight = base.prior * (np.exp(base.table[i]) if fitted else 1.0)
    return weight / weight.sum()


def uncollapsed_site(base: FiniteBase, eta, m, i, *, keeps_own=True, fitted=False) -> np.ndarray:
    """(states, states) matrix of one update of point ``i``, fresh parameters summed out; a state is (z, θ)."""
    states = list(table_states(len(base.points), len(base.prior)))
    place = {state: row for row, state in enumerate(states)}
    matrix, chance = np.zeros((len(states), len(states))), auxiliary_law(base, i, fitted)
    for row, (labels, dishes) in enumerate(states):
        for fresh in product(range(len(base.prior)), repeat=m):
            drawn = np.prod(chance[list(fresh)])
            dish = np.array(dishes, float)[:, None]
            room = Uncollapsed(base.points, base, np.array(labels), eta, dish)
            auxiliary = room.leave(i, np.array(fresh, float)[:, None], keeps_own=keeps_own)
            for choice, weight in enumerate(normalised(room.law(i, auxiliary))):
                after = deepcopy(room)
                after.join(i, choice, auxiliary)
                matrix[row, place[as_state(after)]] += drawn * weight
    return matrix


def as_state(room: Uncollapsed) -> tuple[tuple[int, ...], tuple[int, ...]]:
    label = room.tables.label.tolist()
    order = sorted(set(label), key=label.index)
    return canonical(label), tuple(int(room.tables.rows["parameter"][table, 0]) for table in order)


def seating_law(base: FiniteBase, eta: float) -> np.ndarray:
    law = []
    for labels, dishes in table_states(len(base.points), len(base.prior)):
        weight = crp_probability(labels, eta) * math.prod(base.prior[g] for g in dishes)
        law.append(weight * math.exp(sum(base.table[i, dishes[table]] for i, table in enumerate(labels))))
    return np.array(law) / sum(law)


@pytest.mark.parametrize(("n", "candidates", "m"), [(4, 2, 1), (3, 2, 3), (3, 3, 2)])
@pytest.mark.parametrize("eta", [0.5, 5.0])
def test_neal_8_keeps_the_posterior(n, candidates, m, eta):
    base = a_base(n, candidates)
    sites = [uncollapsed_site(base, eta, m, i) for i in range(n)]
    balance, drift = worst(seating_law(base, eta), sites)
    assert balance <= 1e-13
    assert drift <= 1e-12


@pytest.mark.parametrize(
    "wrong", [{"keeps_own": False}, {"fitted": True}, {"keeps_own": False, "fitted": True}], ids=str
)
def test_the_printed_forms_have_another_stationary_law(wrong):
    """Fresh draws for a point alone, and auxiliaries fitted to x_i: at least 0.02 of total variation away."""
    base, eta = a_base(3, 3), 2.0
    sweep = np.linalg.multi_dot([uncollapsed_site(base, eta, 1, i, **wrong) for i in range(3)])
    law = seating_law(base, eta)
    settled = law @ np.linalg.matrix_power(sweep, 400)
    assert np.abs(settled @ sweep - settled).sum() < 1e-10
    assert 0.5 * np.abs(settled - law).sum() > 0.02


def test_one_choice_follows_its_weights():
    """The step between a law and a move: 10,000 draws, chi-square at 1e-6."""
    from scipy.stats import chisquare

    weight = np.array([-700.0, -701.0, -np.inf, -699.5, -703.0])
    generator = np.random.Generator(np.random.PCG64(4))
    counts = np.bincount([choose(weight, generator) for _ in range(10_000)], minlength=5)
    assert counts[2] == 0
    seen = np.isfinite(weight)
    assert chisquare(counts[seen], 10_000 * normalised(weight[seen])).pvalue > 1e-6


@pytest.mark.parametrize("kind", ["collapsed", "uncollapsed"])
def test_bookkeeping_over_many_moves(kind):
    """What is kept about each table after 300 moves is what a fresh count gives."""
    base, generator = a_base(6, 3), np.random.Generator(np.random.PCG64(9))
    if kind == "collapsed":
        room = Collapsed(base.points, base, np.zeros(6, int), 2.0)
    else:
        room = Uncollapsed(base.points, base, np.zeros(6, int), 2.0, base.parameters[:1])
    for move in range(300):
        i, fresh = move % 6, base.draw_given(np.zeros((2, 3)), generator)
        extra = () if kind == "collapsed" else (room.leave(i, fresh),)
        if kind == "collapsed":
            room.leave(i)
        room.join(i, choose(room.law(i, *extra), generator), *extra)
        tables = room.tables
        assert set(tables.label.tolist()) == set(range(tables.size))
        np.testing.assert_array_equal(tables.count[: tables.size], np.bincount(tables.label))
        for k in range(tables.size):
            seated = tables.label == k
            if kind == "collapsed":
                total = base.table[seated].sum(axis=0)
                np.testing.assert_allclose(tables.rows["totals"][k], total, atol=1e-11)
                kept, wanted = tables.rows["log_marginal"][k], base.log_marginal_of(total[None])[0]
            else:
                kept, wanted = tables.rows["column"][k], base.table[:, int(tables.rows["parameter"][k, 0])]
            np.testing.assert_allclose(kept, wanted, atol=1e-11)
