"""A candidate with flat Q: by (6.2) as printed it takes nearly all observations, by the normalised form nearly none.

All expectations are exact sums over assignments; no sampler takes part.
"""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.maximum_literal import literal_maximum
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.tabular import TabularMDP
from tests.oracles.expected_counts import expected_counts
from tests.oracles.tables import PRIOR, TABLES, assignment_posterior

ETA, N = 1.0, 35
UNIFORM = np.full(3, 1 / 3)
SIDE = 5
ISLAND = SIDE * SIDE


def enumerated_counts(log_table: np.ndarray, eta: float, prior: np.ndarray) -> np.ndarray:
    law = assignment_posterior(log_table, eta, prior)
    return sum(chance * np.bincount(theta, minlength=len(prior)) for theta, chance in law.items())


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("eta", [0.05, 1.0, 5.0])
def test_expected_counts_are_those_of_all_assignments(name: str, eta: float) -> None:
    wanted = enumerated_counts(TABLES[name], eta, PRIOR)
    np.testing.assert_allclose(expected_counts(TABLES[name], eta, PRIOR), wanted, rtol=1e-12)


def headings(confidence: float, n_test: int, aimless: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Q of the action taken (N, 3) and of the test actions (N, 3, M): two goals in the plane, and one of flat Q.

    Q is minus the distance to the goal after a unit step; steps are drawn from the softmax over the test actions, or
    without aim from all of them alike.
    """
    rng = np.random.default_rng(12)
    goals, states = np.array([[6.0, 0.0], [0.0, 6.0]]), rng.uniform(-3, 3, (N, 2))
    angle = 2 * np.pi * np.arange(n_test) / n_test
    reached = states[:, None] + np.column_stack([np.cos(angle), np.sin(angle)])
    values = np.stack(
        [-np.linalg.norm(reached - goal, axis=2) for goal in goals] + [np.full((N, n_test), -4.0)], axis=1
    )
    meant = rng.integers(0, 2, N)
    weight = np.exp(confidence * (1 - aimless) * values[np.arange(N), meant])
    weight /= weight.sum(axis=1, keepdims=True)
    taken = np.array([rng.choice(n_test, p=row) for row in weight])
    return np.take_along_axis(values, taken[:, None, None], axis=2)[:, :, 0], values


def forms(confidence: float, value: np.ndarray, tested: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(N, 3) logarithms of (6.2) as printed, and with the mean over the test actions in place of the maximum."""
    peak = tested.max(axis=2)
    mean = np.exp(confidence * (tested - peak[:, :, None])).mean(axis=2)
    return confidence * (value - peak), confidence * (value - peak) - np.log(mean)


@pytest.mark.parametrize("confidence", [3.0, 10.0, 30.0])
@pytest.mark.parametrize("n_test", [24, 360])
def test_over_test_actions(confidence: float, n_test: int) -> None:
    value, tested = headings(confidence, n_test)
    printed, normalised = forms(confidence, value, tested)
    assert (printed[:, 2] == 0).all()
    assert (printed <= 0).all()
    assert (normalised[:, 2] == 0).all()
    assert expected_counts(printed, ETA, UNIFORM)[2] > 0.98 * N
    assert expected_counts(normalised, ETA, UNIFORM)[2] < 0.03 * N


@pytest.mark.parametrize("n_test", [24, 360])
def test_steps_without_aim_are_left_to_the_flat_candidate(n_test: int) -> None:
    """The normalised form does not merely keep it small."""
    _, normalised = forms(10.0, *headings(10.0, n_test, aimless=True))
    assert expected_counts(normalised, ETA, UNIFORM)[2] > 0.9 * N


def test_only_the_normalised_form_is_a_density() -> None:
    """Its mean over the test actions is one for each candidate; as printed, for the flat one alone."""
    _, tested = headings(10.0, 360)
    per_action = [forms(10.0, tested[:, :, m], tested) for m in range(360)]
    printed, normalised = (np.exp(np.stack(each)).mean(axis=0) for each in zip(*per_action, strict=True))
    np.testing.assert_allclose(normalised, 1, rtol=1e-12)
    assert (printed[:, 2] == 1).all()
    assert (printed[:, :2] < 0.5).all()


def room(confidence: float) -> LogLikelihood:
    """A 5 × 5 room with goals in two corners, walked to in turn, and an island that no step leads to, the third."""
    steps = ((0, -1), (0, 1), (1, 0), (-1, 0), (0, 0))
    transition = np.zeros((SIDE * SIDE + 1, len(steps), SIDE * SIDE + 1))
    for state in range(SIDE * SIDE):
        for a, (dx, dy) in enumerate(steps):
            x, y = np.clip(state % SIDE + dx, 0, SIDE - 1), np.clip(state // SIDE + dy, 0, SIDE - 1)
            transition[state, a, SIDE * y + x] = 1
    transition[ISLAND, :, ISLAND] = 1
    mdp = TabularMDP.from_dense(transition, 0.9)
    candidates = Candidates.from_states([SIDE - 1, SIDE * (SIDE - 1), ISLAND])
    rng = np.random.default_rng(4)
    states = rng.integers(0, SIDE * SIDE, N)
    blank = Demonstrations.from_arrays(states, np.zeros(N, int))
    laws = [planned_actions(with_actions(blank, a), candidates, mdp, confidence=confidence).dense for a in range(5)]
    law = np.exp(np.stack(laws, axis=2))
    actions = np.array([rng.choice(5, p=law[i, rng.integers(0, 2)]) for i in range(N)])
    return planned_actions(with_actions(blank, actions), candidates, mdp, confidence=confidence)


def with_actions(demonstrations: Demonstrations, actions: np.ndarray | int) -> Demonstrations:
    return Demonstrations.from_arrays(demonstrations.states, np.broadcast_to(actions, N).astype(int))


@pytest.mark.parametrize("confidence", [10.0, 30.0])
def test_over_the_actions_of_a_discrete_world(confidence: float) -> None:
    fair = room(confidence)
    printed, normalised = literal_maximum(fair).dense, fair.dense
    assert printed is not None
    assert normalised is not None
    assert (printed[:, 2] == 0).all()
    np.testing.assert_allclose(normalised[:, 2], -np.log(5), atol=1e-12)
    assert expected_counts(printed, ETA, UNIFORM)[2] > 0.97 * N
    assert expected_counts(normalised, ETA, UNIFORM)[2] < 0.03 * N
