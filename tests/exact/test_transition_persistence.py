"""Subgoals that persist: the path drawn backward has its exact law, moves of runs keep it, long runs reach it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy import sparse

from subgoal._kernels import persistence as loops
from subgoal.partition.persistence import Persistent, _Steps
from subgoal.partition.priors import Beta
from subgoal.partition.protocol import Chain
from tests.exact.replay import matrix, outcomes
from tests.oracles.partitions import urn_probability
from tests.oracles.persistence import beta_probability, given_weights, posterior, step_probability
from tests.oracles.tables import PRIOR, TABLES
from tests.statistical.toy import PlainTable

STARTS = (0, 3)
"""Two trajectories: three observations and one."""
ARRIVED = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 1], [1, 0, 0]], bool)
KEEPS = [(0.6, 0.6), (0.8, 0.3), (0.0, 0.0), (0.5, 0.95)]
ETA = 1.0


def temporal_table(name: str, rows: int = 4, columns: int = 3) -> SimpleNamespace:
    """A table of two trajectories and of what is at which candidate, in two blocks of rows."""
    dense = TABLES[name][:rows, :columns]
    prior = PRIOR[:columns] / PRIOR[:columns].sum()
    plain = PlainTable(dense, np.log(prior))
    return SimpleNamespace(
        n_observations=rows, n_candidates=columns, log_prior=plain.log_prior, dense=dense, relative=plain.relative,
        edges=plain.edges, tiles=plain.tiles, relative_tile=plain.relative_tile, rows=lambda a, b: dense[a:b],
        offset=np.array([*(s for s in STARTS if s < rows), rows]),
        arrived=sparse.csr_array(ARRIVED[:rows, :columns]),
    )  # fmt: skip


def steps_at(table, model: Persistent, state, keep: float, keep_there: float) -> _Steps:
    start = {
        "theta": np.array(state[0], np.int32), "redrawn": np.array(state[1], bool), "keep": np.array([keep, keep_there])
    }  # fmt: skip
    return _Steps(Chain(table, ETA, None, start), model)


@pytest.mark.parametrize("keeps", KEEPS)
@pytest.mark.parametrize("name", TABLES)
def test_the_path_has_its_exact_law(name: str, keeps: tuple[float, float]) -> None:
    """Whatever the state before: forward filtering and backward drawing is a draw from p(θ, redrawn | O, w, ρ)."""
    table, weights = temporal_table(name), np.array([0.2, 0.7, 0.1])
    wanted = given_weights(table.dense, STARTS, weights, *keeps, ARRIVED)
    model = Persistent(keep=keeps[0], keep_there=keeps[1])

    def move():
        steps = steps_at(table, model, ((0, 0, 1, 2), (True, False, True, True)), *keeps)
        steps._draw_path(weights)
        return tuple(int(g) for g in steps.theta), tuple(bool(r) for r in steps.redrawn)

    found = outcomes(loops, move)
    assert set(found) <= {state for state, p in wanted.items() if p > 0}
    assert max(abs(found.get(state, 0.0) - p) for state, p in wanted.items()) <= 1e-13


def test_the_filter_gives_the_evidence() -> None:
    """Σ log p(a_i | before) is log p(O | w, ρ), by enumeration of all paths."""
    table, weights, keeps = temporal_table("generic"), np.array([0.2, 0.7, 0.1]), (0.8, 0.3)
    steps = steps_at(table, Persistent(keep=keeps[0], keep_there=keeps[1]), ((0,) * 4, (True,) * 4), *keeps)
    out, log_total = np.empty((4, 3)), np.empty(4)
    loops.filter_rows(
        0, table.relative, steps.first, steps.there_from, steps.there, weights, *keeps, np.zeros(3), out, log_total
    )
    value = log_total.sum()
    from tests.oracles.persistence import fit, paths

    total = sum(
        fit(state[0], table.dense) * step_probability(state, STARTS, *keeps, ARRIVED)
        * np.prod([weights[g] for g, r in zip(*state, strict=True) if r])
        for state in paths(4, 3, STARTS)
    )  # fmt: skip
    marginal = np.log(np.exp(table.dense) @ PRIOR).sum()
    assert abs(value + marginal - np.log(total)) <= 1e-12
    assert np.abs(out.sum(axis=1) - 1).max() <= 1e-12


@pytest.mark.parametrize("keeps", [pytest.param((0.6, 0.6), marks=pytest.mark.t2), (0.8, 0.3)])
@pytest.mark.parametrize("together", [False, True])
def test_moves_of_runs_leave_the_posterior_invariant(keeps, together: bool, monkeypatch) -> None:
    """Given where redraws fall; with runs moved one by one and with runs only moved together."""
    import subgoal.partition.together as module
    from subgoal._kernels import collapsed_blocks

    monkeypatch.setattr(module, "ENTRIES", 0 if together else 2**24)
    monkeypatch.setattr(module, "SWEEPS", 1)
    table = temporal_table("generic", 4, 2)
    prior = np.exp(table.log_prior)
    arrived = ARRIVED[:, :2]
    law = posterior(table.dense, STARTS, ETA, prior, lambda s: step_probability(s, STARTS, *keeps, arrived))
    states, pi = list(law), np.array(list(law.values()))
    model = Persistent(keep=keeps[0], keep_there=keeps[1])

    def move(state):
        steps = steps_at(table, model, state, *keeps)
        steps._move_runs()
        return tuple(int(g) for g in steps.theta), state[1]

    step = matrix(states, lambda state: outcomes(collapsed_blocks, lambda: move(state)))
    assert np.abs(pi @ step - pi).sum() <= 1e-12
    assert np.abs(step - np.eye(len(states))).max() >= 0.1


def test_without_persistence_it_is_the_mixture() -> None:
    """ρ = 0: the law of θ is the urn's."""
    table = temporal_table("generic")
    law = posterior(table.dense, STARTS, ETA, PRIOR, lambda s: step_probability(s, STARTS, 0.0, 0.0, ARRIVED))
    for theta, redrawn in law:
        if all(redrawn):
            assert law[theta, redrawn] > 0
            continue
        assert law[theta, redrawn] == 0
    total = sum(
        urn_probability(theta, ETA, PRIOR) * np.exp(sum(table.dense[i, g] for i, g in enumerate(theta)))
        for theta, redrawn in law if all(redrawn)
    )  # fmt: skip
    run = Persistent(keep=0.0)(Chain(table, ETA, np.random.default_rng(3)), np.ones(40_000, bool))
    seen = {}
    for theta in run.assignments:
        seen[tuple(int(g) for g in theta)] = seen.get(tuple(int(g) for g in theta), 0) + 1
    gaps = [
        abs(count / 40_000 - urn_probability(theta, ETA, PRIOR)
            * np.exp(sum(table.dense[i, g] for i, g in enumerate(theta))) / total)
        for theta, count in seen.items()
    ]  # fmt: skip
    # Largest of 81 cells, each with a standard error below 0.0025·√(autocorrelation): 6 of them.
    assert max(gaps) <= 0.015


@pytest.mark.parametrize("name", TABLES)
def test_long_runs_reach_the_enumerated_posterior(name: str) -> None:
    """ρ ~ Beta(2, 1) learned; total variation at most 3 times that of a tenth as many independent draws."""
    table, sweeps = temporal_table(name), 60_000
    law = posterior(table.dense, STARTS, ETA, PRIOR, lambda s: beta_probability(s, STARTS, 2.0, 1.0))
    paths: dict[tuple[int, ...], float] = {}
    for (theta, _), p in law.items():
        paths[theta] = paths.get(theta, 0.0) + p
    states, pi = list(paths), np.array(list(paths.values()))
    run = Persistent(keep=Beta(2.0, 1.0))(Chain(table, ETA, np.random.default_rng(7)), np.ones(sweeps, bool))
    place = {state: k for k, state in enumerate(states)}
    reached = np.bincount([place[tuple(int(g) for g in t)] for t in run.assignments], minlength=len(states)) / sweeps
    independent = np.random.default_rng(8).multinomial(sweeps // 10, pi, size=200) / (sweeps // 10)
    assert 0.5 * np.abs(reached - pi).sum() <= 3 * np.mean(0.5 * np.abs(independent - pi).sum(axis=1))
    kept = sum(p * sum(not r for r in state[1]) for state, p in law.items())
    mean = sum(p * (2 + sum(not r for r in s[1])) / 5 for s, p in law.items())
    assert kept > 0
    # 60,000 sweeps, ρ with a standard deviation below 0.25 and little autocorrelation: five standard errors.
    assert abs(run.parameters["persistence"].mean() - mean) <= 0.01
