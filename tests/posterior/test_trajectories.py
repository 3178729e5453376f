"""The probability of whole trajectories under each draw, against sums over all paths."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from subgoal.models import Beta, Gamma, NoiseLevels, OneConfidence, OwnConfidence, Persistent, StickyHMM
from subgoal.posterior import laws as module
from subgoal.posterior import trajectories
from subgoal.posterior.laws import draw_laws
from subgoal.posterior.trajectories import is_weighted, trajectory_log_likelihood
from tests.posterior.test_export import four_walks, posterior_of

ROWS = np.array([3, 50, 119])


def by_paths(dense: np.ndarray, start: np.ndarray, step) -> float:
    """log Σ over paths of one trajectory; ``step(t, h, g)`` is the law of g after h at its t-th observation."""
    total = 0.0
    for path in itertools.product(range(dense.shape[1]), repeat=len(dense)):
        value = start[path[0]] * math.exp(sum(dense[t, g] for t, g in enumerate(path)))
        for t in range(1, len(path)):
            value *= step(t, path[t - 1], path[t])
        total += value
    return math.log(total)


@pytest.mark.parametrize("there", [None, Beta(1.0, 2.0)])
@pytest.mark.parametrize("background", [0.0, 0.3])
def test_subgoals_that_persist(there, background: float) -> None:
    posterior = posterior_of(Persistent(keep_there=there), four_walks(background), concentration=Gamma())
    found = trajectory_log_likelihood(posterior, ROWS, seed=1)
    laws = draw_laws(posterior, ROWS, 1)
    dense, arrived = posterior.likelihood.dense, posterior.likelihood.arrived.toarray()
    for k, d in itertools.product(range(3), range(4)):
        weights, keep, at = laws.weights[k], laws.keep[k], laws.keep_there[k]

        def step(t: int, h: int, g: int, keep=keep, at=at, weights=weights, d=d) -> float:
            rho = at if arrived[5 * d + t, h] else keep
            return rho * (h == g) + (1 - rho) * weights[g]

        wanted = by_paths(dense[5 * d : 5 * d + 5], weights, step)
        assert found[k, d] == pytest.approx(wanted, abs=1e-10)
    names = ["persistence"] if there is None else ["persistence", "persistence at the subgoal"]
    for name, values in zip(names, (laws.keep, laws.keep_there), strict=False):
        np.testing.assert_array_equal(values, posterior.parameters[name].ravel()[ROWS])


@pytest.mark.parametrize("confidence", [OneConfidence(), OwnConfidence(), NoiseLevels((0.5, 2.0, 8.0))])
def test_each_draw_has_its_own_noise(confidence) -> None:
    posterior = posterior_of(None, confidence=confidence)
    found, laws = trajectory_log_likelihood(posterior, ROWS), draw_laws(posterior, ROWS, 0)
    source = posterior.likelihood.source
    name = confidence.of(four_walks()).name
    for k, row in enumerate(ROWS):
        drawn = np.atleast_1d(posterior.parameters[name].reshape(120, -1)[row])
        if isinstance(confidence, NoiseLevels):
            density = sum(w * np.exp(source.log_density(0, 20, a)) for w, a in zip(drawn, (0.5, 2, 8), strict=True))
        else:
            density = np.exp(source.log_density(0, 20, drawn if drawn.size > 1 else float(drawn[0])))
        wanted = np.log(density @ laws.weights[k]).reshape(4, 5).sum(axis=1)
        np.testing.assert_allclose(found[k], wanted, rtol=0, atol=1e-11)


def test_rows_of_transitions(monkeypatch: pytest.MonkeyPatch) -> None:
    """Log weights are asked for in this order: shared ones, a row for each candidate, first steps; of each draw."""
    posterior = posterior_of(StickyHMM())
    generator = np.random.default_rng(0)
    drawn = [[generator.dirichlet(np.ones(3)) for _ in range(5)] for _ in range(2)]
    drawn[1][2][0] = 0.0
    turn = itertools.chain(*drawn)
    monkeypatch.setattr(module, "log_weights", lambda shape, generator: np.log(np.maximum(next(turn), 1e-290)))
    found, dense = trajectory_log_likelihood(posterior, ROWS[:2]), posterior.likelihood.dense
    for k, (_, *rows, first) in enumerate(drawn):
        for d in range(4):
            wanted = by_paths(dense[5 * d : 5 * d + 5], first, lambda t, h, g, rows=rows: rows[h][g])
            assert found[k, d] == pytest.approx(wanted, abs=1e-10)


def test_weights_are_powers_or_left_out() -> None:
    plain, weighted = posterior_of(), posterior_of(None, four_walks().weighted(0.3))
    assert [is_weighted(each) for each in (plain, weighted)] == [False, True]
    weights = draw_laws(weighted, ROWS, 0).weights
    dense = plain.likelihood.dense
    for power, asked in ((0.3, True), (1.0, False)):
        wanted = np.log(weights @ np.exp(power * dense).T).reshape(3, 4, 5).sum(axis=2)
        found = trajectory_log_likelihood(weighted, ROWS, weighted=asked)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11)


@pytest.mark.parametrize("model", [Persistent(keep_there=Beta()), StickyHMM()])
def test_nothing_hangs_on_how_much_is_held_at_a_time(model, monkeypatch: pytest.MonkeyPatch) -> None:
    posterior = posterior_of(model)
    whole = trajectory_log_likelihood(posterior, np.arange(120))
    monkeypatch.setattr(module, "BLOCK_ENTRIES", 30)
    monkeypatch.setattr(trajectories, "TOGETHER", 7)
    np.testing.assert_allclose(trajectory_log_likelihood(posterior, np.arange(120)), whole, rtol=0, atol=1e-12)
    tiled = replace(posterior, likelihood=replace(posterior.likelihood, dense_entries=0))
    np.testing.assert_allclose(trajectory_log_likelihood(tiled, np.arange(120)), whole, rtol=0, atol=1e-12)
