"""Groups with weights of their own against enumeration: site moves, seats, moves of tables; long runs; joint law."""

from __future__ import annotations

import itertools
import math
from collections import Counter

import numpy as np
import pytest
from scipy import stats
from scipy.special import roots_genlaguerre

import subgoal.partition.groups as module
import subgoal.partition.together as together_module
from subgoal._kernels import groups as loops
from subgoal.partition.groups import Grouped, _Franchise
from subgoal.partition.learning import Learning
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Chain
from subgoal.runtime.errors import InputError
from tests.exact.replay import matrix, outcomes
from tests.exact.shared_tables import ALL, assert_cuts_change_nothing, distance_ratio, with_trajectories
from tests.oracles.hdp import chain_rule, group_rows, probability
from tests.oracles.partitions import blocks, set_partitions, urn_probability
from tests.oracles.tables import PRIOR, TABLES

ETA, MASS = 1.5, 0.9
STARTS, GROUPS = (0, 1, 3), (0, 1, 0)
"""Trajectories of one, two and one observations; the first and the last are of one group."""
OWN = (0, 1, 1, 0)
"""The group of each observation."""
WEIGHTS = np.array([0.6, 0.1, 0.3])


def at(table, theta, counts=None, mass: float = MASS, model: Grouped | None = None) -> _Franchise:
    counts = np.bincount(theta, minlength=table.n_candidates) if counts is None else np.array(counts)
    state = {"theta": np.array(theta, np.int32), "counts": counts, "group_mass": np.array([mass])}
    return _Franchise(Chain(table, ETA, np.random.default_rng(0), state), model or Grouped(GROUPS, mass))


def fit(dense: np.ndarray, theta) -> float:
    return float(np.exp(sum(dense[i, g] for i, g in enumerate(theta))))


def law_of(dense: np.ndarray, own=OWN, mass=MASS, weight=1.0) -> dict:
    """p(θ, O); ``mass`` may be nodes of a quadrature with ``weight``."""
    n, g_count = dense.shape
    prior = PRIOR[:g_count] / PRIOR[:g_count].sum()
    return {
        theta: probability(group_rows(own[:n]), theta, mass, 0.0, ETA, prior) * fit(dense, theta) * weight
        for theta in itertools.product(range(g_count), repeat=n)
    }


def run(table, model, sweeps: int, seed: int = 7):
    return model(Chain(table, ETA, np.random.default_rng(seed), None), np.ones(sweeps, bool))


@pytest.mark.parametrize("name", ["generic", "barred"])
def test_redrawing_observations_leaves_the_law_given_shared_weights(name: str) -> None:
    """A pass over all, each given the others of its group: invariant for p(θ | O, β)."""
    dense, rows = ALL[name], group_rows(OWN)
    table = with_trajectories(dense, STARTS, edges=(2,))
    law = {
        theta: chain_rule(rows, theta, MASS, 0.0, WEIGHTS) * fit(dense, theta)
        for theta in itertools.product(range(3), repeat=4)
    }
    law = {theta: p for theta, p in law.items() if p > 0}
    states, pi = list(law), np.array(list(law.values()))
    pi /= pi.sum()

    def move(theta):
        tables = at(table, theta)
        tables._redraw(WEIGHTS)
        assert (tables.counts == [np.bincount(tables.theta[np.array(OWN) == k], minlength=3) for k in (0, 1)]).all()
        return tuple(int(g) for g in tables.theta)

    step = matrix(states, lambda theta: outcomes(loops, lambda: move(theta)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12


@pytest.mark.parametrize("theta", [(0, 0, 0, 0), (1, 0, 0, 1), (1, 1, 1, 0)])
def test_seats_have_their_exact_law(theta) -> None:
    """Restaurants of concentration aβ_g, one for each group and candidate: their product."""
    own = (0, 0, 0, 0) if theta == (0, 0, 0, 0) else OWN
    model = Grouped((own[0], own[1], own[3]), MASS)
    table = with_trajectories(TABLES["generic"], STARTS)
    pairs = list(zip(own, theta, strict=True))
    wanted: dict = {}
    for labels in set_partitions(4):
        members = blocks(labels)
        if any(len({pairs[i] for i in block}) > 1 for block in members):
            continue
        value = 1.0
        for pair, n in Counter(pairs).items():
            sizes = [len(block) for block in members if pairs[block[0]] == pair]
            alpha = MASS * WEIGHTS[pair[1]]
            value *= alpha ** len(sizes) * math.prod(math.factorial(s - 1) for s in sizes)
            value /= np.prod([alpha + k for k in range(n)])
        wanted[labels] = value
    assert abs(sum(wanted.values()) - 1) <= 1e-12

    def move():
        tables = at(table, theta, model=model)
        table_of, n_tables = tables._seat(WEIGHTS)
        assert n_tables == len(set(table_of.tolist()))
        return tuple(int(t) for t in table_of)

    found = outcomes(module, move)
    assert max(abs(found.get(labels, 0.0) - p) for labels, p in wanted.items()) <= 1e-13


@pytest.mark.parametrize("together", [False, True])
@pytest.mark.parametrize("seats", [(0, 1, 1, 2), (0, 1, 2, 0)])
def test_moves_of_tables_leave_the_posterior_invariant(seats, together: bool, monkeypatch) -> None:
    """Given the seating, tables are observations of the mixture with β integrated out; also moved only together."""
    monkeypatch.setattr(together_module, "ENTRIES", 0 if together else 2**24)
    monkeypatch.setattr(together_module, "SWEEPS", 1)
    dense, prior = TABLES["generic"][:, :2], PRIOR[:2] / PRIOR[:2].sum()
    table = with_trajectories(dense, STARTS, prior, edges=(1,))
    table_of = np.array(seats)
    law = {
        dishes: urn_probability(dishes, ETA, prior) * fit(dense, [dishes[t] for t in seats])
        for dishes in itertools.product(range(2), repeat=3)
    }
    states, pi = list(law), np.array(list(law.values()))
    pi /= pi.sum()

    def move(dishes):
        tables = at(table, [dishes[t] for t in seats])
        tables._move_tables(table_of, 3)
        found = tuple(int(tables.theta[seats.index(t)]) for t in range(3))
        assert (tables.shared == np.bincount(found, minlength=2)).all()
        assert (tables.counts.sum(axis=0) == np.bincount(tables.theta, minlength=2)).all()
        return found

    step = matrix(states, lambda dishes: outcomes(together_module, lambda: move(dishes)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12
    assert np.abs(step - np.eye(len(states))).max() >= 0.1


@pytest.mark.parametrize("name", ["generic", "barred", "flat"])
def test_runs_reach_the_enumerated_posterior(name: str) -> None:
    """Total variation at most 3 times that of half as many independent draws; a flat table gives the prior."""
    table = with_trajectories(ALL[name], STARTS, edges=(2,))
    assert distance_ratio(run(table, Grouped(GROUPS, MASS), 2000).assignments, law_of(ALL[name])) <= 3


@pytest.mark.t2
@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("mass", [0.2, MASS, 6.0])
@pytest.mark.parametrize("together", [False, True])
def test_long_runs_reach_the_enumerated_posterior(name: str, mass: float, together: bool, monkeypatch) -> None:
    monkeypatch.setattr(together_module, "ENTRIES", 0 if together else 2**24)
    draws = run(with_trajectories(ALL[name], STARTS), Grouped(GROUPS, mass), 12_000).assignments
    assert distance_ratio(draws, law_of(ALL[name], mass=mass)) <= 3


def test_one_group_is_its_own_marginal() -> None:
    """One group: β and w integrated out in turn, by enumeration; very large a is the mixture of 2.1."""
    dense = TABLES["generic"]
    table = with_trajectories(dense, STARTS)
    law = law_of(dense, (0, 0, 0, 0))
    assert distance_ratio(run(table, Grouped((0, 0, 0), MASS), 2000).assignments, law) <= 3
    mixture = {theta: urn_probability(theta, ETA, PRIOR) * fit(dense, theta) for theta in law}
    assert distance_ratio(run(table, Grouped((0, 1, 0), 1e9), 2000).assignments, mixture) <= 3


@pytest.mark.parametrize("sweeps", [4000, pytest.param(40_000, marks=pytest.mark.t2)])
def test_what_is_learned_has_its_posterior(sweeps: int) -> None:
    """a ~ Gamma(3, 1), integrated by quadrature: θ and the mean of a."""
    dense, law = TABLES["peaked"], Gamma(3.0, 1.0)
    x, u = roots_genlaguerre(40, law.shape - 1)
    paths = law_of(dense, mass=x, weight=u / u.sum())
    done = run(with_trajectories(dense, STARTS), Grouped(GROUPS, law), sweeps)
    assert distance_ratio(done.assignments, {theta: float(p.sum()) for theta, p in paths.items()}) <= 3
    wanted = sum((p * x).sum() for p in paths.values()) / sum(p.sum() for p in paths.values())
    # Six standard errors of a tenth as many independent draws.
    assert abs(done.parameters["group mass"].mean() - wanted) <= 6 * 1.9 / np.sqrt(sweeps / 10)


def test_the_concentration_is_learned_beside_it() -> None:
    """η ~ Gamma(2, 1) through ``Learning``: on a flat table its law is the prior."""
    model = Learning(Grouped(GROUPS, MASS), concentration=Gamma(2.0, 1.0))
    done = run(with_trajectories(ALL["flat"], STARTS), model, 4000)
    # Six standard errors of 400 independent draws.
    assert abs(done.parameters["concentration"].mean() - 2.0) <= 6 * np.sqrt(2.0 / 400)


def test_the_log_joint_is_that_of_all_that_is_drawn() -> None:
    dense, theta = TABLES["generic"], (0, 2, 2, 0)
    tables = at(with_trajectories(dense, STARTS), theta, (1, 0, 1), 1.7, Grouped(GROUPS, Gamma(3.0, 2.0)))
    tables._draw_weights = lambda: np.log(WEIGHTS)
    found_fit, found = tables.log_joint()
    assert abs(found_fit - np.log(fit(dense, theta))) <= 1e-12
    grouped = WEIGHTS[[0, 2, 1]]
    wanted = found_fit + np.log(chain_rule(group_rows(OWN), theta, 1.7, 0.0, WEIGHTS))
    wanted += stats.dirichlet(ETA * PRIOR[[0, 2, 1]]).logpdf(grouped) + np.log(grouped).sum()
    wanted += stats.gamma(3.0, scale=1 / 2.0).logpdf(1.7)
    assert abs(found - wanted) <= 1e-12


def test_cutting_a_run_and_its_tiles_changes_nothing() -> None:
    assert_cuts_change_nothing(Grouped(np.array(GROUPS)), ETA, STARTS)


def test_counts_of_groups_go_with_the_draws(monkeypatch) -> None:
    """And are left out where they would be large."""
    table = with_trajectories(TABLES["generic"], STARTS)
    done = run(table, Grouped(GROUPS), 50)
    counts = done.parameters["group counts"]
    assert counts.dtype == np.int32
    for draw, theta in zip(counts, done.assignments, strict=True):
        assert draw.tolist() == [np.bincount(theta[np.array(OWN) == k], minlength=3).tolist() for k in (0, 1)]
    monkeypatch.setattr(module, "COUNT_ENTRIES", 50 * 2 * 3)
    assert "group counts" not in run(table, Grouped(GROUPS), 50).parameters


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (4, 1)])
def test_one_observation_and_one_candidate(shape: tuple[int, int]) -> None:
    dense = TABLES["generic"][: shape[0], : shape[1]]
    done = run(with_trajectories(dense, (0,)), Grouped([0]), 1000)
    assert np.isfinite(done.log_joint).all()
    if shape == (1, 3):
        law = PRIOR * np.exp(dense[0])
        assert distance_ratio(done.assignments, {(g,): float(p) for g, p in enumerate(law)}) <= 3
    else:
        assert (done.assignments == 0).all()


def test_impossible_candidates_are_never_chosen() -> None:
    done = run(with_trajectories(ALL["barred"], STARTS), Grouped(GROUPS), 500)
    assert not (done.assignments[:, 1] == 0).any()
    assert not (done.assignments[:, 2] == 1).any()


@pytest.mark.parametrize("group", [[], [0.5, 1.0], [[0, 1]], [0, -1], [0, 7], "ab"])
def test_bad_groups_are_refused(group) -> None:
    with pytest.raises(InputError, match="group"):
        Grouped(group)


def test_other_bad_input_is_refused() -> None:
    with pytest.raises(InputError, match="mass of the groups"):
        Grouped([0], mass=-1.0)
    with pytest.raises(InputError, match="2 trajectories, wanted 3"):
        run(with_trajectories(TABLES["generic"], STARTS), Grouped([0, 1]), 1)
    assert Grouped([0, 1]) == Grouped(np.array([0, 1]))
    assert (Grouped([0, 1]).__name__, Grouped([0, 1]).n_groups) == ("grouped", 2)
