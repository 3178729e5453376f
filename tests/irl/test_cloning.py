"""Behavioural cloning: counts and a prior over the legal actions."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.cloning import behaviour_cloning
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError


def corridor() -> TabularMDP:
    """Left, right and jump; no jump from 0, and 2 is the end."""
    table = np.zeros((3, 3, 3))
    table[0, 0, 0] = table[0, 1, 1] = table[1, 0, 0] = table[1, 1, 2] = table[1, 2, 2] = 1.0
    return TabularMDP.from_dense(table, 0.9)


SHOWN = Demonstrations.from_arrays(np.array([0, 0, 0]), np.array([1, 1, 0]))


def test_policies_are_counts_and_a_prior_for_each_legal_action() -> None:
    found = behaviour_cloning(SHOWN, corridor(), prior=0.5)
    np.testing.assert_allclose(found.policy[0], [1.5 / 4, 2.5 / 4, 0.0])


def test_states_never_shown_are_uniform_over_what_is_legal_and_noted() -> None:
    found = behaviour_cloning(SHOWN, corridor())
    np.testing.assert_allclose(found.policy[1], 1 / 3)
    assert any("1 of 3 states" in note for note in found.notes)


def test_ends_have_no_policy() -> None:
    np.testing.assert_array_equal(behaviour_cloning(SHOWN, corridor()).policy[2], 0.0)


def test_the_policy_foretells_the_next_action_as_polyas_urn_does() -> None:
    """The mean is the predictive probability: the chance of a sequence does not hang on its order."""
    first = behaviour_cloning(Demonstrations.from_arrays(np.array([1]), np.array([0])), corridor()).policy
    other = behaviour_cloning(Demonstrations.from_arrays(np.array([1]), np.array([2])), corridor()).policy
    assert first[1, 2] == pytest.approx(other[1, 0])
    assert first[1, 0] == pytest.approx(2 / 4)


@pytest.mark.parametrize("prior", [0.0, -1.0, float("nan")])
def test_a_prior_that_is_not_above_zero_is_refused(prior: float) -> None:
    with pytest.raises(InputError, match="prior"):
        behaviour_cloning(SHOWN, corridor(), prior=prior)


def test_impossible_steps_are_refused() -> None:
    stray = Demonstrations(np.array([0, 0]), np.array([1, 1]), np.array([0, 2]))
    with pytest.raises(InputError, match="observation 1"):
        behaviour_cloning(stray, corridor())
