"""Fitted value iteration: equal to what is known exactly, and honest where nothing is proved."""

from __future__ import annotations

import array_api_strict
import numpy as np
import pytest

from subgoal.gaussian import value_iteration
from subgoal.gaussian.goal_values import Ahead, GoalValues, plan_goals, rewards
from subgoal.gaussian.smoothers import Averager, GaussianSmoother, squared_exponential
from subgoal.gaussian.value_iteration import IterationStatus, iterate_values
from subgoal.runtime.errors import BudgetError, InputError
from tests.oracles.fitted_iteration import riccati, values_of

DISCOUNT = 0.82


@pytest.fixture
def drifting(rng):
    """Support states, and where five actions lead from each: a little aside."""
    support = rng.uniform(-2, 2, (40, 2))
    steps = np.array([[0, 0], [0.4, 0], [-0.4, 0], [0, 0.4], [0, -0.4]])
    return support, Ahead(((support[:, None] + steps).reshape(-1, 2),))


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def planned(support, ahead, **kwargs) -> GoalValues:
    settings = {"smoother": GaussianSmoother(), "width": 0.7, "discount": DISCOUNT}
    return plan_goals(support, support, ahead, **(settings | kwargs))


def test_on_a_grid_of_support_states_it_is_tabular_dynamic_programming():
    side, gamma = 5, 0.9
    place = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2)
    moves = np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    after = np.clip(place[:, None] + moves, 0, side - 1)
    number = (after @ [side, 1]).ravel()
    plan = plan_goals(
        10.0 * place, 10.0 * place, Ahead((10.0 * after.reshape(-1, 2),)), smoother=GaussianSmoother(0.5, 0.0),
        width=0.5, discount=gamma, tolerance=1e-13, most_sweeps=400,
    )  # fmt: skip
    for g in range(len(place)):
        value = np.zeros(len(place))
        for _ in range(400):
            value = ((1 - gamma) * (number == g) + gamma * value[number]).reshape(len(place), -1).max(axis=1)
        np.testing.assert_allclose(plan.values[:, g], value, atol=1e-11)


def test_all_goals_at_once_are_each_goal_on_its_own(drifting):
    support, ahead = drifting
    plan = planned(support, ahead, tolerance=1e-30, most_sweeps=12)
    reward = rewards(ahead, support, 0.7)
    for g in (0, 7, 39):
        alone = values_of(support, ahead.points[0], reward[:, g], 5, DISCOUNT, 1.5, 0.1, 12)
        np.testing.assert_allclose(plan.values[:, g], alone, atol=1e-8)


def test_a_linear_quadratic_problem_has_the_values_of_riccati():
    a, b, q, r, gamma = 0.9, 0.5, 1.0, 0.3, 0.9
    p = riccati(*(np.array([[x]]) for x in (a, b, q, r)), gamma)[0, 0]
    support = np.linspace(-2, 2, 41)[:, None]
    actions = np.linspace(-3, 3, 601)
    ahead = (a * support + b * actions).reshape(-1, 1)
    inside = np.clip(ahead, -2, 2)
    weights = GaussianSmoother(1.5, 1e-9).weights(support, inside)
    reward = -(q * support**2 + r * actions**2)[:, :, None]
    found = iterate_values(
        reward, weights.reshape(41, 601, 41), discount=gamma, bounds=None, tolerance=1e-9, most_sweeps=400
    )
    middle = np.abs(support[:, 0]) <= 1
    exact = -p * support[middle, 0] ** 2
    assert found.status is IterationStatus.CONVERGED
    np.testing.assert_allclose(found.values[middle, 0], exact, rtol=1e-3, atol=1e-3 * p)


def test_values_that_grow_without_bound_are_said_to(drifting):
    support, ahead = drifting
    weights = GaussianSmoother(1.5, 1e-6).weights(support, 3 * ahead.points[0]).reshape(40, 5, 40)
    reward = np.ones((40, 5, 1))
    found = iterate_values(reward, weights, discount=0.99, bounds=None, most_sweeps=2000)
    assert found.status is IterationStatus.DIVERGED
    assert "DIVERGED" in found.status.value


def test_an_unstable_setting_within_bounds_trips_the_monitor(drifting):
    support, ahead = drifting
    plan = planned(support, Ahead((1.6 * ahead.points[0],)), smoother=GaussianSmoother(2.5, 1e-5), discount=0.98)
    weights = plan.smoother.weights(support, 1.6 * ahead.points[0])
    assert plan.gain == pytest.approx(np.abs(weights).sum(axis=1).max())
    assert plan.gain > 10
    assert plan.status is IterationStatus.LIMIT
    assert plan.residual > 1e-3
    assert plan.error_bound == np.inf


@pytest.mark.parametrize("smoother", [Averager(), GaussianSmoother(most_gain=1.0)])
def test_a_contraction_converges_and_its_bound_holds(drifting, smoother):
    support, ahead = drifting
    plan = planned(support, ahead, smoother=smoother)
    exact = planned(support, ahead, smoother=smoother, tolerance=1e-14, most_sweeps=1000)
    assert plan.status is IterationStatus.CONVERGED
    assert plan.residual <= 1e-4 < plan.residuals[-2]
    assert plan.gain <= 1 + 1e-12
    assert (plan.residuals[1:] <= DISCOUNT * plan.residuals[:-1] + 1e-15).all()
    assert np.abs(plan.values - exact.values).max() <= plan.error_bound
    assert plan.error_bound == pytest.approx(plan.residual * DISCOUNT / (1 - DISCOUNT))


def test_the_same_code_runs_on_another_array_library(drifting):
    support, ahead = drifting
    plan = planned(support, ahead)
    strict = array_api_strict.asarray
    other = plan_goals(
        strict(support), strict(support), Ahead((strict(ahead.points[0]),)), smoother=GaussianSmoother(), width=0.7,
        discount=DISCOUNT,
    )  # fmt: skip
    np.testing.assert_allclose(np.asarray(other.values), plan.values, atol=1e-12)
    q = other.action_values(Ahead((strict(ahead.points[0][:7]),)))
    np.testing.assert_allclose(np.asarray(q), plan.action_values(ahead.some(slice(0, 7))), atol=1e-12)


def test_blocks_do_not_change_the_values(drifting, monkeypatch):
    whole = planned(*drifting)
    monkeypatch.setattr(value_iteration, "BLOCK", 700)
    blocks = planned(*drifting)
    np.testing.assert_allclose(blocks.values, whole.values, atol=1e-12)
    np.testing.assert_array_equal(blocks.best, whole.best)


def test_values_are_shares_of_the_future(drifting):
    plan = planned(*drifting)
    assert ((plan.values >= 0) & (plan.values <= 1)).all()
    assert np.median(np.diag(plan.values)) > 0.8
    q = plan.action_values(drifting[1])
    assert ((q >= 0) & (q <= 1)).all()
    np.testing.assert_allclose(q.reshape(40, 5, 40).max(axis=1), plan.values, atol=2 * plan.residual)


def test_some_goals_are_those_goals(drifting):
    plan, ahead = planned(*drifting), drifting[1]
    np.testing.assert_allclose(plan.only([3, 5]).action_values(ahead), plan.action_values(ahead)[:, [3, 5]], atol=1e-12)


def test_the_best_action_is_the_one_with_the_largest_value(drifting):
    plan = planned(*drifting, tolerance=1e-12, most_sweeps=500)
    q = plan.action_values(drifting[1]).reshape(40, 5, 40)
    chosen = np.take_along_axis(q, plan.best[:, None], axis=1)[:, 0]
    np.testing.assert_allclose(chosen, q.max(axis=1), atol=1e-9)


def test_expectations_under_a_normal_law_are_those_of_quadrature(rng):
    centres, mean, variance = rng.normal(size=(6, 2)), rng.normal(size=(3, 2)), rng.uniform(0.01, 0.5, (3, 2))
    node, weight = np.polynomial.hermite_e.hermegauss(60)
    first, second = np.meshgrid(node, node, indexing="ij")
    grid = np.stack([first.ravel(), second.ravel()], -1)
    share = np.outer(weight, weight).ravel() / (2 * np.pi)
    for at, spread, found in zip(mean, variance, squared_exponential(mean, centres, 0.9, variance), strict=True):
        exact = share @ squared_exponential(at + grid * np.sqrt(spread), centres, 0.9)
        np.testing.assert_allclose(found, exact, atol=1e-10)


def test_no_variance_is_no_noise(drifting):
    support, ahead = drifting
    still = Ahead(ahead.points, np.zeros_like(ahead.points[0]))
    np.testing.assert_allclose(planned(support, still).values, planned(support, ahead).values, atol=1e-10)


def test_noise_makes_a_goal_harder_to_hold(drifting):
    support, ahead = drifting
    noisy = Ahead(ahead.points, np.full_like(ahead.points[0], 0.3))
    assert np.diag(planned(support, noisy).values).mean() < np.diag(planned(support, ahead).values).mean() - 0.1


def test_equal_support_states_need_noise(drifting):
    support, ahead = drifting
    twice = support.copy()
    twice[1] = twice[0]
    with pytest.raises(InputError, match="told apart"):
        planned(twice, ahead, smoother=GaussianSmoother(1.5, 0.0))
    assert planned(twice, ahead).status is IterationStatus.CONVERGED


@pytest.mark.parametrize("wrong", [{"discount": 1.0}, {"discount": np.nan}, {"width": 0.0}, {"tolerance": -1.0}])
def test_settings_out_of_range_are_refused(drifting, wrong):
    with pytest.raises(InputError, match=next(iter(wrong))):
        planned(*drifting, **wrong)


@pytest.mark.parametrize("make", [lambda: GaussianSmoother(length=0), lambda: GaussianSmoother(noise=-1),
                                  lambda: GaussianSmoother(most_gain=np.nan), lambda: Averager(floor=0)])  # fmt: skip
def test_smoothers_out_of_range_are_refused(make):
    with pytest.raises(InputError):
        make()


def test_shapes_that_do_not_fit_are_refused(drifting):
    support, ahead = drifting
    with pytest.raises(InputError, match="a multiple of 40"):
        planned(support, ahead.some(slice(0, 41)))
    with pytest.raises(InputError, match="as the reward"):
        iterate_values(np.zeros((3, 2, 1)), np.zeros((3, 3, 3)), discount=0.9)
    with pytest.raises(InputError, match="bounds"):
        iterate_values(np.zeros((3, 2, 1)), np.zeros((3, 2, 3)), discount=0.9, bounds=(1, 0))


def test_more_than_the_memory_is_refused_before_it_is_taken(monkeypatch, drifting):
    monkeypatch.setattr("subgoal.gaussian.goal_values.LARGEST", 1000)
    with pytest.raises(BudgetError, match="fewer support states"):
        planned(*drifting)


def test_a_limit_of_the_gain_leaves_small_rows_alone(drifting):
    support, ahead = drifting
    plain = GaussianSmoother().weights(support, ahead.points[0])
    limited = GaussianSmoother(most_gain=1.5).weights(support, ahead.points[0])
    small = np.abs(plain).sum(axis=1) <= 1.5
    assert small.any()
    assert not small.all()
    np.testing.assert_array_equal(limited[small], plain[small])
    np.testing.assert_allclose(np.abs(limited[~small]).sum(axis=1), 1.5)
    np.testing.assert_allclose(limited / np.abs(limited).sum(axis=1, keepdims=True),
                               plain / np.abs(plain).sum(axis=1, keepdims=True), atol=1e-12)  # fmt: skip


def test_an_averager_falls_to_zero_far_from_its_support(drifting):
    support, _ = drifting
    weights = Averager().weights(support, np.vstack([support[:1], [[5.0, 0.0]]]))
    assert weights[0].sum() == pytest.approx(1.0)
    assert 0 < weights[1].sum() < 0.05


@pytest.mark.parametrize("smoother", [GaussianSmoother(), GaussianSmoother(most_gain=1.0), Averager()])
@pytest.mark.parametrize("spread", [None, 0.2])
def test_what_goes_through_a_smoother_is_its_weights_times_the_values(drifting, smoother, spread):
    support, ahead = drifting
    at, values = ahead.points[0], np.random.default_rng(1).uniform(size=(40, 3))
    variance = None if spread is None else np.full_like(at, spread)
    wanted = smoother.weights(support, at, variance) @ values
    np.testing.assert_allclose(smoother.through(support, values)(at, variance), wanted, atol=1e-12)
