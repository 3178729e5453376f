"""Values of policies and of actions, rewards on arrival, ties, and what errors do to log likelihoods."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.mdp.planners.iteration import action_values, arrival_reward, policy_evaluation, policy_iteration
from subgoal.mdp.planners.policy import greedy_actions, imperfect, uniform_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError
from tests.mdp.random_worlds import random_world
from tests.oracles import exact_planning as oracle

seeds = st.integers(0, 10_000)


@pytest.mark.parametrize("seed", range(20))
def test_rewards_on_arrival_are_the_same_problem(seed: int) -> None:
    """W of E[R(s') + γ W(s')] and V of R(s) + γ E V: V = R + γ W, and W ends in nothing."""
    world = random_world(seed, discount=0.9, per_action=False)
    now = policy_iteration(world.mdp, world.reward)
    later = policy_iteration(world.mdp, arrival_reward(world.mdp, world.reward))
    size = abs(world.reward).max()
    np.testing.assert_allclose(now.value, world.reward + 0.9 * later.value, atol=1e-11 * size)
    assert not later.value[world.mdp.terminal].any()


def test_rewards_of_transitions() -> None:
    world = random_world(4)
    paid = np.random.default_rng(0).normal(size=world.table.shape)
    told = arrival_reward(world.mdp, paid)
    np.testing.assert_allclose(told, (world.table * paid).sum(axis=2), atol=1e-14)
    states = np.arange(len(world.table)) * 1.0
    np.testing.assert_allclose(arrival_reward(world.mdp, states), world.table @ states, atol=1e-14)
    with pytest.raises(InputError, match=r"reward: found shape \(2,\)"):
        arrival_reward(world.mdp, [1.0, 2.0])


@pytest.mark.parametrize("seed", range(20))
def test_action_values(seed: int) -> None:
    world = random_world(seed)
    value = np.random.default_rng(seed).normal(size=len(world.table))
    told = action_values(world.mdp, value, world.reward)
    legal = world.table.any(axis=2)
    np.testing.assert_allclose(told[legal], (world.gains + world.discount * world.table @ value)[legal], rtol=1e-12)
    assert (told[~legal] == -np.inf).all()
    with pytest.raises(InputError, match="value: found"):
        action_values(world.mdp, np.zeros(99), world.reward)


@pytest.mark.parametrize("seed", range(20))
def test_the_value_of_a_policy(seed: int) -> None:
    world = random_world(seed)
    generator = np.random.default_rng(seed)
    legal = world.table.any(axis=2)
    fixed = np.where(legal.any(axis=1), (legal * generator.random(legal.shape)).argmax(axis=1), -1)
    wanted = oracle.evaluate(world.table, world.gains, world.ending, fixed, world.discount)
    size = abs(world.reward).max() / (1 - world.discount)
    np.testing.assert_allclose(policy_evaluation(world.mdp, fixed, world.reward), wanted, atol=1e-12 * size)
    chances = legal * generator.random(legal.shape)
    chances /= np.maximum(chances.sum(axis=1, keepdims=True), 1e-300)
    mixed = np.einsum("sa,sat->st", chances, world.table)
    wanted = np.linalg.solve(
        np.eye(len(mixed)) - world.discount * mixed, (chances * world.gains).sum(axis=1) + world.ending
    )
    np.testing.assert_allclose(policy_evaluation(world.mdp, chances, world.reward), wanted, atol=1e-12 * size)


def test_a_policy_that_never_ends_has_no_value_at_discount_one() -> None:
    table = np.zeros((4, 2, 4))
    table[0, 0, 1] = table[1, 0, 0] = table[0, 1, 3] = table[1, 1, 3] = table[2, :, 3] = 1
    mdp = TabularMDP.from_dense(table, 1.0)
    with pytest.raises(InputError, match="policy: found a policy that may go on for ever from state 0"):
        policy_evaluation(mdp, [0, 0, 0, -1], np.ones(4))
    np.testing.assert_allclose(policy_evaluation(mdp, [0, 1, 0, -1], np.ones(4)), [3, 2, 2, 1], atol=1e-14)
    with pytest.raises(InputError, match="policy at state 0: found action 2"):
        policy_evaluation(mdp, [2, 1, 0, -1], np.ones(4))
    with pytest.raises(InputError, match="initial: found shape"):
        policy_iteration(mdp, np.ones(4), initial=[[0.5, 0.5]] * 4)


def test_greedy_actions_and_even_policies() -> None:
    table = np.array([[1.0, 1.0 - 1e-9, -np.inf], [-np.inf, -5.0, -4.0], [-np.inf, -np.inf, -np.inf]])
    np.testing.assert_array_equal(greedy_actions(table), [[1, 0, 0], [0, 0, 1], [0, 0, 0]])
    mask = greedy_actions(table, 1e-8)
    np.testing.assert_array_equal(mask, [[1, 1, 0], [0, 0, 1], [0, 0, 0]])
    np.testing.assert_array_equal(uniform_policy(mask), [[0.5, 0.5, 0], [0, 0, 1], [0, 0, 0]])
    assert not greedy_actions(np.array([[1.0, 0.875]]), 0.0625)[0, 1]
    assert greedy_actions(np.array([[1.0, 0.875]]), 0.125)[0, 1]
    with pytest.raises(InputError, match=r"action_values at index \(0, 1\): found nan"):
        greedy_actions([[1.0, np.nan]])
    with pytest.raises(InputError, match="tolerance"):
        greedy_actions(table, -1.0)
    with pytest.raises(InputError, match="mask: found int64"):
        uniform_policy([[1, 0]])


@settings(max_examples=60, deadline=None)
@given(seeds, st.floats(0.1, 50), st.floats(1e-9, 1.0))
def test_an_error_in_action_values_is_at_most_twice_as_large_in_log_likelihood(
    seed: int, confidence: float, error: float
) -> None:
    """|log π~ − log π| ≤ 2 α e; it is nearly attained where one action gains e and all others lose it."""
    generator = np.random.default_rng(seed)
    exact = generator.normal(size=(5, 8))
    wrong = exact + generator.uniform(-error, error, exact.shape)
    gap = abs(log_softmax(confidence * wrong) - log_softmax(confidence * exact))
    assert gap.max() <= 2 * confidence * error * (1 + 1e-9) + 1e-12
    worst = np.zeros((1, 5000))
    moved = np.where(np.arange(5000) == 0, error, -error)[None]
    gap = log_softmax(confidence * moved)[0, 0] - log_softmax(confidence * worst)[0, 0]
    reach = 2 * confidence * error - np.log1p(np.expm1(2 * confidence * error) / 5000)
    assert gap == pytest.approx(reach, rel=1e-6, abs=1e-9)


def log_softmax(values: np.ndarray) -> np.ndarray:
    return values - np.logaddexp.reduce(values, axis=1, keepdims=True)


def forked_world() -> TabularMDP:
    """State 0 has four actions, 1 the first two, 2 one, 3 none; all stay."""
    table = np.zeros((4, 4, 4))
    for state, actions in enumerate(([0, 1, 2, 3], [0, 1], [2])):
        table[state, actions, state] = 1
    return TabularMDP.from_dense(table, 0.9)


def test_random_actions_may_be_the_right_one() -> None:
    told = imperfect(forked_world(), [1, 0, 2, -1], error=0.2)
    np.testing.assert_allclose(told, [[0.05, 0.85, 0.05, 0.05], [0.9, 0.1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])
    assert not told.flags.writeable


def test_random_actions_may_have_to_be_wrong() -> None:
    told = imperfect(forked_world(), [1, 0, 2, -1], error=0.3, may_be_optimal=False)
    np.testing.assert_allclose(told, [[0.1, 0.7, 0.1, 0.1], [0.7, 0.3, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])


def test_who_breaks_ties_at_random_errs_outside_the_tie() -> None:
    policy = np.array([[0.5, 0.5, 0, 0], [0.5, 0.5, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])
    told = imperfect(forked_world(), policy, error=0.2, may_be_optimal=False)
    np.testing.assert_allclose(told, [[0.4, 0.4, 0.1, 0.1], [0.5, 0.5, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])
    told = imperfect(forked_world(), policy, error=0.2)
    np.testing.assert_allclose(told, [[0.45, 0.45, 0.05, 0.05], [0.5, 0.5, 0, 0], [0, 0, 1, 0], [0, 0, 0, 0]])


def test_the_error_is_that_of_the_thesis_unless_said_otherwise() -> None:
    assert imperfect(forked_world(), [1, 0, 2, -1])[0, 1] == pytest.approx(0.9625)
    np.testing.assert_array_equal(imperfect(forked_world(), [1, 0, 2, -1], error=0)[0], [0, 1, 0, 0])


@pytest.mark.parametrize(
    ("policy", "error", "match"),
    [
        ([1, 2, 2, -1], 0.05, "policy at state 1: found action 2"),
        ([1, 0, 2, -1], float("nan"), "error"),
        ([1, 0, 2, -1], -0.1, "error"),
        ([1, 0, 2, -1], 1.1, "error: found 1.1, wanted a probability"),
    ],
)
def test_demonstrators_that_cannot_be(policy, error: float, match: str) -> None:
    with pytest.raises(InputError, match=match):
        imperfect(forked_world(), policy, error=error)
