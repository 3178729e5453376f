"""Scores on cases worked out by hand, and against other implementations."""

from __future__ import annotations

from itertools import combinations, permutations

import numpy as np
import pytest

from subgoal.answers.scores import (
    adjusted_rand,
    assignment_loss,
    bits_per_decision,
    expected_value_difference,
    identified,
    policy_loss,
    recovery,
    top_candidates,
    zero_one_loss,
)
from subgoal.candidates import Candidates, every_state
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.sample import sample
from subgoal.runtime.errors import InputError
from tests.mdp.small_worlds import corridor


def test_bits_per_decision() -> None:
    table = np.array([[0.5, 0.25, 0.25], [1.0, 0.0, 0.0], [1 / 3, 1 / 3, 1 / 3]])
    assert bits_per_decision(table, [1, 0, 2]) == pytest.approx((-2 + 0 - np.log2(3)) / 3)
    assert bits_per_decision(table, [1, 0, 2], counted=[True, False, False]) == -2
    assert bits_per_decision(table, [1, 2, 2]) == -np.inf


def test_zero_one_loss_breaks_ties_evenly() -> None:
    table = np.array([[0.5, 0.5, 0.0], [0.2, 0.3, 0.5]])
    assert zero_one_loss(table, [0, 2]) == pytest.approx(0.25)
    assert zero_one_loss(table, [2, 0]) == 1
    assert zero_one_loss(np.full((4, 4), 0.25), [0, 1, 2, 3]) == pytest.approx(0.75)


def test_a_constant_reward_scores_one_minus_one_over_actions() -> None:
    optimal = np.ones((6, 4), bool)
    actions = np.array([0, 1, 2, 3, 0, 1])
    assert policy_loss(optimal, actions) == pytest.approx(6 * 0.75)
    assert policy_loss(optimal, actions, ties="first") == 4
    assert policy_loss(np.eye(4, dtype=bool)[actions], actions) == 0


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: bits_per_decision([[0.5, 0.4]], [0]), "observation 0"),
        (lambda: bits_per_decision([[1.5, -0.5]], [0]), "observation 0"),
        (lambda: bits_per_decision([[0.5, 0.5]], [2]), "observation 0"),
        (lambda: bits_per_decision([[0.5, 0.5]], [0.0]), "actions"),
        (lambda: bits_per_decision([[0.5, np.nan]], [0]), "finite"),
        (lambda: bits_per_decision([[0.5, 0.5]], [0], counted=[False]), "no decision"),
        (lambda: policy_loss([[True, False]], [0, 1]), "actions"),
        (lambda: policy_loss([[True, False]], [2]), "actions at observation 0: found 2"),
        (lambda: policy_loss([[0.5, 0.5]], [0]), "optimal: found float64"),
        (lambda: bits_per_decision([[0.5, 0.5]] * 3, [0, 1, 0], counted=np.array([2])), "counted: found int64"),
        (lambda: bits_per_decision([[0.5, 0.5]] * 3, [0, 1, 0], counted=[True]), "counted"),
        (lambda: adjusted_rand([[1, 2], [3, 4]], [1, 2, 3, 4]), "labels"),
        (
            lambda: expected_value_difference(corridor(3, 0.9), np.ones(3), np.zeros(3, int), start=np.full(3, -3.0)),
            "start",
        ),
        (lambda: expected_value_difference(corridor(3, 0.9), np.ones(3), np.zeros(3, int), start=[1.0]), "start"),
        (lambda: policy_loss([[False, False]], [0]), "best action"),
        (lambda: policy_loss([[True, False]], [0], ties="last"), "ties"),
        (lambda: recovery([[0.0, 0.0]], [[0.0]]), "dimensions"),
        (lambda: recovery([[0.0]], [[0.0]], radius=-1), "radius"),
        (lambda: adjusted_rand([0, 1], [0]), "labels"),
    ],
)
def test_bad_input(call, match: str) -> None:
    with pytest.raises(InputError, match=match):
        call()


def most_pairs(found: np.ndarray, true: np.ndarray, radius: float) -> int:
    """By trying every injection of the smaller set."""
    if len(found) > len(true):
        found, true = true, found
    return max(
        sum(np.linalg.norm(found[f] - true[t]) <= radius for f, t in zip(range(len(found)), chosen, strict=True))
        for chosen in permutations(range(len(true)), len(found))
    )


def test_recovery_matches_as_many_as_possible() -> None:
    for seed in range(40):
        generator = np.random.default_rng(seed)
        found = generator.integers(0, 4, size=(generator.integers(1, 5), 2)).astype(float)
        true = generator.integers(0, 4, size=(generator.integers(1, 5), 2)).astype(float)
        for radius in (0.0, 1.0, 1.5):
            answer = recovery(found, true, radius=radius)
            assert len(answer.pairs) == most_pairs(found, true, radius)
            assert answer.precision == len(answer.pairs) / len(found)
            assert answer.recall == len(answer.pairs) / len(true)
    assert recovery(np.empty((0, 2)), [[1.0, 1.0]]).recall == 0
    assert recovery(np.empty((0, 2)), [[1.0, 1.0]]).precision == 1


def test_adjusted_rand_by_pairs() -> None:
    for seed in range(20):
        generator = np.random.default_rng(seed)
        a, b = generator.integers(0, 3, size=(2, 9))
        pairs = list(combinations(range(9), 2))
        both = sum(a[i] == a[j] and b[i] == b[j] for i, j in pairs)
        first, second = (sum(x[i] == x[j] for i, j in pairs) for x in (a, b))
        expected = first * second / len(pairs)
        wanted = (both - expected) / ((first + second) / 2 - expected)
        assert adjusted_rand(a, b) == pytest.approx(wanted)
    assert adjusted_rand([0, 0, 1], [5, 5, 2]) == 1
    assert adjusted_rand([0, 0], [1, 1]) == 1


def test_loss_of_an_assignment() -> None:
    """Right towards 4, left towards 0; at 0, staying and running into the wall are equally good: half a loss."""
    mdp = corridor(5, 0.9)
    demos = Demonstrations.from_arrays(np.array([1, 2, 3, 0]), np.array([1, 1, 0, 2]))
    table = planned_actions(demos, every_state(mdp), mdp)
    assert assignment_loss(table, [4, 4, 0, 0]) == 0.5
    assert assignment_loss(table, [4, 0, 0, 0]) == 1.5
    assert assignment_loss(table, [0, 0, 4, 4]) == 4
    assert assignment_loss(table, [4, 4, 0, 0], ties="first") == 1
    for labels in (np.full(4, -1), [0, 0, 0, 5], [0, 0], 0, [0.0] * 4):
        with pytest.raises(InputError, match="assignment"):
            assignment_loss(table, labels)
    with pytest.raises(InputError, match="planned actions"):
        assignment_loss(LogLikelihood.from_table(np.zeros((2, 2))), [0, 0])


def test_a_perfect_demonstrator_far_from_the_goal_loses_nothing() -> None:
    mdp = corridor(60, 0.5)
    demos = Demonstrations.from_arrays(np.arange(1, 60), np.zeros(59, int))
    table = planned_actions(demos, Candidates.from_states([0]), mdp)
    assert assignment_loss(table, np.zeros(59, int)) == 0


def test_what_two_candidates_explain_equally_well_is_not_identified() -> None:
    mdp = corridor(6, 0.9)
    demos = Demonstrations.from_arrays(np.array([1, 3, 3]), np.array([0, 1, 1]))
    table = planned_actions(demos, Candidates.from_states([0, 5, 2]), mdp)
    # from 3, both 0 and 2 lie to the left, but at different distances; made equal by a table of one's own
    np.testing.assert_array_equal(identified(table, [0, 1, 1], [0, 0, 1]), [True, True, True])
    equal = LogLikelihood.from_table(np.array([[0.0, 0.0], [0.0, -1.0]]))
    np.testing.assert_array_equal(identified(equal, [0, 0], [1, 1]), [False, True])
    np.testing.assert_array_equal(identified(equal, [0, 0], [0, 0]), [True, True])
    for labels, within in ((np.full(2, -1), 0.1), ([0, 2], 0.1), ([0, 0], float("nan"))):
        with pytest.raises(InputError, match=r"true|within"):
            identified(equal, labels, [0, 0], within=within)


def test_expected_value_difference() -> None:
    """Staying at 2 for ever is worth nothing; the best policy walks two steps to the reward and stays."""
    mdp = corridor(5, 0.9)
    reward = np.array([0, 0, 0, 0, 1.0])
    start = np.eye(5)[2]
    assert expected_value_difference(mdp, reward, np.full(5, 2), start=start) == pytest.approx(0.9**2 / 0.1, rel=1e-7)
    assert expected_value_difference(mdp, reward, np.ones(5, int), start=start) == pytest.approx(0, abs=1e-6)


@pytest.mark.filterwarnings("ignore")
def test_top_candidates() -> None:
    table = np.log(np.array([[0.1, 0.8, 0.1]] * 6 + [[0.05, 0.05, 0.9]] * 2))
    posterior = sample(LogLikelihood.from_table(table * 4), draws=200, warmup=100)
    np.testing.assert_array_equal(top_candidates(posterior, 2), [1, 2])
    with pytest.raises(InputError, match="count"):
        top_candidates(posterior, 0)
