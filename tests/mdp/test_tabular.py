"""The record of a discrete world: what it refuses, and that it keeps what it was given."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.candidates import every_state
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.iteration import value_iteration
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP, check_states
from subgoal.options.tabular import goal_option
from subgoal.runtime.errors import InputError
from tests.oracles.subgoal_planning import random_world

NOWHERE = np.zeros((2, 1, 2))
NOWHERE[0, 0, 1] = 1


def two_states(**fields) -> TabularMDP:
    """Action 0 stays, action 1 goes to the other state."""
    return TabularMDP([0, 1, 2, 3, 4], [0, 1, 1, 0], [1.0, 1.0, 1.0, 1.0], 2, **{"discount": 0.9, **fields})


def test_rows_come_back() -> None:
    table, legal, ends = random_world(0, terminal=1, illegal=True)
    mdp = TabularMDP.from_dense(table, 0.9)
    np.testing.assert_array_equal(mdp.available, legal)
    np.testing.assert_array_equal(mdp.terminal, ends)
    np.testing.assert_array_equal(mdp.matrix.toarray().reshape(table.shape), table)
    for s, a in np.argwhere(legal):
        successors, probabilities = mdp.row(s, a)
        np.testing.assert_array_equal(np.flatnonzero(table[s, a]), np.sort(successors))
        assert probabilities.sum() == pytest.approx(1, abs=1e-14)
    assert repr(mdp) == "TabularMDP(7 states × 3 actions, discount 0.9, 1 terminal)"


def test_the_record_is_a_copy() -> None:
    table, _, _ = random_world(1)
    mdp = TabularMDP.from_dense(table, 0.9)
    before = mdp.probability.copy()
    table[:] = np.nan
    np.testing.assert_array_equal(mdp.probability, before)
    assert not mdp.probability.flags.writeable


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ((2, 1, 0.01), r"transition row at state 2, action 1: found probabilities that sum to 1\.01"),
        ((0, 2, 1e-7), r"transition row at state 0, action 2"),
        ((3, 0, np.nan), r"transition at index \(3, 0, 0\)"),
        ((3, 0, np.inf), r"transition at index"),
    ],
)
def test_rows_that_do_not_sum_to_one(change: tuple[int, int, float], match: str) -> None:
    table, _, _ = random_world(2)
    state, action, extra = change
    table[state, action, 0] += extra
    with pytest.raises(InputError, match=match):
        TabularMDP.from_dense(table, 0.9)


def test_rounding_of_a_row_is_allowed() -> None:
    table, _, _ = random_world(2)
    table[0, 0] *= 1 + 5e-9
    assert TabularMDP.from_dense(table, 0.9).n_states == 7


def test_negative_probabilities_and_unknown_successors_name_their_place() -> None:
    with pytest.raises(InputError, match=r"probability at state 1, action 0: found -1"):
        TabularMDP([0, 1, 3], [1, 0, 1], [1.0, 2.0, -1.0], 1, 0.9)
    with pytest.raises(InputError, match=r"successor at state 1, action 0: found 7, wanted a state of 0 to 1"):
        TabularMDP([0, 1, 2], [1, 7], [1.0, 1.0], 1, 0.9)


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"discount": 1.1}, "discount"),
        ({"discount": -0.1}, "discount"),
        ({"discount": float("nan")}, "discount"),
        ({"discount": "often"}, "discount"),
        ({"discount": 1.0}, "no terminal state is reached from state 0"),
        ({"available": [[True, True]]}, "available"),
        ({"available": [[True, True], [True, False]]}, "not available at state 1, action 1"),
        ({"terminal": [False, True]}, "state 1, action 0"),
        ({"terminal": [0, 1]}, "terminal.*booleans"),
        ({"available": [[True], [True, True]]}, "available: found rows of different lengths"),
        ({"start": [0.5, 0.4]}, "start"),
        ({"start": [1.5, -0.5]}, "start"),
        ({"start": [1.0]}, "start"),
        ({"reward": [[0.0, 1.0]]}, "reward"),
        ({"reward": [[0.0, np.nan], [0, 0]]}, "reward"),
        ({"coordinates": [[0.0, 1.0]]}, "coordinates"),
        ({"action_names": ("a",)}, "action_names"),
    ],
)
def test_bad_fields(fields: dict, match: str) -> None:
    with pytest.raises(InputError, match=match):
        two_states(**fields)


@pytest.mark.parametrize("offset", [[0, 1, 2], [1, 2, 3, 4, 4], [0, 2, 1, 3, 4], [0, 1, 2, 3, 5], [0.0, 1.0], []])
def test_bad_offsets(offset) -> None:
    with pytest.raises(InputError):
        TabularMDP(offset, [0, 1, 1, 0], [1.0] * 4, 2, 0.9)


def test_endings() -> None:
    """An undiscounted world must end, whatever happens; a state without actions must be terminal."""
    mdp = TabularMDP.from_dense(NOWHERE, 1.0)
    np.testing.assert_array_equal(mdp.terminal, [False, True])
    with pytest.raises(InputError, match=r"available at state 1: found no action"):
        TabularMDP.from_dense(NOWHERE, 0.9, terminal=[False, False])
    loop = np.zeros((3, 1, 3))
    loop[0, 0, 0] = loop[1, 0, 2] = 1
    with pytest.raises(InputError, match="from state 0"):
        TabularMDP.from_dense(loop, 1.0)


def test_a_grid_world_is_not_its_process() -> None:
    grid = GridWorld(np.ones((2, 3), bool), 0.9)
    for call in (
        lambda: plan_subgoals(grid, [0]), lambda: value_iteration(grid, np.ones(6)), lambda: goal_option(grid, 0),
        lambda: simulate(grid, np.zeros(6, int), steps=1, start=0), lambda: every_state(grid),
    ):  # fmt: skip
        with pytest.raises(InputError, match=r"mdp: found GridWorld.*Try: world\.mdp"):
            call()


def test_trailing_empty_rows_do_not_hide_a_wrong_sum() -> None:
    table = np.zeros((3, 2, 3))
    table[0, :, 1] = 1
    table[1, :, 0] = table[1, :, 2] = 0.4
    with pytest.raises(InputError, match=r"state 1, action 0: found probabilities that sum to 0\.8"):
        TabularMDP.from_dense(table, 0.9)


def test_states_and_actions_out_of_range() -> None:
    mdp = two_states()
    for state, action in ((2, 0), (-1, 0), (0, 2), (0, -1), (0, None), (0, 1.5)):
        with pytest.raises(InputError, match=r"state|action"):
            mdp.row(state, action)
    with pytest.raises(InputError, match=r"states at index 2: found 9"):
        check_states("states", [0, 1, 9], 5)
    with pytest.raises(InputError, match="integers"):
        check_states("states", [0.0], 5)
