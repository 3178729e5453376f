"""Filtering of held-out demonstrations: against sums over all paths, of each model; and what it refuses."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.special import logsumexp

import subgoal
from subgoal._kernels import filters
from subgoal.answers.filtering import filtering
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.again import same_likelihood
from subgoal.models import Beta, Gamma, Grouped, NoiseLevels, OwnConfidence, Persistent, StickyHMM
from subgoal.posterior import laws as module
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError
from tests.posterior.worlds import corner_likelihood, quiet_sample, table

LENGTH = {"chains": 2, "draws": 12, "warmup": 30, "thin": 2, "seed": 3}
GOALS = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])


def three_goals() -> subgoal.LogLikelihood:
    demos = corner_likelihood().demonstrations
    return subgoal.action_comparison(demos, subgoal.Candidates(GOALS, [0.2, 0.9, 0.4], radius=4.0), confidence=2.0)


def held_out() -> Demonstrations:
    """Two trajectories of four and two steps; at the corner (10, 0) in the third and fourth."""
    states = np.array([[4.0, 0.5], [8.5, 0.1], [10.0, 0.2], [9.5, 0.5], [10.0, 5.0], [2.0, 0.0]])
    actions = np.array([[1.0, 0.1], [1.0, -0.4], [-0.2, 1.0], [0.1, 1.0], [0.0, -1.0], [-1.0, 0.3]])
    return Demonstrations.from_arrays(states, actions, [0, 4, 6])


def posterior_of(model=None, likelihood: subgoal.LogLikelihood | None = None, **settings) -> Posterior:
    return quiet_sample(likelihood or three_goals(), model=model, **{**LENGTH, **settings})


def by_paths(dense: np.ndarray, offset, start: np.ndarray, step) -> tuple[np.ndarray, np.ndarray]:
    """log p(a_t | before) and p(θ_t | up to t) of each trajectory by sums over all paths; ``step(i, h, g)``."""
    n, g_count = dense.shape
    predictive, probability = np.empty(n), np.empty((n, g_count))
    for a, b in itertools.pairwise(offset):
        before = 1.0
        for t in range(a, b):
            total = np.zeros(g_count)
            for path in itertools.product(range(g_count), repeat=t - a + 1):
                value = start[path[0]] * math.exp(sum(dense[a + k, g] for k, g in enumerate(path)))
                for k in range(1, len(path)):
                    value *= step(a + k, path[k - 1], path[k])
                total[path[-1]] += value
            predictive[t] = math.log(total.sum() / before)
            probability[t], before = total / total.sum(), total.sum()
    return predictive, probability


def weights_given(patch: pytest.MonkeyPatch, *rows: np.ndarray) -> None:
    """The weights that are drawn, in turn."""
    turn = itertools.cycle(rows)
    patch.setattr(module, "log_weights", lambda shape, generator: np.log(next(turn)))


@pytest.mark.parametrize("background", [0.0, 0.3])
@pytest.mark.parametrize("there", [None, Beta(1.0, 2.0)])
def test_subgoals_that_persist_are_filtered_as_the_sum_over_paths(background: float, there, monkeypatch) -> None:
    """One draw of known weights; ρ of that draw, another one where the state is at the subgoal."""
    likelihood = three_goals().with_background(background)
    posterior = posterior_of(Persistent(keep_there=there), likelihood)
    w = np.array([0.2, 0.5, 0.3]) if not background else np.array([0.15, 0.45, 0.1, 0.3])
    weights_given(monkeypatch, w)
    found = filtering(posterior, held_out(), draws=1)
    keep = posterior.parameters["persistence"].ravel()[0]
    other = keep if there is None else posterior.parameters["persistence at the subgoal"].ravel()[0]
    assert there is None or abs(other - keep) > 0.01
    held = same_likelihood(posterior.likelihood, held_out())
    arrived = held.arrived.toarray()
    assert arrived.sum() >= 4

    def step(i: int, h: int, g: int) -> float:
        rho = other if arrived[i, h] else keep
        return rho * (g == h) + (1 - rho) * w[g]

    predictive, probability = by_paths(held.dense, [0, 4, 6], w, step)
    np.testing.assert_allclose(found.log_predictive, predictive, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.probability, probability[:, :3], rtol=0, atol=1e-12)
    assert found.bits_per_decision == pytest.approx(predictive.mean() / math.log(2))


@pytest.mark.parametrize("background", [0.0, 0.3])
def test_without_order_each_action_is_foretold_by_the_weights(background: float, monkeypatch) -> None:
    likelihood = three_goals().with_background(background)
    posterior = posterior_of(None, likelihood)
    w = np.array([0.2, 0.5, 0.3]) if not background else np.array([0.15, 0.45, 0.1, 0.3])
    weights_given(monkeypatch, w)
    found = filtering(posterior, held_out(), draws=1)
    dense = same_likelihood(likelihood, held_out()).dense
    np.testing.assert_allclose(found.log_predictive, logsumexp(dense + np.log(w), axis=1), rtol=0, atol=1e-12)
    chance = np.exp(dense + np.log(w) - found.log_predictive[:, None])
    np.testing.assert_allclose(found.probability, chance[:, :3], rtol=0, atol=1e-12)


def test_draws_that_foretold_better_count_for_more_within_a_trajectory(monkeypatch) -> None:
    """Two draws: p(a_t | before) is Σ_k p_k(a_1..a_t) / Σ_k p_k(a_1..a_{t−1}), anew in each trajectory."""
    likelihood, rows = three_goals(), (np.array([0.9, 0.05, 0.05]), np.array([0.1, 0.2, 0.7]))
    posterior = posterior_of(None, likelihood)
    weights_given(monkeypatch, *rows)
    found = filtering(posterior, held_out(), draws=2)
    dense = same_likelihood(likelihood, held_out()).dense
    each = np.exp([logsumexp(dense + np.log(w), axis=1) for w in rows])
    for a, b in ((0, 4), (4, 6)):
        after = np.cumprod(each[:, a:b], axis=1)
        before = np.column_stack([[1, 1], after[:, :-1]]).sum(axis=0)
        np.testing.assert_allclose(found.log_predictive[a:b], np.log(after.sum(axis=0) / before), atol=1e-12)
        chance = np.array([np.exp(dense[a:b] + np.log(w)) for w in rows]) / each[:, a:b, None]
        share = after / after.sum(axis=0)
        np.testing.assert_allclose(found.probability[a:b], (share[..., None] * chance).sum(axis=0), atol=1e-12)


@pytest.mark.parametrize("background", [0.0, 0.3])
def test_weights_are_drawn_given_the_counts_of_the_draw(background: float, monkeypatch) -> None:
    """The shape is ηp + counts: of redraws where subgoals persist, else of observations, the background's last."""
    likelihood = three_goals().with_background(background)
    shapes: list[np.ndarray] = []
    monkeypatch.setattr(
        module, "log_weights", lambda shape, generator: shapes.append(shape) or np.log(shape / shape.sum())
    )
    for model in (None, Persistent()):
        posterior = posterior_of(model, likelihood, concentration=Gamma())
        shapes.clear()
        filtering(posterior, held_out(), draws=24)
        etas, theta = posterior.parameters["concentration"].ravel(), posterior.assignments.reshape(24, -1)
        assert not background or model is not None or (theta < 0).any()
        for row, (shape, eta) in enumerate(zip(shapes, etas, strict=True)):
            counts = shape - eta * np.exp(likelihood.log_prior)
            np.testing.assert_allclose(counts, np.round(counts), atol=1e-9)
            if model is None:
                served = np.where(theta[row] < 0, 3, theta[row])
                np.testing.assert_allclose(counts, np.bincount(served, minlength=likelihood.n_candidates), atol=1e-9)
            else:
                drawn = posterior.redraws.count[slice(*posterior.redraws.offset[row : row + 2])].sum()
                assert counts.sum() == pytest.approx(drawn)
                assert counts.sum() < posterior.n_observations


def test_a_hidden_markov_model_is_filtered_as_the_sum_over_paths(monkeypatch) -> None:
    """Rows of transitions and the law of first steps as drawn; log weights are asked for in that order."""
    posterior = posterior_of(StickyHMM())
    generator = np.random.default_rng(0)
    drawn = [generator.dirichlet(np.ones(3)) for _ in range(5)]
    weights_given(monkeypatch, *drawn)
    found = filtering(posterior, held_out(), draws=1)
    rows, first = np.array(drawn[1:4]), drawn[4]
    held = same_likelihood(posterior.likelihood, held_out())
    predictive, probability = by_paths(held.dense, [0, 4, 6], first, lambda i, h, g: rows[h, g])
    np.testing.assert_allclose(found.log_predictive, predictive, rtol=0, atol=1e-11)
    np.testing.assert_allclose(found.probability, probability, rtol=0, atol=1e-12)


@pytest.mark.parametrize("model", [None, Persistent(), Persistent(keep=0.7), StickyHMM()])
@pytest.mark.parametrize("confidence", [None, NoiseLevels((0.5, 2.0, 8.0)), OwnConfidence()])
def test_probabilities_sum_to_one_with_the_background(model, confidence) -> None:
    posterior = posterior_of(model, three_goals().with_background(0.2), confidence=confidence, concentration=Gamma())
    found = filtering(posterior, held_out())
    again = filtering(posterior, held_out(), seed=0)
    assert found.probability.shape == (6, 3)
    assert found.probability.min() >= 0
    total = found.probability.sum(axis=1)
    assert (total <= 1 + 1e-12).all()
    assert (total < 0.999).any()
    assert np.isfinite(found.log_predictive).all()
    np.testing.assert_array_equal(found.log_predictive, again.log_predictive)
    plain = posterior_of(model, confidence=confidence)
    np.testing.assert_allclose(filtering(plain, held_out()).probability.sum(axis=1), 1, atol=1e-12)


def test_the_corner_is_served_before_it_and_the_next_after_it() -> None:
    posterior = posterior_of(Persistent(), draws=40)
    found = filtering(posterior, held_out())
    assert found.probability[1].argmax() == 1
    assert found.probability[3].argmax() == 2


def test_other_demonstrations_have_the_confidence_and_background_but_no_weights() -> None:
    likelihood = three_goals().with_background(0.2).weighted(0.3).at(5.0)
    again = same_likelihood(likelihood, held_out())
    assert (again.confidence, again.background, again.weight) == (5.0, 0.2, None)
    wanted = subgoal.action_comparison(held_out(), likelihood.candidates, confidence=5.0).with_background(0.2)
    np.testing.assert_array_equal(again.dense, wanted.dense)
    own = same_likelihood(likelihood, likelihood.demonstrations)
    np.testing.assert_allclose(own.dense * 0.3, likelihood.dense, rtol=1e-12)


def test_what_cannot_be_filtered_is_refused() -> None:
    plain = quiet_sample(table(), **LENGTH)
    with pytest.raises(InputError, match="likelihood"):
        filtering(plain, held_out())
    from dataclasses import replace

    posterior = posterior_of()
    with pytest.raises(InputError, match="posterior"):
        filtering(replace(posterior, likelihood=None), held_out())
    with pytest.raises(InputError, match="draws"):
        filtering(posterior, held_out(), draws=0)
    with pytest.raises(InputError, match="dimensions"):
        filtering(posterior, Demonstrations.from_arrays(np.zeros((2, 3)), np.ones((2, 3))))
    hidden = posterior_of(StickyHMM())
    with pytest.raises(InputError, match="assignments"):
        filtering(replace(hidden, assignments=None), held_out())


def test_groups_are_refused() -> None:
    states = np.tile(np.linspace(0, 9, 10), 4)[:, None] * [[1.0, 0.0]]
    demos = Demonstrations.from_arrays(states, np.tile([[1.0, 0.1]], (40, 1)), [0, 10, 20, 30, 40])
    likelihood = subgoal.action_comparison(demos, subgoal.Candidates(GOALS))
    posterior = posterior_of(Grouped(np.array([0, 0, 1, 1])), likelihood)
    with pytest.raises(InputError, match="group"):
        filtering(posterior, held_out())


def test_the_compiled_filters_are_their_python_forms() -> None:
    generator = np.random.default_rng(0)
    relative, first = generator.gamma(1.0, size=(4, 5)), np.array([False, False, True, False])
    weights, entering = generator.dirichlet(np.ones(5), 3), generator.dirichlet(np.ones(5), 3)
    there_from, there = np.array([0, 1, 1, 3, 3]), np.array([2, 0, 4])
    keep, keep_there = np.array([0.2, 0.5, 0.9]), np.array([0.1, 0.5, 0.3])
    row_from = np.array([[0, 2, 3, 3, 5, 6], [6, 7, 8, 9, 10, 11], [11, 11, 11, 13, 13, 14]])
    column, above = generator.integers(0, 5, 14), generator.random(14)
    results = []
    for form in (lambda kernel: kernel, lambda kernel: kernel.py_func):
        out, total, mean = np.empty((2, 3, 4, 5)), np.empty((2, 3, 4)), np.zeros((4, 4))
        form(filters.filter_persistent)(
            relative, first, there_from, there, weights, keep, keep_there, entering, out[0], total[0]
        )
        form(filters.filter_transitions)(relative, first, weights, row_from, column, above, entering, out[1], total[1])
        form(filters.add_weighted)(out[0], total[0], mean)
        results.append((out, total, mean))
    for compiled, plain in zip(*results, strict=True):
        np.testing.assert_allclose(compiled, plain, rtol=1e-13)
