"""The printed form of (6.2) against its words: the value of the action, over that of the best one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError
from tests.exact.test_flat_subgoal import room

STATES = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 2.0], [0.0, 3.0], [1.0, 1.0]])
ACTIONS = np.array([[1.0, 0.0], [0.0, 2.0], [-1.0, -1.0], [3.0, 4.0], [0.0, 0.0]])
PLACES = np.array([[4.0, 0.0], [0.0, 3.1], [-2.0, -2.0]])
RADIUS = 1.0


def plane(**settings: Any) -> LogLikelihood:
    demos = Demonstrations.from_arrays(STATES, ACTIONS)
    return subgoal.action_comparison(demos, Candidates(PLACES, radius=RADIUS), **settings)


def unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def test_of_directions_is_minus_the_chord() -> None:
    way = PLACES[None] - STATES[:, None]
    wanted = -2.5 * np.linalg.norm(unit(ACTIONS)[:, None] - unit(way), axis=2)
    wanted[np.linalg.norm(way, axis=2) <= RADIUS / 2] = 0
    wanted[4] = 0
    assert (np.abs(wanted) < 1e-12).sum() == 2 + 1 + 3
    np.testing.assert_allclose(literal_maximum(plane(confidence=2.5)).dense, wanted, atol=1e-12)


def test_of_whole_actions_is_minus_the_distance() -> None:
    likelihood = plane(confidence=2.0, controller=lambda state, goal: 0.3 * (goal - state))
    way = 0.3 * (PLACES[None] - STATES[:, None])
    there = np.linalg.norm(PLACES[None] - STATES[:, None], axis=2) <= RADIUS / 2
    way[there] = 0
    median = np.median([1, 2, np.sqrt(2), 5])
    wanted = -2.0 * np.linalg.norm(ACTIONS[:, None] - way, axis=2) / median
    wanted[4] = 0
    np.testing.assert_allclose(literal_maximum(likelihood).dense, wanted, atol=1e-12)


def test_of_planned_actions_is_what_the_best_action_has_more() -> None:
    fair = room(10.0)
    actions = np.asarray(fair.demonstrations.actions)
    source: Any = fair.source
    values = source.plan.action_values[source.rows]
    taken = np.take_along_axis(values, actions[:, None, None], axis=1)[:, 0]
    wanted = 10.0 * (taken - values.max(axis=1))
    np.testing.assert_allclose(literal_maximum(fair).dense, wanted, atol=1e-12)


def test_each_candidate_has_its_own_confidence() -> None:
    one = [literal_maximum(plane(confidence=alpha)).dense for alpha in (1.0, 2.0, 5.0)]
    got = literal_maximum(plane(confidence=1.0).at(np.array([1.0, 2.0, 5.0]))).dense
    np.testing.assert_allclose(got, np.column_stack([one[g][:, g] for g in range(3)]), atol=1e-12)


def test_candidates_demonstrations_and_weights_stay() -> None:
    fair = plane(confidence=1.0).weighted(0.5)
    printed = literal_maximum(fair)
    assert printed.candidates is fair.candidates
    assert printed.demonstrations is fair.demonstrations
    np.testing.assert_allclose(printed.dense, 0.5 * literal_maximum(plane(confidence=1.0)).dense)


def test_what_has_no_printed_form_is_refused_by_name() -> None:
    fair = plane(confidence=1.0)
    with pytest.raises(InputError, match="background"):
        literal_maximum(fair.with_background(0.1))
    with pytest.raises(InputError, match="law of confidences"):
        literal_maximum(fair.at(Levels(np.array([1.0, 3.0]), np.array([0.5, 0.5]))))
    with pytest.raises(InputError, match="table of given numbers"):
        literal_maximum(LogLikelihood.from_table(np.zeros((2, 2))))
