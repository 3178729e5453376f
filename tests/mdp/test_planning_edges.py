"""Planning at the edges: smallest worlds, extreme discounts, ties, endings, limits, bad input."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.planners.iteration import linear_program, modified_policy_iteration, policy_iteration, value_iteration
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError, PlanningError
from tests.mdp.random_worlds import ITERATIVE, PLANNERS, in_place, optimum, random_world


def test_no_bound_is_claimed_where_going_on_for_ever_is_free() -> None:
    table = np.zeros((3, 2, 3))
    table[0, 0, 0] = table[0, 1, 1] = table[1, 0, 2] = table[1, 1, 0] = 1
    reward = np.zeros((3, 2))
    reward[1, 0] = 1
    mdp = TabularMDP.from_dense(table, 1.0)
    for planner in PLANNERS:
        plan = planner(mdp, reward)
        assert plan.status is PlanStatus.SETTLED and plan.error_bound == np.inf
        np.testing.assert_allclose(plan.value, [1, 1, 0], atol=1e-12)


def test_rewards_without_end_are_refused() -> None:
    table = np.zeros((2, 2, 2))
    table[0, 0, 0] = table[0, 1, 1] = 1
    mdp = TabularMDP.from_dense(table, 1.0)
    for planner in ITERATIVE:
        with pytest.raises(PlanningError, match="NOT CONVERGED"):
            planner(mdp, [1.0, 0.0], most_sweeps=50)
    with pytest.raises(PlanningError, match="may go on for ever from state 0"):
        policy_iteration(mdp, [1.0, 0.0])
    with pytest.raises(PlanningError, match="linear program"):
        linear_program(mdp, [1.0, 0.0])


@pytest.mark.parametrize("planner", PLANNERS)
class TestEdges:
    def test_one_state(self, planner) -> None:
        plan = planner(TabularMDP.from_dense(np.ones((1, 1, 1)), 0.5), [3.0])
        assert plan.value[0] == pytest.approx(6, abs=plan.error_bound) and plan.policy[0] == 0

    def test_nothing_but_endings(self, planner) -> None:
        plan = planner(TabularMDP.from_dense(np.zeros((2, 1, 2)), 0.5), [3.0, -1.0])
        np.testing.assert_array_equal(plan.value, [3, -1])
        np.testing.assert_array_equal(plan.policy, [-1, -1])

    def test_no_discount_of_the_future_at_all(self, planner) -> None:
        world = random_world(1, discount=0.0, per_action=True)
        best = np.where(world.table.any(axis=2), world.gains, -np.inf).max(axis=1)
        np.testing.assert_array_equal(planner(world.mdp, world.reward).value, np.where(best == -np.inf, 0, best))

    def test_a_long_horizon(self, planner) -> None:
        world = random_world(3, discount=0.9999)
        plan = planner(world.mdp, world.reward)
        assert plan.status is PlanStatus.SOLVED
        assert plan.error_bound <= 1.001e-2 * abs(world.reward).max()
        assert abs(plan.value - optimum(world)).max() <= plan.error_bound

    def test_states_that_are_never_reached_have_values_all_the_same(self, planner) -> None:
        table = np.zeros((3, 1, 3))
        table[0, 0, 1] = table[1, 0, 1] = table[2, 0, 0] = 1
        plan = planner(TabularMDP.from_dense(table, 0.5), [0.0, 1.0, 8.0], tolerance=1e-9)
        np.testing.assert_allclose(plan.value, [1, 2, 8.5], atol=1e-9)

    def test_ties_go_to_the_lowest_index(self, planner) -> None:
        table = np.zeros((4, 3, 4))
        table[0, 1:] = [0, 0.5, 0.5, 0], [0, 0.25, 0.75, 0]
        table[1:3, :, 3] = 1
        plan = planner(TabularMDP.from_dense(table, 0.9), [0.1, 0.3, 0.3, 0.7])
        np.testing.assert_array_equal(plan.policy, [1, 0, 0, -1])

    def test_an_ending_is_worth_its_own_reward_once(self, planner) -> None:
        table = np.zeros((3, 2, 3))
        table[0, 0, 1] = table[0, 1, 2] = 1
        mdp = TabularMDP.from_dense(table, 0.5)
        np.testing.assert_array_equal(planner(mdp, [1.0, 4.0, 6.0]).value, [4, 4, 6])
        per_action = [[1.0, 5.0], [9.0, 9.0], [9.0, 9.0]]
        np.testing.assert_array_equal(planner(mdp, per_action).value, [5, 0, 0])

    def test_endings_do_not_grow_with_the_rest(self, planner) -> None:
        mdp = TabularMDP.from_dense([[[0.0, 1.0]], [[0.0, 0.0]]], 0.5)
        np.testing.assert_allclose(planner(mdp, [1.0, 1.0], tolerance=1e-9).value, [1.5, 1], atol=1e-9)

    def test_the_best_of_available_actions_and_no_other(self, planner) -> None:
        table = np.zeros((2, 3, 2))
        table[0, 0, 0] = table[0, 2, 1] = table[1, 1, 0] = 1
        reward = np.array([[1.0, 99.0, 2.0], [99.0, -1.0, 99.0]])
        plan = planner(TabularMDP.from_dense(table, 0.5), reward, tolerance=1e-9)
        np.testing.assert_allclose(plan.value, [2, 0], atol=1e-9)
        np.testing.assert_array_equal(plan.policy, [0, 1])

    def test_no_reward_at_all(self, planner) -> None:
        world = random_world(5)
        plan = planner(world.mdp, np.zeros(len(world.table)))
        assert plan.error_bound == 0 and not plan.value.any() and plan.status is PlanStatus.SOLVED

    def test_the_reward_of_the_world_is_the_default(self, planner) -> None:
        world = random_world(6, per_action=True)
        own = TabularMDP.from_dense(world.table, world.discount, reward=world.reward)
        np.testing.assert_array_equal(planner(own).value, planner(world.mdp, world.reward).value)
        with pytest.raises(InputError, match="reward: found None"):
            planner(world.mdp)

    @pytest.mark.parametrize(
        ("reward", "message"),
        [
            (np.zeros(3), r"reward: found shape \(3,\), wanted \(4,\) or \(4, 2\)"),
            (np.zeros((2, 4)), r"reward: found shape \(2, 4\)"),
            ([0, 0, np.nan, 0], r"reward at index \(2,\): found nan"),
            ([[0, 0], [0, np.inf], [0, 0], [0, 0]], r"reward at index \(1, 1\): found inf"),
            (1.0, "reward: found an array of shape"),
        ],
    )
    def test_bad_rewards(self, planner, reward, message: str) -> None:
        mdp = TabularMDP.from_dense(np.full((4, 2, 4), 0.25), 0.5)
        with pytest.raises(InputError, match=message):
            planner(mdp, reward)

    def test_rewards_too_large_to_add_up(self, planner) -> None:
        mdp = TabularMDP.from_dense(np.full((4, 2, 4), 0.25), 0.9)
        with pytest.raises(InputError, match=r"reward: found rewards up to 1e\+308, wanted rewards whose sum"):
            planner(mdp, np.full(4, 1e308))
        plan = planner(mdp, np.full(4, 1e306))
        assert plan.status is PlanStatus.SOLVED and abs(plan.value - 1e307).max() <= plan.error_bound

    def test_bad_tolerance(self, planner) -> None:
        mdp = TabularMDP.from_dense(np.full((4, 2, 4), 0.25), 0.5)
        for bad in (-1.0, np.nan, np.inf):
            with pytest.raises(InputError, match="tolerance"):
                planner(mdp, np.zeros(4), tolerance=bad)

    def test_a_tolerance_below_rounding_is_refused_unless_allowed(self, planner) -> None:
        world = random_world(3, discount=0.9)
        with pytest.raises(PlanningError, match=r"as exact as rounding allows.*error bound .*tolerance 0,"):
            planner(world.mdp, world.reward, tolerance=0)
        assert planner(world.mdp, world.reward, tolerance=0, allow_unconverged=True).status is PlanStatus.ROUNDING


@pytest.mark.parametrize("planner", ITERATIVE)
def test_a_limit_of_sweeps_is_kept_and_told(planner) -> None:
    world = random_world(3, discount=0.999)
    with pytest.raises(PlanningError, match="NOT CONVERGED: the limit of sweeps"):
        planner(world.mdp, world.reward, most_sweeps=7)
    plan = planner(world.mdp, world.reward, most_sweeps=7, allow_unconverged=True)
    assert plan.status is PlanStatus.LIMIT and plan.sweeps == 7
    for bad in (0, 2.5):
        with pytest.raises(InputError, match="most_sweeps"):
            planner(world.mdp, world.reward, most_sweeps=bad)


def test_policy_iteration_keeps_its_limit() -> None:
    chain = np.zeros((9, 2, 9))
    for s in range(9):
        chain[s, 0, s] = chain[s, 1, min(s + 1, 8)] = 1
    mdp, reward = TabularMDP.from_dense(chain, 0.9), np.eye(9)[8] - 0.01 * np.eye(9)[1]
    with pytest.raises(PlanningError, match="policy iteration: NOT CONVERGED"):
        policy_iteration(mdp, reward, most_sweeps=1, initial=np.zeros(9, int))
    assert policy_iteration(mdp, reward, initial=np.ones(9, int)).sweeps == 2


@pytest.mark.parametrize("planner", ITERATIVE)
def test_a_warm_start_at_the_answer_takes_one_sweep(planner) -> None:
    world = random_world(3, discount=0.99)
    exact = optimum(world)
    assert planner(world.mdp, world.reward, initial=exact).sweeps == 1
    with pytest.raises(InputError, match="initial: found 2 values"):
        planner(world.mdp, world.reward, initial=[0.0, 1.0])


def test_work_is_counted_in_rows() -> None:
    world = random_world(3, discount=0.99)
    rows = int(world.table.any(axis=2).sum())
    plan = value_iteration(world.mdp, world.reward)
    assert plan.backups == plan.sweeps * rows
    fewer = modified_policy_iteration(world.mdp, world.reward, tolerance=1e-7, evaluation_sweeps=9)
    assert fewer.sweeps % 10 == 1
    alive = int((~world.mdp.terminal).sum())
    assert fewer.backups == (fewer.sweeps // 10 + 1) * rows + fewer.sweeps // 10 * 9 * alive


def test_in_place_sweeps_are_fewer() -> None:
    world = random_world(3, discount=0.99)
    assert in_place(world.mdp, world.reward).sweeps < value_iteration(world.mdp, world.reward).sweeps


def test_nothing_given_is_changed() -> None:
    world = random_world(3, discount=0.9)
    mdp, reward, start = world.mdp, world.reward.copy(), np.ones(len(world.table))
    kept = mdp.probability.copy()
    for planner in ITERATIVE:
        plan = planner(mdp, reward, initial=start)
        with pytest.raises(ValueError, match="read-only"):
            plan.value[0] = 1
    assert (reward == world.reward).all() and (start == 1).all() and (mdp.probability == kept).all()
