"""Worlds from Gymnasium's tables: endings, twins, rewards, starts; and that acting in both is the same."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from subgoal.mdp.gym import from_gymnasium
from subgoal.mdp.planners.iteration import policy_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError


def world(table, start=None, discount=0.9) -> TabularMDP:
    """Of an environment that has a table and nothing else."""
    return from_gymnasium(SimpleNamespace(P=table, initial_state_distrib=start), discount=discount)


def dense(mdp: TabularMDP) -> np.ndarray:
    return mdp.matrix.toarray().reshape(mdp.n_states, mdp.n_actions, mdp.n_states)


def test_duplicates_are_merged_and_rewards_expected() -> None:
    table = {
        0: {0: [(0.25, 1, 4.0, True), (0.25, 0, 0.0, False), (0.5, 1, 2.0, True)], 1: [(1.0, 0, -1.0, False)]},
        1: {0: [(1.0, 1, 0.0, True)], 1: [(1.0, 0, 7.0, False)]},
    }
    mdp = world(table, [1.0, 0.0])
    np.testing.assert_array_equal(dense(mdp)[0], [[0.25, 0.75], [1, 0]])
    np.testing.assert_array_equal(mdp.reward, [[2, -1], [0, 0]])
    np.testing.assert_array_equal(mdp.terminal, [False, True])
    assert mdp.n_entries == 3
    np.testing.assert_array_equal(mdp.start, [1, 0])


def test_a_state_that_is_entered_both_ways_gets_a_terminal_twin() -> None:
    """From 0: action 0 ends in 1, action 1 goes on in 1; state 1 goes back to 0 for a reward of 1."""
    table = {
        0: {0: [(1.0, 1, 10.0, True)], 1: [(0.5, 1, 0.0, False), (0.5, 1, 4.0, True)]},
        1: {0: [(1.0, 0, 1.0, False)]},
    }
    mdp = world(table, [0.5, 0.5])
    assert mdp.n_states == 3
    np.testing.assert_array_equal(mdp.terminal, [False, False, True])
    np.testing.assert_array_equal(dense(mdp)[0], [[0, 0, 1], [0, 0.5, 0.5]])
    np.testing.assert_array_equal(dense(mdp)[1], [[1, 0, 0], [0, 0, 0]])
    np.testing.assert_array_equal(mdp.reward, [[10, 2], [1, 0], [0, 0]])
    np.testing.assert_array_equal(mdp.available[1], [True, False])
    np.testing.assert_array_equal(mdp.start, [0.5, 0.5, 0])


def test_a_state_in_which_episodes_begin_is_not_terminal() -> None:
    table = {0: {0: [(1.0, 0, 1.0, True)]}}
    assert world(table).terminal.tolist() == [True]
    assert world(table, [1.0]).terminal.tolist() == [False, True]


def test_what_an_ending_does_itself_does_not_count() -> None:
    """State 1 would go on to 2 with an end, and to 1 without one; nobody else enters 2, which stays as it is."""
    table = {
        0: {0: [(1.0, 1, 0.0, True)]},
        1: {0: [(0.5, 2, 0.0, True), (0.5, 1, 0.0, False)]},
        2: {0: [(1.0, 0, 0.0, False)]},
    }
    mdp = world(table)
    np.testing.assert_array_equal(mdp.terminal, [False, True, False])
    np.testing.assert_array_equal(dense(mdp)[:, 0], [[0, 1, 0], [0, 0, 0], [1, 0, 0]])


def test_states_that_turn_out_not_to_end_count_after_all() -> None:
    """State 1 is entered both ways, so that its own way into 2, without an end, counts: 2 is no ending either."""
    table = {
        0: {0: [(0.5, 1, 0.0, True), (0.25, 1, 0.0, False), (0.25, 2, 0.0, True)]},
        1: {0: [(1.0, 2, 0.0, False)]},
        2: {0: [(1.0, 0, 0.0, False)]},
    }
    mdp = world(table)
    np.testing.assert_array_equal(mdp.terminal, [False, False, False, True, True])
    np.testing.assert_array_equal(dense(mdp)[0, 0], [0, 0.25, 0, 0.5, 0.25])


def test_entries_of_chance_zero_are_no_entries() -> None:
    table = {0: {0: [(1.0, 1, 0.0, True), (0.0, 1, 9.0, False)]}, 1: {0: [(1.0, 1, 0.0, True)]}}
    mdp = world(table)
    assert mdp.n_entries == 1 and mdp.terminal.tolist() == [False, True]


@pytest.mark.parametrize(
    ("table", "start", "message"),
    [
        ({0: {0: [(0.5, 0, 0.0, False)]}}, None, "transition row at state 0, action 0: found probabilities that sum"),
        ({0: {0: [(1.5, 0, 0, False), (-0.5, 0, 0, False)]}}, None, "state 0, action 0: found a probability of -0.5"),
        ({0: {0: [(np.nan, 0, 0, False)]}}, None, "env.P at state 0, action 0: found a probability of nan"),
        ({0: {0: [(1.0, 3, 0.0, False)]}}, None, "env.P at state 0, action 0: found state 3"),
        ({1: {0: [(1.0, 1, 0.0, False)]}}, None, "env.P: found 1 states of other numbers"),
        ({0: {"up": [(1.0, 0, 0.0, False)]}}, None, "env.P at state 0, action up: found 'up'"),
        ({0: {0: [(1.0, 0, np.inf, False)]}}, None, r"rewards of env.P at index \(0,\): found inf"),
        ({0: {0: []}}, None, "env.P: found no transitions"),
        ({}, None, "env.P: found 0 states"),
        ({0: {0: [(1.0, 0, 0.0, False)]}}, [0.5, 0.5], "initial_state_distrib: found 2 numbers, wanted 1"),
    ],
)
def test_bad_tables(table, start, message: str) -> None:
    with pytest.raises(InputError, match=message):
        world(table, start)


def test_an_environment_without_a_table() -> None:
    with pytest.raises(InputError, match=r"env: found .* without a table P.*ImplicitMDP"):
        from_gymnasium(SimpleNamespace(), discount=0.9)
    with pytest.raises(InputError, match="discount"):
        world({0: {0: [(1.0, 0, 0.0, False)]}}, discount=1.5)


NAMES = ["FrozenLake-v1", "CliffWalking-v1", "CliffWalkingSlippery-v1", "Taxi-v4"]


@pytest.mark.parametrize("name", NAMES)
def test_every_transition_of_the_table_is_in_the_world(name: str) -> None:
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make(name)
    mdp, table = TabularMDP.from_gymnasium(env, discount=0.95), env.unwrapped.P
    rows = dense(mdp)
    for state in np.flatnonzero(~mdp.terminal[: len(table)]):
        for action, entries in table[int(state)].items():
            left = rows[state, action].copy()
            for chance, after, _, over in entries:
                place = after if not over or mdp.terminal[after] else on_twin(mdp, rows, state, action)
                assert mdp.terminal[place] == over
                left[place] -= chance
            np.testing.assert_allclose(left, 0, atol=1e-12)
            wanted = sum(chance * reward for chance, _, reward, _ in entries)
            assert mdp.reward[state, action] == pytest.approx(wanted, abs=1e-12)


def on_twin(mdp: TabularMDP, rows: np.ndarray, state: int, action: int) -> int:
    (place,) = np.flatnonzero(rows[state, action] * mdp.terminal)
    return int(place)


@pytest.mark.parametrize("name", NAMES)
def test_values_are_those_of_the_table_itself(name: str) -> None:
    """Value iteration over ``P`` as it stands, ``over`` cutting off what follows; in every state that is alive."""
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make(name)
    table = env.unwrapped.P
    value = np.zeros(len(table))
    for _ in range(400):
        value = np.array([
            max(
                sum(p * (r + 0.9 * value[t] * (not over)) for p, t, r, over in entries)
                for entries in table[state].values()
            )
            for state in range(len(table))
        ])  # fmt: skip
    mdp = TabularMDP.from_gymnasium(env, discount=0.9)
    alive = ~mdp.terminal[: len(table)]
    # After 400 sweeps 0.9^400 / 0.1 of the largest reward, 100, is left: 5e-16.
    np.testing.assert_allclose(policy_iteration(mdp).value[: len(table)][alive], value[alive], atol=1e-11)


def test_taxi_has_twins_where_a_passenger_has_arrived() -> None:
    gymnasium = pytest.importorskip("gymnasium")
    env = gymnasium.make("Taxi-v4")
    mdp = TabularMDP.from_gymnasium(env, discount=0.99)
    assert mdp.n_states == 504 and np.flatnonzero(mdp.terminal).tolist() == [500, 501, 502, 503]
    assert mdp.start.size == 504 and np.count_nonzero(mdp.start) == 300


@pytest.mark.parametrize(
    "table",
    [
        {0: {0: [(1.0, 0, 0.0)]}},
        {0: {0: [("often", 0, 0.0, False)]}},
        {0: {0: [(1.0, 0, None, False)]}},
        {0: {0: [(1.0, [0], 0.0, False)]}},
        {0: None},
        [1],
        7,
    ],
)
def test_tables_of_another_form(table) -> None:
    with pytest.raises(InputError, match=r"env\.P"):
        from_gymnasium(SimpleNamespace(P=table), discount=0.9)
