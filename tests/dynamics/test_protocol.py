"""What is checked of transition functions and of actions."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.dynamics import REAR_DRIVE, Dynamics, check_bounds, checked_dynamics
from subgoal.runtime.errors import InputError

STATES, ACTIONS = np.arange(12.0).reshape(3, 4), np.ones((3, 2))


def test_an_answer_comes_through() -> None:
    told = checked_dynamics(lambda s, a, t: s + t * a[:, :1], STATES, ACTIONS, 0.5)
    np.testing.assert_array_equal(told, STATES + 0.5)
    assert isinstance(REAR_DRIVE, Dynamics)


@pytest.mark.parametrize("wrong", [lambda s, a, t: s[:, :3], lambda s, a, t: s[0], lambda s, a, t: s.astype(str),
                                   lambda s, a, t: s.astype(int)])  # fmt: skip
def test_answers_of_another_kind_are_refused(wrong) -> None:
    with pytest.raises(InputError, match=r"dynamics: found an answer of shape .* wanted floats of shape \(3, 4\)"):
        checked_dynamics(wrong, STATES, ACTIONS, 0.5)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_the_first_broken_row_is_named(value: float) -> None:
    def broken(states, actions, duration):
        out = states.copy()
        out[1:, 2] = value
        return out

    with pytest.raises(InputError, match=r"state \(4, 5, 6, 7\), action \(1, 1\), held for 0.5: .* in 2 of 3 rows"):
        checked_dynamics(broken, STATES, ACTIONS, 0.5)


def test_what_goes_in_is_checked() -> None:
    with pytest.raises(InputError, match="dynamics: found int"):
        checked_dynamics(3, STATES, ACTIONS, 0.5)
    with pytest.raises(InputError, match="duration: found 0"):
        checked_dynamics(REAR_DRIVE, STATES, ACTIONS, 0)
    with pytest.raises(InputError, match="actions: found 1 rows"):
        checked_dynamics(REAR_DRIVE, STATES, ACTIONS[:1], 0.5)


def test_actions_on_their_bounds_are_within() -> None:
    given = [[-0.5, 0.0], [0.5, 3.6]]
    np.testing.assert_array_equal(check_bounds(*REAR_DRIVE.bounds, given), given)


def test_the_first_action_outside_is_named() -> None:
    with pytest.raises(InputError, match=r"actions at index \(1, 1\): found 3.7, wanted 0 to 3.6"):
        check_bounds(*REAR_DRIVE.bounds, [[0.0, 3.0], [0.5, 3.7], [0.6, 1.0]])
    with pytest.raises(InputError, match=r"actions at index \(0, 0\): found -0.6"):
        check_bounds(*REAR_DRIVE.bounds, [[-0.6, 3.0]])


def test_bounds_that_are_none_are_refused() -> None:
    with pytest.raises(InputError, match=r"low at dimension 1: found 3\.0, wanted below high, which is 3"):
        check_bounds([0.0, 3.0], [1.0, 3.0], [[0.5, 3.0]])
    with pytest.raises(InputError, match="2 and 2 bounds for 1 dimensions"):
        check_bounds([0.0, 3.0], [1.0, 4.0], [[0.5]])
    with pytest.raises(InputError, match="low at index"):
        check_bounds([np.nan], [1.0], [[0.5]])
