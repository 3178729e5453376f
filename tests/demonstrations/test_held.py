"""Slower decisions of a fast recording."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.continuous import held_rows, hold_actions
from subgoal.demonstrations import Demonstrations
from subgoal.demonstrations.held import time_step
from subgoal.runtime.errors import InputError


def demos(lengths=(7, 2, 6), **fields):
    n = sum(lengths)
    offset = np.concatenate([[0], np.cumsum(lengths)])
    times = np.concatenate([0.1 * np.arange(k) for k in lengths])
    states = np.arange(2.0 * n).reshape(n, 2)
    return Demonstrations(
        states=states, actions=np.arange(n, dtype=float) ** 2, offset=offset, times=times,
        final_states=-np.arange(2.0 * len(lengths)).reshape(-1, 2), trajectory_names=("a", "b", "c")[: len(lengths)],
        **fields,
    )  # fmt: skip


def test_a_pair_is_the_first_state_and_the_mean_action_until_the_next():
    fast = demos((7,))
    slow = hold_actions(fast, 3)
    np.testing.assert_array_equal(slow.states, fast.states[[0, 3]])
    np.testing.assert_allclose(slow.actions[:, 0], [(0 + 1 + 4) / 3, (9 + 16 + 25) / 3])
    np.testing.assert_allclose(slow.times, [0.0, 0.3])
    assert time_step(slow) == pytest.approx(0.3)


def test_it_ended_where_the_last_held_action_ended():
    fast = demos((7, 2, 6))
    slow = hold_actions(fast, 3)
    np.testing.assert_array_equal(slow.final_states, [fast.states[6], fast.final_states[2]])


def test_short_trajectories_are_dropped_and_counted():
    slow = hold_actions(demos(groups=("g", "h", "g")), 3)
    assert slow.trajectory_names == ("a", "c")
    assert slow.groups == ("g", "g")
    assert slow.offset.tolist() == [0, 2, 4]
    assert slow.source.notes["trajectories too short dropped"] == 1
    assert slow.source.notes["samples averaged into each action"] == 3


def test_every_sample_knows_its_pair():
    assert held_rows(demos(), 3).tolist() == [0, 0, 0, 1, 1, 1, 1, -1, -1, 2, 2, 2, 3, 3, 3]


def test_one_sample_a_pair_changes_nothing():
    fast = demos()
    slow = hold_actions(fast, 1)
    np.testing.assert_array_equal(slow.states, fast.states)
    np.testing.assert_array_equal(slow.actions, fast.actions)
    np.testing.assert_array_equal(slow.final_states, fast.final_states)
    assert held_rows(fast, 1).tolist() == list(range(15))


@pytest.mark.parametrize("every", [0, 2.5, 8])
def test_stretches_that_do_not_fit_are_refused(every):
    with pytest.raises(InputError, match="every"):
        hold_actions(demos(), every)


def test_states_of_a_discrete_world_are_refused():
    with pytest.raises(InputError, match="discrete"):
        hold_actions(Demonstrations.from_arrays([0, 1], [0, 0], [0, 2]), 2)


def test_times_must_be_there_and_even():
    fast = demos()
    with pytest.raises(InputError, match="no times"):
        time_step(Demonstrations.from_arrays(fast.states, fast.actions, fast.offset))
    uneven = np.array(fast.times)
    uneven[3] += 0.05
    with pytest.raises(InputError, match="resample"):
        time_step(Demonstrations.from_arrays(fast.states, fast.actions, fast.offset, times=uneven))
    with pytest.raises(InputError, match="one pair"):
        time_step(Demonstrations.from_arrays(fast.states, fast.actions, times=np.arange(15.0)))
