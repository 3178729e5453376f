"""Worlds whose values are printed in textbooks, and FrozenLake at several discounts."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.planners.iteration import (
    action_values,
    arrival_reward,
    linear_program,
    modified_policy_iteration,
    policy_evaluation,
    policy_iteration,
    value_iteration,
)
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.tabular import TabularMDP

PLANNERS = [value_iteration, modified_policy_iteration, policy_iteration, linear_program]
NORTH, SOUTH, EAST, WEST = WAYS = [(-1, 0), (1, 0), (0, 1), (0, -1)]


def moved(row: int, column: int, way: tuple[int, int], shape: tuple[int, int], wall=()) -> int:
    """Number of the cell that a move leads to; the border and walls hold."""
    new = (row + way[0], column + way[1])
    inside = 0 <= new[0] < shape[0] and 0 <= new[1] < shape[1] and new not in wall
    return new[0] * shape[1] + new[1] if inside else row * shape[1] + column


def test_the_four_by_four_gridworld() -> None:
    """Sutton and Barto (2018), example 4.1: −1 a step, two corners end; values of a random walk."""
    table = np.zeros((16, 4, 16))
    for state in range(1, 15):
        for action, way in enumerate(WAYS):
            table[state, action, moved(*divmod(state, 4), way, (4, 4))] = 1
    mdp, reward = TabularMDP.from_dense(table, 1.0), np.where(table.any(axis=2), -1.0, 0.0)
    walk = policy_evaluation(mdp, uniform_policy(mdp.available), reward)
    printed = [[0, -14, -20, -22], [-14, -18, -20, -20], [-20, -20, -18, -14], [-22, -20, -14, 0]]
    np.testing.assert_allclose(walk.reshape(4, 4), printed, atol=1e-10)
    near = [[0, -1, -2, -3], [-1, -2, -3, -2], [-2, -3, -2, -1], [-3, -2, -1, 0]]
    for planner in PLANNERS:
        plan = planner(mdp, reward)
        np.testing.assert_allclose(plan.value.reshape(4, 4), near, atol=1e-10)
        assert plan.error_bound <= 1e-6


def five_by_five() -> tuple[TabularMDP, np.ndarray]:
    """Sutton and Barto (2018), example 3.5: +10 and a jump from A, +5 and one from B, −1 for the border."""
    table, reward = np.zeros((25, 4, 25)), np.zeros((25, 4))
    for state in range(25):
        for action, way in enumerate(WAYS):
            after = moved(*divmod(state, 5), way, (5, 5))
            reward[state, action] = -1.0 * (after == state)
            table[state, action, after] = 1
    for state, after, pay in ((1, 21, 10.0), (3, 13, 5.0)):
        table[state], reward[state] = np.eye(25)[after], pay
    return TabularMDP.from_dense(table, 0.9), reward


def test_the_five_by_five_gridworld() -> None:
    """Values of a random walk (figure 3.2), optimal values and actions (example 3.8, figure 3.5), printed to 0.1."""
    mdp, reward = five_by_five()
    walk = policy_evaluation(mdp, np.full((25, 4), 0.25), reward)
    printed = [
        [3.3, 8.8, 4.4, 5.3, 1.5],
        [1.5, 3.0, 2.3, 1.9, 0.5],
        [0.1, 0.7, 0.7, 0.4, -0.4],
        [-1.0, -0.4, -0.4, -0.6, -1.2],
        [-1.9, -1.3, -1.2, -1.4, -2.0],
    ]
    np.testing.assert_allclose(walk.reshape(5, 5), printed, atol=0.05)
    best = [
        [22.0, 24.4, 22.0, 19.4, 17.5],
        [19.8, 22.0, 19.8, 17.8, 16.0],
        [17.8, 19.8, 17.8, 16.0, 14.4],
        [16.0, 17.8, 16.0, 14.4, 13.0],
        [14.4, 16.0, 14.4, 13.0, 11.7],
    ]
    for planner in PLANNERS:
        plan = planner(mdp, reward)
        np.testing.assert_allclose(plan.value.reshape(5, 5), best, atol=0.05)
    ties = greedy_actions(action_values(mdp, plan.value, reward), 1e-6)
    named = ["".join("NSEW"[a] for a in np.flatnonzero(row)) for row in ties]
    assert named[:5] == ["E", "NSEW", "W", "NSEW", "W"]
    assert named[5:10] == ["NE", "N", "NW", "W", "W"]
    assert named[10:] == ["NE", "N", "NW", "NW", "NW"] * 3


def four_by_three(living: float) -> tuple[np.ndarray, np.ndarray]:
    """Russell and Norvig (2010), figure 17.1: 0.8 as meant, 0.1 to each side; R(s) now, +1 and −1 end it."""
    table = np.zeros((12, 4, 12))
    sides = {NORTH: (EAST, WEST), SOUTH: (EAST, WEST), EAST: (NORTH, SOUTH), WEST: (NORTH, SOUTH)}
    for state in range(12):
        if state in (3, 7):
            continue
        for action, way in enumerate(WAYS):
            for chance, each in zip((0.8, 0.1, 0.1), (way, *sides[way]), strict=True):
                table[state, action, moved(*divmod(state, 4), each, (3, 4), wall=[(1, 1)])] += chance
    reward = np.full(12, living)
    reward[[3, 7]] = 1, -1
    table[5] = np.eye(12)[0]  # The wall is no cell; a way out of it keeps the world whole.
    return table, reward


def test_the_four_by_three_world() -> None:
    """Utilities of figure 17.3 for R(s) = −0.04 and discount 1, printed to 0.001, and the policy of figure 17.2."""
    table, reward = four_by_three(-0.04)
    mdp = TabularMDP.from_dense(table, 1.0)
    printed = [0.812, 0.868, 0.918, 1, 0.762, np.nan, 0.660, -1, 0.705, 0.655, 0.611, 0.388]
    for planner in PLANNERS:
        plan = planner(mdp, reward)
        open_cells = np.arange(12) != 5
        np.testing.assert_allclose(plan.value[open_cells], np.array(printed)[open_cells], atol=5e-4)
        assert plan.error_bound <= 1e-6
        policy = "".join("NSEW."[a] for a in plan.policy[open_cells])
        assert policy == "EEE." + "NN." + "NWWW"


def test_the_four_by_three_world_with_rewards_on_arrival() -> None:
    """The same utilities: V = R + γ W."""
    table, reward = four_by_three(-0.04)
    mdp = TabularMDP.from_dense(table, 1.0)
    later = policy_iteration(mdp, arrival_reward(mdp, reward))
    np.testing.assert_allclose(policy_iteration(mdp, reward).value, reward + later.value, atol=1e-12)


@pytest.mark.parametrize("living", [-2.0, -0.2, -0.01])
def test_how_dear_life_is_changes_the_policy(living: float) -> None:
    """Figure 17.2 (b): below −1.6284 straight to the nearest ending; from −0.4278 to −0.0850 the risky short way;
    above −0.0221 no risk at all."""
    table, reward = four_by_three(living)
    policy = policy_iteration(TabularMDP.from_dense(table, 1.0), reward).policy
    named = {state: "NSEW."[policy[state]] for state in (2, 6, 9, 10, 11)}
    if living == -2.0:
        assert named == {2: "E", 6: "E", 9: "E", 10: "E", 11: "N"}
    elif living == -0.2:
        assert named == {2: "E", 6: "N", 9: "E", 10: "N", 11: "W"}
    else:
        assert named[6] == "W" and named[11] == "S" and named[10] == "W"


FROZEN = {0.9: 0.06889, 0.95: 0.18047, 0.99: 0.54203, 1.0: 14 / 17}
"""Value of the first state of the slippery 4x4 lake; at discount 1 the chance of ever reaching the goal."""


@pytest.mark.parametrize("discount", FROZEN)
def test_frozen_lake(discount: float) -> None:
    gymnasium = pytest.importorskip("gymnasium")
    mdp = TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"), discount=discount)
    plans = [planner(mdp, tolerance=1e-9) for planner in PLANNERS]
    for plan in plans:
        assert plan.value[0] == pytest.approx(FROZEN[discount], abs=6e-6)
        np.testing.assert_allclose(plan.value, plans[0].value, atol=2e-9)
    own = policy_evaluation(mdp, plans[2].policy)
    np.testing.assert_allclose(own, plans[0].value, atol=2e-9)


def test_a_lake_that_is_not_slippery_is_a_shortest_path() -> None:
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make("FrozenLake-v1", map_name="8x8", is_slippery=False)
    mdp = TabularMDP.from_gymnasium(env, discount=0.9)
    assert policy_iteration(mdp).value[0] == pytest.approx(0.9**13, rel=1e-12)


def test_cliff_walking_takes_thirteen_steps() -> None:
    gymnasium = pytest.importorskip("gymnasium")
    mdp = TabularMDP.from_gymnasium(gymnasium.make("CliffWalking-v1"), discount=1.0)
    for planner in PLANNERS:
        assert planner(mdp).value[36] == pytest.approx(-13, abs=1e-6)
