"""Planning with actions that are refined between the test actions."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from subgoal.candidates import epsilon_net
from subgoal.continuous import Averager, ContinuousWorld, GaussianSmoother, action_grid
from subgoal.demonstrations import Metric
from subgoal.dynamics.planning import plan_world
from subgoal.dynamics.refinement import climb, pattern
from subgoal.gaussian.value_iteration import Further, iterate_values
from subgoal.runtime.errors import InputError
from tests.likelihood.point_mass import HIGH, LOW, STEP, plane, push, there_and_back

BASE = epsilon_net(there_and_back()[0], 0.4).points
PLAN = partial(
    plan_world, metric=Metric.euclidean(2), support=BASE, goals=BASE, smoother=GaussianSmoother(), width=0.7,
    tolerance=1e-9, most_sweeps=1000,
)  # fmt: skip


def world(per_axis: int) -> ContinuousWorld:
    return plane(test_actions=action_grid(LOW, HIGH, per_axis))


def test_refinement_never_lowers_a_value():
    """With weights of at least zero, as an averager's are; those of a Gaussian process may be below."""
    plain, refined = (PLAN(world(3), refinements=k, smoother=Averager()) for k in (0, 3))
    assert (refined.values >= plain.values - 1e-7).all()
    assert (refined.values > plain.values + 0.01).any()


def test_a_coarse_grid_refined_is_worth_what_a_fine_one_is():
    """Three actions along each axis, refined three times, against thirty-three."""
    fine, coarse, refined = PLAN(world(33)), PLAN(world(3)), PLAN(world(3), refinements=3)
    lost = np.abs(fine.values - coarse.values).mean()
    assert np.abs(fine.values - refined.values).mean() < 0.2 * lost
    assert np.diag(refined.values).mean() > np.diag(coarse.values).mean()


def test_further_actions_are_taken_where_they_are_better():
    """Two states: staying pays nothing; the further action of state 0 leads to state 1, which pays its goal."""
    reward, weights = np.zeros((2, 1, 1)), np.eye(2)[:, None]
    reward[1] = 0.1
    further = Further(np.array([[0.0], [0.0]]), np.array([[[0.0, 1.0]], [[1.0, 0.0]]]))
    alone = iterate_values(reward, weights, discount=0.9, tolerance=1e-12, most_sweeps=1000)
    both = iterate_values(reward, weights, discount=0.9, tolerance=1e-12, most_sweeps=1000, further=further)
    np.testing.assert_allclose(alone.values[:, 0], [0, 1], atol=1e-9)
    np.testing.assert_allclose(both.values[:, 0], [0.9, 1], atol=1e-9)


def test_each_goal_has_its_own_further_action():
    """Two goals and two states: what one goal is offered in a state the other is not."""
    reward, weights = np.zeros((2, 1, 2)), np.eye(2)[:, None]
    reward[1] = 0.1
    offered = np.zeros((2, 2, 2))
    offered[0, 1] = [0.0, 1.0]
    found = iterate_values(
        reward, weights, discount=0.9, tolerance=1e-12, most_sweeps=1000, further=Further(np.zeros((2, 2)), offered)
    )
    np.testing.assert_allclose(found.values, [[0.0, 0.9], [1.0, 1.0]], atol=1e-9)


def test_climbing_finds_the_top_of_a_hill_between_test_actions():
    """Within the last spacing, a quarter halved six times; the nearer of two beginnings leads there."""
    top = np.array([[0.11, -0.2], [0.85, 0.9]])

    def worth_of(tried):
        return -((tried - top[:, None]) ** 2).sum(axis=2)

    flat = world(9)
    begin = np.stack([flat.test_actions[[40, 0]], flat.test_actions[[40, 80]]])
    found, worth = climb(flat, begin, worth_of, 6)
    np.testing.assert_allclose(found, top, atol=0.25 / 2**6)
    np.testing.assert_allclose(worth, worth_of(found[:, None])[:, 0])


def test_climbing_stays_within_the_bounds():
    edge = world(3)
    found, _ = climb(edge, edge.test_actions[None, -1:], lambda tried: tried.sum(axis=2), 3)
    np.testing.assert_array_equal(found, [HIGH])


@pytest.mark.parametrize(("k", "count"), [(1, 3), (2, 9), (3, 27), (4, 9)])
def test_neighbours_begin_with_staying(k, count):
    steps = pattern(k)
    assert steps.shape == (count, k)
    assert not steps[0].any()
    assert len(np.unique(steps, axis=0)) == count


def test_refinements_are_whole_numbers():
    with pytest.raises(InputError, match="refinements"):
        PLAN(world(3), refinements=-1)


def test_a_gaussian_world_plans_with_its_variances():
    class Windy:
        def __call__(self, states, actions, duration):
            return push(states, actions, duration)

        def variance(self, states, actions, duration):
            return np.full_like(states, 0.1 * duration)

    still = ContinuousWorld(Windy(), LOW, HIGH, step=STEP, horizon=3.0)
    windy = ContinuousWorld(Windy(), LOW, HIGH, step=STEP, horizon=3.0, gaussian=True)
    held = [np.diag(PLAN(each, refinements=1).values).mean() for each in (still, windy)]
    assert held[1] < held[0] - 0.02


@pytest.mark.parametrize("wrong", [np.nan, -1.0])
def test_variances_that_are_none_are_refused(wrong):
    class Broken:
        def __call__(self, states, actions, duration):
            return states

        def variance(self, states, actions, duration):
            return np.full_like(states, wrong)

    with pytest.raises(InputError, match="variance"):
        PLAN(ContinuousWorld(Broken(), LOW, HIGH, step=STEP, gaussian=True))


def test_variances_of_angles_are_refused():
    class Turning:
        def __call__(self, states, actions, duration):
            return states

        def variance(self, states, actions, duration):
            return np.ones_like(states)

    with pytest.raises(InputError, match="angles"):
        PLAN(ContinuousWorld(Turning(), LOW, HIGH, step=STEP, gaussian=True),
             metric=Metric.of(2, None, (np.inf, 2 * np.pi)))  # fmt: skip
