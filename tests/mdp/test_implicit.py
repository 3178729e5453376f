"""Worlds told by a function: their rows, their tables, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.implicit import ImplicitMDP
from subgoal.mdp.planners.iteration import policy_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError

WIDE, HIGH = 5, 4
WAYS = [(0, 1), (1, 0), (0, -1), (-1, 0)]
GOAL = (4, 3)


def step(state, action):
    """A slippery grid: 0.8 the way that is meant, 0.1 to each side; the border holds."""
    reached = []
    for turn in (0, 1, -1):
        way = WAYS[(action + turn) % 4]
        reached.append((min(max(state[0] + way[0], 0), WIDE - 1), min(max(state[1] + way[1], 0), HIGH - 1)))
    return reached, [0.8, 0.1, 0.1]


def grid(**fields) -> ImplicitMDP:
    options = {"available": lambda state: () if state == GOAL else range(4), **fields}
    return ImplicitMDP(step, 4, 0.9, **options)


def test_rows_name_every_successor_once() -> None:
    successors, chances = grid().row((0, 0), 2)
    assert dict(zip(successors, chances, strict=True)) == pytest.approx({(0, 0): 0.9, (1, 0): 0.1})
    assert grid().actions(GOAL) == () and grid().actions((0, 0)) == (0, 1, 2, 3)


def test_successors_of_chance_zero_are_left_out() -> None:
    world = ImplicitMDP(lambda state, action: (["a", "b", "b"], [0.0, 0.5, 0.5]), 1, 0.5)
    successors, chances = world.row("a", 0)
    assert successors == ("b",) and chances.tolist() == [1.0]


def test_the_table_is_what_the_function_says() -> None:
    mdp, states = grid().tabulate([(0, 0)])
    assert states[0] == (0, 0) and set(states) == {(x, y) for x in range(WIDE) for y in range(HIGH)}
    wanted = np.zeros((20, 4, 20))
    for s, state in enumerate(states):
        for action in range(4 * (state != GOAL)):
            for after, chance in zip(*step(state, action), strict=True):
                wanted[s, action, states.index(after)] += chance
    np.testing.assert_allclose(mdp.matrix.toarray().reshape(20, 4, 20), wanted, atol=1e-15)
    assert [states[s] for s in np.flatnonzero(mdp.terminal)] == [GOAL]
    same = TabularMDP.from_dense(wanted, 0.9)
    reward = np.array([state == GOAL for state in states], float)
    np.testing.assert_allclose(policy_iteration(mdp, reward).value, policy_iteration(same, reward).value, atol=1e-14)


def test_states_come_breadth_first_from_the_starts() -> None:
    world = ImplicitMDP(lambda n, action: ([2 * n + action], [1.0]), 2, 0.9, lambda n: () if n > 3 else (0, 1))
    assert world.tabulate([1])[1] == (1, 2, 3, 4, 5, 6, 7)
    assert world.tabulate([3, 2, 3])[1] == (3, 2, 6, 7, 4, 5)


def test_the_thin_door() -> None:
    mdp, states = TabularMDP.from_callable(step, [(0, 0)], n_actions=4, discount=0.9)
    assert mdp.n_states == len(states) == 20 and not mdp.terminal.any() and mdp.discount == 0.9
    only = TabularMDP.from_callable(step, [(0, 0)], n_actions=4, discount=0.9, available=lambda state: [3, 0])[0]
    np.testing.assert_array_equal(only.available, [[True, False, False, True]] * only.n_states)


def test_nothing_but_an_ending() -> None:
    mdp, states = grid().tabulate([GOAL])
    assert states == (GOAL,) and mdp.terminal.all() and mdp.n_entries == 0


def test_too_many_states_are_refused() -> None:
    endless = ImplicitMDP(lambda n, action: ([n + 1], [1.0]), 1, 0.9)
    with pytest.raises(InputError, match=r"states reached: found more than 50, wanted 50 at most.*most_states"):
        endless.tabulate([0], most_states=50)
    assert grid().tabulate([(0, 0)], most_states=20)[0].n_states == 20
    with pytest.raises(InputError, match="more than 19"):
        grid().tabulate([(0, 0)], most_states=19)


@pytest.mark.parametrize(
    ("told", "message"),
    [
        ((["a"], [0.5]), "model at state 's', action 0: found probabilities that sum to 0.5,"),
        ((["a", "b"], [1.5, -0.5]), "model at state 's', action 0: found a probability of -0.5,"),
        ((["a", "b"], [1.0]), "found 2 successors and 1 probabilities"),
        (([], []), "that sum to 0,"),
        ((["a"], [np.nan]), r"probabilities of state 's', action 0 at index \(0,\): found nan"),
        (([[1, 2]], [1.0]), "found a successor that is a list, wanted something hashable"),
        (([np.zeros(2)], [1.0]), "found a successor that is a ndarray"),
        (["a", "b", "c"], r"found list, wanted \(successors, probabilities\)"),
        (None, "found NoneType"),
    ],
)
def test_bad_rows(told, message: str) -> None:
    world = ImplicitMDP(lambda state, action: told, 1, 0.9)
    for ask in (lambda: world.row("s", 0), lambda: world.tabulate(["s"])):
        with pytest.raises(InputError, match=message):
            ask()


def test_bad_worlds_and_questions() -> None:
    with pytest.raises(InputError, match=r"action at state \(0, 0\), action 7: found an action that is not available"):
        grid().row((0, 0), 7)
    with pytest.raises(InputError, match="not available"):
        grid().row(GOAL, 0)
    for actions in ([4], [-1], [0.5], ["up"]):
        with pytest.raises(InputError, match=r"available at state \(0, 0\): found .*, wanted actions of 0 to 3"):
            grid(available=lambda state, actions=actions: actions).actions((0, 0))
    with pytest.raises(InputError, match="starts: found no state"):
        grid().tabulate([])
    with pytest.raises(InputError, match="model: found int, wanted a function"):
        ImplicitMDP(3, 4, 0.9)
    with pytest.raises(InputError, match="available: found list"):
        ImplicitMDP(step, 4, 0.9, [0, 1])
    with pytest.raises(InputError, match=r"discount: found 1.5"):
        ImplicitMDP(step, 4, 1.5)
    with pytest.raises(InputError, match="n_actions: found 0"):
        ImplicitMDP(step, 0, 0.9)
    assert repr(grid()) == "ImplicitMDP(4 actions, discount 0.9)"


def test_what_is_no_list_is_told() -> None:
    plain = ImplicitMDP(lambda state, action: ((state,), (1.0,)), 1, 0.9)
    for starts, match in (
        (0, "starts: found 0, wanted a list"),
        ([[1]], "starts: found a list, wanted something hash"),
    ):
        with pytest.raises(InputError, match=match):
            plain.tabulate(starts)
    with pytest.raises(InputError, match="model at state 3, action 0: found 3, wanted a list"):
        ImplicitMDP(lambda state, action: (state, 1.0), 1, 0.9).row(3, 0)
    with pytest.raises(InputError, match="available at state 3: found 1"):
        ImplicitMDP(plain.model, 1, 0.9, available=lambda state: 1).row(3, 0)
    with pytest.raises(InputError, match=r"available at state 3: found \[1\]"):
        ImplicitMDP(plain.model, 1, 0.9, available=lambda state: [[1]]).row(3, 0)
