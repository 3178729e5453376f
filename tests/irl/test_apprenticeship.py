"""Apprenticeship learning: both variants, what is matched, what is returned, how it ends."""

from __future__ import annotations

import os
import signal

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.mdp.tabular import TabularMDP
from subgoal.optima import Outcome
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent
from tests.irl.linear_world import DISCOUNT, FEATURES, TRUE, demonstrations, dense, optimal, visits_by_series, world

LUCKY = Demonstrations(np.array([0, 8, 7, 6, 6]), np.array([0, 0, 0, 1, 1]), np.array([0, 5]))
"""Not one step of it failed: no policy collects as much."""
THREE = np.column_stack([FEATURES, np.arange(9)])
"""With these the nearest that a mixture gets to the lucky demonstrator takes several policies."""
VARIANTS = ["max_margin", "projection"]
SCALED, SCALED_THREE = (features / np.ptp(features, axis=0) for features in (FEATURES, THREE))


def shown_visits(demos: Demonstrations) -> np.ndarray:
    """(9,) discounted visits, pair by pair; broken-off walks stay where they ended."""
    total = np.zeros(9)
    for k, (begin, end) in enumerate(zip(demos.offset[:-1], demos.offset[1:], strict=True)):
        for t, s in enumerate(demos.states[begin:end]):
            total[s] += (1 - DISCOUNT) * DISCOUNT**t
        total[demos.final_states[k]] += DISCOUNT ** (end - begin)
    return total / demos.n_trajectories


def apart(demos: Demonstrations, policy: np.ndarray, features: np.ndarray) -> np.ndarray:
    """μ_E − μ of a policy, by the series."""
    start = np.bincount(demos.states[demos.offset[:-1]], minlength=9) / demos.n_trajectories
    return (shown_visits(demos) - visits_by_series(dense(), policy, start)) @ features


@pytest.mark.parametrize("variant", VARIANTS)
def test_the_mixture_collects_what_the_demonstrator_collects(variant: str) -> None:
    demos = demonstrations(world(), each=200)
    found = apprenticeship(demos, world(), FEATURES, variant=variant, margin=1e-3)
    assert found.outcome is Outcome.CONVERGED
    assert np.linalg.norm(apart(demos, found.policy, SCALED)) <= 5e-3


def test_the_policy_of_a_linear_reward_is_recovered() -> None:
    """By its own visits as features the demonstrator is matched in every state."""
    demos = demonstrations(world(), each=200)
    found = apprenticeship(demos, world(), margin=1e-4)
    assert np.abs(found.policy - optimal(world(), TRUE)).max() < 0.2
    np.testing.assert_array_equal(found.policy.argmax(axis=1), optimal(world(), TRUE).argmax(axis=1))


def test_both_variants_come_to_the_same_nearest_point() -> None:
    exact = apprenticeship(LUCKY, world(), THREE, variant="max_margin", margin=1e-6)
    steps = apprenticeship(LUCKY, world(), THREE, variant="projection", margin=1e-3, most_iterations=2000)
    assert exact.outcome is steps.outcome is Outcome.CONVERGED
    distances = [np.linalg.norm(apart(LUCKY, found.policy, SCALED_THREE)) for found in (exact, steps)]
    assert distances[0] > 0.03
    assert 0 <= distances[1] - distances[0] <= 1e-3
    scale = np.ptp(THREE, axis=0)
    np.testing.assert_allclose(exact.weights * scale, steps.weights * scale, atol=0.005)


def test_at_the_nearest_point_no_policy_is_nearer() -> None:
    found = apprenticeship(LUCKY, world(), THREE, margin=1e-6)
    weights = found.weights * np.ptp(THREE, axis=0)
    least = weights @ apart(LUCKY, optimal(world(), found.reward), SCALED_THREE)
    assert np.linalg.norm(weights) == pytest.approx(1.0)
    assert np.linalg.norm(apart(LUCKY, found.policy, SCALED_THREE)) <= least + 2e-6
    assert any(f"no mixture gets nearer than {least:.2g}" in note for note in found.notes)


def test_the_mixture_has_the_visits_of_its_parts() -> None:
    """In two steps: the uniform policy and the optimal one, nothing else."""
    demos = demonstrations(world())
    found = apprenticeship(demos, world(), FEATURES, variant="projection", most_iterations=2, margin=1e-9)
    parts = [np.full((9, 3), 1 / 3), optimal(world(), found.trace[0])]
    gaps = np.array([apart(demos, part, SCALED) for part in parts])
    way = gaps[0] - gaps[1]
    share = np.clip(gaps[0] @ way / (way @ way), 0, 1)
    np.testing.assert_allclose(apart(demos, found.policy, SCALED), gaps[0] - share * way, atol=1e-9)


def test_the_greedy_policy_is_optimal_for_the_last_reward() -> None:
    demos = demonstrations(world())
    found = apprenticeship(demos, world(), FEATURES, policy="greedy")
    np.testing.assert_allclose(found.policy, optimal(world(), found.reward))
    np.testing.assert_allclose(found.reward, found.trace[-1])


def test_the_reward_is_that_of_the_weights_of_the_features_as_given() -> None:
    found = apprenticeship(demonstrations(world()), world(), 7 * FEATURES)
    np.testing.assert_allclose(found.reward, 7 * FEATURES @ found.weights)
    assert found.trace.shape == (found.iterations, 9)


def test_units_and_zero_of_the_features_do_not_matter() -> None:
    demos = demonstrations(world())
    first = apprenticeship(demos, world(), FEATURES)
    other = apprenticeship(demos, world(), 100 * FEATURES + 3)
    np.testing.assert_allclose(first.policy, other.policy, atol=1e-6)
    np.testing.assert_allclose(first.weights, 100 * other.weights, rtol=1e-6)


def test_where_no_policy_of_the_mixture_comes_the_policy_is_that_of_the_reward() -> None:
    table = np.zeros((3, 2, 3))
    table[0, :, [0, 1]] = table[1, :, [1, 2]] = table[2, :, [2, 1]] = np.eye(2)
    demos = Demonstrations(np.array([1, 2, 2]), np.array([1, 0, 0]), np.array([0, 3]))
    found = apprenticeship(demos, TabularMDP.from_dense(table, DISCOUNT), np.array([[0.0], [1.0], [3.0]]))
    np.testing.assert_allclose(found.policy, [[0, 1], [0, 1], [1, 0]], atol=1e-6)


def test_iterations_may_run_out() -> None:
    found = apprenticeship(demonstrations(world()), world(), FEATURES, most_iterations=1)
    assert found.outcome is Outcome.OUT_OF_ITERATIONS
    assert found.iterations == found.solutions == 1


def test_what_rounding_does_not_allow_is_said() -> None:
    found = apprenticeship(LUCKY, world(), THREE, margin=1e-300)
    assert found.outcome is Outcome.STALLED


class Stop(Silent):
    """Asks for an end at the second iteration."""

    def update(self, done: int, total: int, note: str = "") -> None:
        if done == 2:
            os.kill(os.getpid(), signal.SIGINT)


def test_what_is_there_is_given_back_when_interrupted() -> None:
    found = apprenticeship(demonstrations(world()), world(), margin=1e-9, progress=Stop())
    assert found.outcome is Outcome.INTERRUPTED
    assert found.iterations == 2
    np.testing.assert_allclose(found.policy.sum(axis=1), 1.0)


def test_features_that_do_not_determine_the_reward_are_noted() -> None:
    doubled = np.column_stack([FEATURES, FEATURES[:, 0]])
    found = apprenticeship(demonstrations(world()), world(), doubled)
    assert found.undetermined.shape == (3, 1)
    assert any("1 of 3 directions" in note for note in found.notes)


def test_bad_input_is_named() -> None:
    demos = demonstrations(world())
    with pytest.raises(InputError, match="variant"):
        apprenticeship(demos, world(), FEATURES, variant="maximum")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="policy"):
        apprenticeship(demos, world(), FEATURES, policy="last")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="margin"):
        apprenticeship(demos, world(), FEATURES, margin=float("nan"))
    with pytest.raises(InputError, match="most_iterations"):
        apprenticeship(demos, world(), FEATURES, most_iterations=0)
