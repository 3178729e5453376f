"""Soft values and policies, their error bounds, their limits, and what flows under a policy."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.planners.flow import Flow, expected_visits
from subgoal.mdp.planners.iteration import policy_iteration
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.soft import soft_value_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError, PlanningError
from tests.mdp.random_worlds import random_world
from tests.mdp.small_worlds import corridor
from tests.oracles import entropy as oracle

DISCOUNTS = (0.0, 0.5, 0.9, 0.99, 0.999)


@pytest.mark.parametrize("seed", range(40))
def test_values_and_policies_are_those_of_plain_recursion(seed: int) -> None:
    world = random_world(seed, discount=(0.0, 0.5, 0.9)[seed % 3])
    size = abs(world.reward).max()
    for share in (0.1, 10.0):
        plan = soft_value_iteration(world.mdp, world.reward, temperature=share * size)
        slow = oracle.soft_values(world.table, (world.gains, world.ending), world.discount, share * size, 400)
        assert abs(plan.value - slow[0]).max() <= plan.error_bound + 1e-12 * abs(slow[0]).max()
        np.testing.assert_allclose(plan.policy, slow[1], rtol=0, atol=1e-8)


@pytest.mark.parametrize("seed", range(60))
def test_no_value_is_further_from_the_truth_than_the_bound(seed: int) -> None:
    world = random_world(seed)
    temperature = 10.0 ** (seed % 5 - 2) * abs(world.reward).max()
    exact = soft_value_iteration(
        world.mdp, world.reward, temperature=temperature, tolerance=0, allow_unconverged=True
    )  # fmt: skip
    assert exact.status is PlanStatus.ROUNDING
    for sweeps in (1, 2, 3):
        plan = soft_value_iteration(
            world.mdp, world.reward, temperature=temperature, tolerance=0, most_sweeps=sweeps, allow_unconverged=True
        )  # fmt: skip
        assert abs(plan.value - exact.value).max() <= plan.error_bound + exact.error_bound
        legal = world.mdp.available
        apart = abs(plan.action_values[legal] - exact.action_values[legal])
        assert apart.max(initial=0.0) <= plan.error_bound + exact.error_bound


def test_the_bound_is_attained_with_one_state() -> None:
    """From 0, one backup gives 1 of the 10 that there are at γ = 0.9: γ·1/(1 − γ) = 9 are missing."""
    plan = soft_value_iteration(
        TabularMDP.from_dense(np.ones((1, 1, 1)), 0.9), [1.0], most_sweeps=1, allow_unconverged=True
    )  # fmt: skip
    assert (plan.status, plan.sweeps) == (PlanStatus.LIMIT, 1)
    assert plan.error_bound == pytest.approx(9.0, rel=1e-12)


@pytest.mark.parametrize("discount", DISCOUNTS)
def test_newtons_method_takes_few_sweeps_at_any_discount(discount: float) -> None:
    for seed in range(20):
        world = random_world(seed, discount=discount)
        plan = soft_value_iteration(world.mdp, world.reward, temperature=abs(world.reward).max())
        assert plan.status is PlanStatus.SOLVED
        assert plan.sweeps <= 12


@pytest.mark.parametrize("seed", range(30))
def test_policies_are_softmaxes_of_the_action_values_over_what_is_available(seed: int) -> None:
    world = random_world(seed)
    size = abs(world.reward).max()
    plan = soft_value_iteration(world.mdp, world.reward, temperature=size)
    inner = ~world.mdp.terminal
    np.testing.assert_allclose(plan.policy.sum(axis=1), inner, atol=1e-12)
    assert (plan.policy[~world.mdp.available] == 0).all()
    assert (plan.action_values[~world.mdp.available] == -np.inf).all()
    np.testing.assert_allclose(plan.policy[inner], np.exp((plan.action_values - plan.value[:, None]) / size)[inner],
                               rtol=1e-10)  # fmt: skip


@pytest.mark.parametrize("seed", range(30))
def test_towards_temperature_0_the_plan_is_the_optimal_one(seed: int) -> None:
    """Between V* and V* + T log A/(1 − γ)."""
    world = random_world(seed)
    best, size = policy_iteration(world.mdp, world.reward), abs(world.reward).max()
    for share in (1e-2, 1e-5, 1e-8):
        soft = soft_value_iteration(world.mdp, world.reward, temperature=share * size)
        most = share * size * np.log(world.mdp.n_actions) / (1 - world.discount)
        slack = 1e-8 * size / (1 - world.discount)
        assert (soft.value >= best.value - slack).all()
        assert (soft.value <= best.value + most + slack).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_soft_value_is_the_reward_and_the_entropy_of_its_policy(seed: int) -> None:
    world = random_world(seed, discount=0.9)
    size = abs(world.reward).max()
    plan = soft_value_iteration(world.mdp, world.reward, temperature=size)
    with np.errstate(divide="ignore", invalid="ignore"):
        entropy = -np.nansum(plan.policy * np.log(plan.policy), axis=1)
    gain = np.where(world.mdp.terminal, world.ending, (plan.policy * world.gains).sum(axis=1) + size * entropy)
    np.testing.assert_allclose(Flow(world.mdp, plan.policy).backwards(gain), plan.value, atol=1e-8 * size)


def ending_walk(cost: float, slip: float = 0.1) -> tuple[TabularMDP, np.ndarray]:
    """0 to 4 in a row, left or right with slip, over at 4; every step costs."""
    table = np.zeros((5, 2, 5))
    for s in range(4):
        table[s, 0, max(s - 1, 0)], table[s, 0, s + 1] = 1 - slip, slip
        table[s, 1, s + 1], table[s, 1, max(s - 1, 0)] = 1 - slip, slip
    return TabularMDP.from_dense(table, 1.0), np.array([-cost] * 4 + [3.0])


@pytest.mark.parametrize("cost", [0.6, 1.0])
def test_at_discount_1_values_come_with_a_bound_where_episodes_end(cost: float) -> None:
    mdp, reward = ending_walk(cost)
    plan = soft_value_iteration(mdp, reward)
    table = mdp.matrix.toarray().reshape(5, 2, 5)
    slow, _ = oracle.soft_values(table, (np.repeat(reward[:, None], 2, axis=1), reward), 1.0, 1.0, 3000)
    assert plan.status is PlanStatus.SOLVED
    assert abs(plan.value - slow).max() <= plan.error_bound + 1e-12
    early = soft_value_iteration(mdp, reward, tolerance=1e-1)
    assert abs(early.value - slow).max() <= early.error_bound <= 0.1


def test_at_discount_1_no_bound_is_claimed_that_does_not_hold() -> None:
    for cost in (0.3, 0.6, 1.0, 3.0):
        mdp, reward = ending_walk(cost)
        exact = soft_value_iteration(mdp, reward)
        for sweeps in range(1, 6):
            plan = soft_value_iteration(mdp, reward, most_sweeps=sweeps, allow_unconverged=True)
            assert abs(plan.value - exact.value).max() <= plan.error_bound + exact.error_bound


def test_at_discount_1_entropy_without_end_is_an_error() -> None:
    """Two ways at every step, for ever: the sum over all ways to the end is infinite below a cost of log 2."""
    mdp, reward = ending_walk(0.5, slip=0.0)
    with pytest.raises(PlanningError, match="without end"):
        soft_value_iteration(mdp, reward)
    with pytest.raises(PlanningError, match="without end"):
        soft_value_iteration(mdp, reward, allow_unconverged=True)


@pytest.mark.parametrize("temperature", [0, -1, np.nan, np.inf, "warm"])
def test_temperatures_must_be_above_0(temperature) -> None:
    with pytest.raises(InputError, match="temperature"):
        soft_value_iteration(corridor(3, 0.9), np.zeros(3), temperature=temperature)


def test_temperatures_too_high_for_finite_values_are_refused() -> None:
    with pytest.raises(InputError, match="temperature"):
        soft_value_iteration(corridor(3, 0.999), np.zeros(3), temperature=1e308)


@pytest.mark.parametrize("reward", [[1, np.nan, 0], [1, 2], None])
def test_rewards_are_checked(reward) -> None:
    with pytest.raises(InputError, match="reward"):
        soft_value_iteration(corridor(3, 0.9), reward)


def test_what_was_not_reached_raises_unless_asked_otherwise() -> None:
    with pytest.raises(PlanningError, match="2 sweeps"):
        soft_value_iteration(corridor(30, 0.99), np.eye(30)[0], most_sweeps=2)


def test_starting_from_the_solution_takes_one_sweep() -> None:
    first = soft_value_iteration(corridor(30, 0.99), np.eye(30)[0], tolerance=1e-6)
    assert soft_value_iteration(corridor(30, 0.99), np.eye(30)[0], initial=first.value, tolerance=1e-6).sweeps == 1


def test_plans_say_what_they_are() -> None:
    assert "SoftPlan(3 states, temperature 2, SOLVED" in repr(
        soft_value_iteration(corridor(3, 0.9), np.zeros(3), temperature=2)
    )


@pytest.mark.parametrize("discount", DISCOUNTS)
@pytest.mark.parametrize("seed", range(5))
def test_visits_sum_to_the_horizon_and_flow(seed: int, discount: float) -> None:
    """Σ ρ = 1/(1 − γ) with terminal states counted for ever; ρ = b + γ P_πᵀ ρ; γ is never given but in the world."""
    world = random_world(seed, discount=discount)
    start = np.random.default_rng(seed).dirichlet(np.ones(world.mdp.n_states))
    mdp = TabularMDP.from_dense(world.table, discount, start=start)
    policy = soft_value_iteration(mdp, world.reward, temperature=abs(world.reward).max()).policy
    rho = expected_visits(mdp, policy)
    for_ever = rho / np.where(mdp.terminal, 1 - discount, 1.0)
    assert for_ever.sum() == pytest.approx(1 / (1 - discount), rel=1e-9)
    flow = np.einsum("s,sa,sat->t", rho, policy, world.table)
    np.testing.assert_allclose(rho, start + discount * flow, rtol=1e-10, atol=1e-12)
    if discount <= 0.9:
        np.testing.assert_allclose(rho, oracle.visits(world.table, policy, start, discount, 400), rtol=1e-10)


def test_visits_of_actions_are_those_of_their_probabilities() -> None:
    mdp, start = corridor(4, 0.9), np.full(4, 0.25)
    actions = np.array([1, 1, 0, 2])
    np.testing.assert_array_equal(expected_visits(mdp, actions, start), expected_visits(mdp, np.eye(3)[actions], start))


def test_visits_at_discount_1_need_a_policy_that_ends() -> None:
    mdp, _ = ending_walk(1.0)
    assert expected_visits(mdp, np.ones(5, int), np.eye(5)[3])[4] == pytest.approx(1)
    stuck = TabularMDP.from_dense(np.array([[[1.0, 0], [0, 1]], [[0, 0], [0, 0]]]), 1.0)
    with pytest.raises(InputError, match="for ever from state 0"):
        expected_visits(stuck, np.array([0, 0]), np.array([1.0, 0]))


@pytest.mark.parametrize("start", [None, [0.5, 0.5], [0.5, 0.4, 0.0], [np.nan, 0, 1], [2, -1, 0]])
def test_starts_of_visits_are_checked(start) -> None:
    with pytest.raises(InputError, match="start"):
        expected_visits(corridor(3, 0.9), np.zeros(3, int), start)
