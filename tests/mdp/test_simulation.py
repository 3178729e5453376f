"""Walks: what the policy and the world say, in the proportions they say, hanging on seed and index alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from subgoal._kernels import walks
from subgoal._kernels.draws import choose
from subgoal.mdp import simulation
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

EDGE = 1e-5
"""Level of the chi-square test below, with its quantile for three cells (two degrees of freedom): −2 log(level)."""
CHOOSE = getattr(choose, "py_func", choose)
"""The Python form, which takes any source of numbers."""


def chain(**fields) -> TabularMDP:
    """States 0..3; action 0 goes left, 1 right with chance 0.75 (else stays), 2 only in state 1; state 3 is the end."""
    table = np.zeros((4, 3, 4))
    for state in range(3):
        table[state, 0, max(state - 1, 0)] = 1
        table[state, 1, state + 1], table[state, 1, state] = 0.75, 0.25
    table[1, 2, [0, 2, 3]] = 0.2, 0.3, 0.5
    return TabularMDP.from_dense(table, 0.9, **fields)


def test_a_walk_ends_on_entering_a_terminal_state() -> None:
    demos = simulate(chain(), [1, 1, 1, -1], steps=1000, trajectories=20, start=0)
    assert not demos.truncated.any() and (demos.final_states == 3).all()
    assert (demos.states < 3).all() and (demos.actions == 1).all()
    last = demos.offset[1:] - 1
    assert (demos.states[last] == 2).all() and (demos.states[demos.offset[:-1]] == 0).all()
    inside = np.setdiff1d(np.arange(demos.n_observations - 1), last)
    assert set(np.diff(demos.states)[inside]) <= {0, 1}


def test_a_walk_that_runs_out_of_steps_is_truncated() -> None:
    demos = simulate(chain(), [0, 0, 0, 0], steps=5, trajectories=3, start=[0, 1, 2])
    assert demos.truncated.all() and (demos.final_states == 0).all()
    np.testing.assert_array_equal(demos.states.reshape(3, 5), [[0, 0, 0, 0, 0], [1, 0, 0, 0, 0], [2, 1, 0, 0, 0]])


def test_entering_the_end_with_the_last_step_is_no_truncation() -> None:
    table = np.zeros((3, 1, 3))
    table[0, 0, 1] = table[1, 0, 2] = 1
    world = TabularMDP.from_dense(table, 0.9)
    assert not simulate(world, [0, 0, -1], steps=2, start=0).truncated.any()
    assert simulate(world, [0, 0, -1], steps=1, start=0).truncated.all()


def test_trajectory_k_hangs_on_seed_and_k_alone() -> None:
    policy = np.array([[0.5, 0.5, 0], [0.2, 0.3, 0.5], [0.5, 0.5, 0], [0, 0, 0]])
    few = simulate(chain(), policy, steps=50, trajectories=5, start=[0.5, 0.25, 0.25, 0.0], seed=4)
    many = simulate(chain(), policy, steps=50, trajectories=10, start=[0.5, 0.25, 0.25, 0.0], seed=4)
    n = few.n_observations
    np.testing.assert_array_equal(few.offset, many.offset[:6])
    np.testing.assert_array_equal(few.states, many.states[:n])
    np.testing.assert_array_equal(few.actions, many.actions[:n])
    np.testing.assert_array_equal(few.final_states, many.final_states[:5])
    other = simulate(chain(), policy, steps=50, trajectories=5, start=[0.5, 0.25, 0.25, 0.0], seed=5)
    assert few.n_observations != other.n_observations or (few.states != other.states).any()


def test_the_room_of_a_walk_does_not_change_it(monkeypatch: pytest.MonkeyPatch) -> None:
    policy = np.array([[0.9, 0.1, 0], [0.9, 0.1, 0], [0.9, 0.1, 0], [0, 0, 0]])
    whole = simulate(chain(), policy, steps=300, trajectories=3, start=0, seed=1)
    monkeypatch.setattr(simulation, "ROOM", 7)
    parts = simulate(chain(), policy, steps=300, trajectories=3, start=0, seed=1)
    np.testing.assert_array_equal(whole.states, parts.states)
    np.testing.assert_array_equal(whole.actions, parts.actions)
    np.testing.assert_array_equal(whole.offset, parts.offset)


def test_proportions_of_actions_and_successors() -> None:
    policy = np.array([[0.5, 0.5, 0], [0.2, 0.3, 0.5], [0.5, 0.5, 0], [0, 0, 0]])
    demos = simulate(chain(start=[0.0, 1.0, 0.0, 0.0]), policy, steps=1, trajectories=4000, seed=2)
    check_proportions(np.bincount(demos.actions, minlength=3), [0.2, 0.3, 0.5])
    after = demos.final_states[demos.actions == 2]
    check_proportions(np.bincount(after, minlength=4)[[0, 2, 3]], [0.2, 0.3, 0.5])


def check_proportions(counts, wanted) -> None:
    expected = counts.sum() * np.array(wanted)
    assert ((counts - expected) ** 2 / expected).sum() < -2 * math.log(EDGE)


def test_actions_and_successors_of_chance_zero_never_happen() -> None:
    weights = np.array([0.0, 0.5, 0.0, 0.5, 0.0])

    class Edge:
        def __init__(self, number: float) -> None:
            self.number = number

        def random(self) -> float:
            return self.number

    chosen = [CHOOSE(weights, 5, Edge(u)) for u in (0.0, 0.5 - 1e-12, 0.5, 1 - 1e-16, 1.0)]
    assert chosen == [1, 1, 3, 3, 3]
    assert CHOOSE(weights[2:], 3, Edge(0.0)) == 1
    assert CHOOSE(4 * weights, 5, Edge(0.6)) == CHOOSE(weights / 4, 5, Edge(0.6)) == 3
    assert CHOOSE(4 * weights, 5, Edge(0.4)) == CHOOSE(weights / 4, 5, Edge(0.4)) == 1


def test_compiled_walk_is_its_python_form() -> None:
    world = chain()
    chances = np.array([[0.5, 0.5, 0], [0.2, 0.3, 0.5], [0.5, 0.5, 0], [0, 0, 0]]).ravel()
    for seed, given in [(0, chances), (1, chances), (2, np.zeros(0))]:
        told = []
        for function in (walks.walk, getattr(walks.walk, "py_func", walks.walk)):
            states, actions = np.full(40, -9), np.full(40, -9)
            end = function(
                0, np.array([1, 1, 1, -1]), given, 3, world.offset, world.successor, world.probability, world.terminal,
                stream(seed, 0), states, actions,
            )  # fmt: skip
            told.append((end, states, actions))
        assert told[0][0] == told[1][0] and told[0][0][0] > 1
        np.testing.assert_array_equal(told[0][1], told[1][1])
        np.testing.assert_array_equal(told[0][2], told[1][2])


def test_coordinates_come_along() -> None:
    places = np.arange(8.0).reshape(4, 2)
    demos = simulate(chain(coordinates=places), [1, 1, 1, 0], steps=9, start=0)
    np.testing.assert_array_equal(demos.places, places[demos.states])


ALL = [1, 1, 1, -1]


@pytest.mark.parametrize(
    ("policy", "fields", "message"),
    [
        ([1, 1, 2, 0], {}, r"policy at state 2: found action 2, wanted .*\(0, 1\)"),
        ([1, -1, 1, 0], {}, "policy at state 1: found action -1"),
        ([1, 1, 3, 0], {}, "policy at state 2: found action 3"),
        ([1, 1, 1], {}, r"policy: found int64 of shape \(3,\)"),
        ([1.0, 1.0, 1.0, 1.0], {}, r"policy: found float64 of shape \(4,\)"),
        ([[0.5, 0.5, 0]] * 2 + [[0.2, 0.3, 0.5]] * 2, {}, r"policy at state 2: found a chance of action 2"),
        ([[0.5, 0.5, 0]] * 2 + [[0.2, 0.3, 0]] * 2, {}, r"policy at state 2: found probabilities that sum to 0.5"),
        ([[0.5, 0.5, 0]] * 2 + [[-0.5, 1.5, 0]] * 2, {}, r"policy at state 2: found a probability of -0.5"),
        ([[np.nan, 0.5, 0]] * 4, {}, r"policy at index \(0, 0\): found nan"),
        (ALL, {"start": None}, "start: found None"),
        (ALL, {"start": 3}, "start: found terminal state 3"),
        (ALL, {"start": 4}, "start: found 4, wanted a state of 0 to 3"),
        (ALL, {"start": [0, 1]}, r"start: found shape \(2,\), wanted one state or 1"),
        (ALL, {"start": [0.5, 0.0, 0.0, 0.5]}, "start: found terminal state 3"),
        (ALL, {"start": [0.5, 0.0, 0.0, 0.0]}, "start: found 4 numbers that sum to 0.5"),
        (ALL, {"steps": 0}, "steps: found 0"),
        (ALL, {"trajectories": 0}, "trajectories: found 0"),
        (ALL, {"seed": -1}, "seed: found -1"),
    ],
)
def test_bad_input(policy, fields, message: str) -> None:
    with pytest.raises(InputError, match=message):
        simulate(chain(), policy, **{"steps": 5, "start": 0, **fields})
