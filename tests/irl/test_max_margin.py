"""Maximum margin planning: the exact optimum, its certificate, the subgradient method, what is returned."""

from __future__ import annotations

import itertools
import os
import signal

import cvxpy
import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.max_margin import max_margin_planning
from subgoal.mdp.simulation import simulate
from subgoal.optima import Outcome
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent
from tests.irl.linear_world import DISCOUNT, FEATURES, TRUE, demonstrations, dense, optimal, visits_by_series, world

SCALED = FEATURES / np.ptp(FEATURES, axis=0)
FEW = Demonstrations(np.array([1, 2, 2, 3, 4]), np.array([2, 2, 2, 2, 1]), np.array([0, 5]))
"""From state 1 to state 4, where it stays; the others are not visited."""
LOSS = np.array([1, 0, 0, 0, 0, 1, 1, 1, 1], float)


def few_visits() -> np.ndarray:
    visits = np.zeros(9)
    for t, s in enumerate(FEW.states):
        visits[s] += (1 - DISCOUNT) * DISCOUNT**t
    visits[4] += DISCOUNT**5
    return visits


def every_policy() -> np.ndarray:
    """(policies, 9) visits from state 1 of all deterministic policies, by dense solves."""
    table, start = dense(), np.eye(9)[1]
    found = []
    for actions in itertools.product(range(3), repeat=9):
        chain = table[np.arange(9), list(actions)]
        found.append(np.linalg.solve(np.eye(9) - DISCOUNT * chain.T, (1 - DISCOUNT) * start))
    return np.array(found)


def value(weights: np.ndarray, strength: float, visits: np.ndarray) -> float:
    """f(w) by the maximum over all policies."""
    best = (visits @ (SCALED @ weights + LOSS)).max()
    return strength / 2 * weights @ weights + best - few_visits() @ SCALED @ weights


@pytest.fixture(scope="module")
def policies() -> np.ndarray:
    return every_policy()


@pytest.mark.parametrize("strength", [0.02, 0.5])
def test_the_exact_optimum_is_that_over_all_policies(strength: float, policies: np.ndarray) -> None:
    """A program with a row for each of the 19683 deterministic policies, by another solver."""
    distinct = np.unique(np.column_stack([policies @ SCALED, policies @ LOSS]).round(12), axis=0)
    w, slack = cvxpy.Variable(2), cvxpy.Variable()
    rows = distinct[:, 2] - (few_visits() @ SCALED - distinct[:, :2]) @ w <= slack
    cvxpy.Problem(cvxpy.Minimize(strength / 2 * cvxpy.sum_squares(w) + slack), [rows]).solve(solver=cvxpy.CLARABEL)
    found = max_margin_planning(FEW, world(), FEATURES, regulariser=strength, gap=1e-9)
    assert found.outcome is Outcome.CONVERGED
    np.testing.assert_allclose(found.weights * np.ptp(FEATURES, axis=0), w.value, atol=1e-4)


@pytest.mark.parametrize(("variant", "gap"), [("cutting_plane", 1e-6), ("subgradient", 1e-2)])
def test_the_gap_is_kept(variant: str, gap: float, policies: np.ndarray) -> None:
    """No weights near the optimum have an objective that is lower by more than the gap."""
    found = max_margin_planning(FEW, world(), FEATURES, variant=variant, gap=gap)
    assert found.outcome is Outcome.CONVERGED
    exact = max_margin_planning(FEW, world(), FEATURES, gap=1e-10)
    scale = np.ptp(FEATURES, axis=0)
    reached = value(found.weights * scale, 0.1, policies)
    assert -1e-9 <= reached - value(exact.weights * scale, 0.1, policies) <= gap
    assert any(f"the objective is {reached:.6g}" in note for note in found.notes)


def test_bounds_of_the_subgradient_method_are_below_the_optimum() -> None:
    exact = objective(max_margin_planning(FEW, world(), FEATURES, gap=1e-10))[0]
    for most in (1, 2, 3, 5, 10, 30, 100):
        found = max_margin_planning(
            FEW, world(), FEATURES, variant="subgradient", step=10.0, most_iterations=most, gap=1e-10
        )
        reached, gap = objective(found)
        assert reached - 1.1 * gap <= exact <= reached + 1e-6


def test_the_subgradient_method_comes_near_the_exact_optimum() -> None:
    exact = max_margin_planning(FEW, world(), FEATURES, gap=1e-9)
    steps = max_margin_planning(FEW, world(), FEATURES, variant="subgradient", most_iterations=2000, gap=1e-9)
    assert 0 <= objective(steps)[0] - objective(exact)[0] < 1e-3


def objective(found) -> tuple[float, float]:
    """What the note says of the objective and its gap."""
    words = found.notes[-1].split()
    return float(words[3].rstrip(",")), float(words[6])


@pytest.mark.parametrize("variant", ["cutting_plane", "subgradient"])
def test_the_policy_of_a_linear_reward_is_recovered_where_it_was_shown(variant: str) -> None:
    start = np.repeat([1, 2, 3], 200)
    demos = simulate(world(), optimal(world(), TRUE), steps=40, trajectories=600, start=start, seed=0)
    found = max_margin_planning(demos, world(), FEATURES, variant=variant)
    shown = np.unique(demos.states)
    assert shown.tolist() == [1, 2, 3, 4]
    np.testing.assert_allclose(found.policy[shown], optimal(world(), TRUE)[shown])


def test_demonstrations_that_visit_every_state_leave_no_loss_and_that_is_noted() -> None:
    found = max_margin_planning(demonstrations(world()), world(), FEATURES)
    np.testing.assert_array_equal(found.weights, 0.0)
    assert any("every state was visited" in note for note in found.notes)
    assert not any("every state" in note for note in max_margin_planning(FEW, world(), FEATURES).notes)


def test_the_policy_is_optimal_for_the_reward_without_the_loss() -> None:
    found = max_margin_planning(FEW, world(), FEATURES)
    np.testing.assert_allclose(found.policy, optimal(world(), found.reward))
    np.testing.assert_allclose(found.reward, FEATURES @ found.weights)
    assert found.trace.shape == (found.iterations, 9)
    np.testing.assert_array_equal(found.trace[0], 0.0)


def test_states_where_a_walk_ended_carry_no_loss() -> None:
    """Walks from 0 that end in 1 and in 8: without weights the worst policy goes to 2 or to 7, no nearer."""
    both = Demonstrations(
        np.array([0, 0, 0, 0]), np.array([1, 2, 1, 0]), np.array([0, 2, 4]), final_states=np.array([1, 8])
    )
    loss = np.array([0, 0, 1, 1, 1, 1, 1, 1, 0], float)
    worst = visits_by_series(dense(), optimal(world(), loss), np.eye(9)[0]) @ loss
    assert objective(max_margin_planning(both, world(), FEATURES, most_iterations=1))[0] == pytest.approx(
        worst, abs=1e-6
    )


def test_of_all_steps_that_of_the_least_objective_is_returned(policies: np.ndarray) -> None:
    found = max_margin_planning(FEW, world(), FEATURES, variant="subgradient", step=10.0, most_iterations=30, gap=1e-9)
    tried = [value(np.linalg.lstsq(SCALED, reward)[0], 0.1, policies) for reward in found.trace]
    assert min(tried) < tried[-1]
    assert value(found.weights * np.ptp(FEATURES, axis=0), 0.1, policies) == pytest.approx(min(tried))


def test_the_extra_is_only_needed_for_the_exact_variant(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subgoal.irl.max_margin.margin_qp", None)
    found = max_margin_planning(FEW, world(), FEATURES, variant="subgradient", gap=0.1)
    assert found.outcome is Outcome.CONVERGED


def test_iterations_may_run_out_and_numbers_end() -> None:
    assert max_margin_planning(FEW, world(), FEATURES, most_iterations=1).outcome is Outcome.OUT_OF_ITERATIONS
    assert max_margin_planning(FEW, world(), regulariser=0.01, gap=1e-300).outcome is Outcome.STALLED


class Stop(Silent):
    """Asks for an end at the second iteration."""

    def update(self, done: int, total: int, note: str = "") -> None:
        if done == 2:
            os.kill(os.getpid(), signal.SIGINT)


def test_what_is_there_is_given_back_when_interrupted() -> None:
    found = max_margin_planning(FEW, world(), variant="subgradient", gap=1e-9, progress=Stop())
    assert found.outcome is Outcome.INTERRUPTED
    assert found.iterations == 2
    np.testing.assert_allclose(found.policy.sum(axis=1), 1.0)


def test_features_that_do_not_determine_the_reward_are_noted() -> None:
    found = max_margin_planning(FEW, world(), np.column_stack([FEATURES, np.ones(9)]))
    assert found.undetermined.shape == (3, 1)
    assert any("1 of 3 directions" in note for note in found.notes)
    assert found.weights[2] == pytest.approx(0.0, abs=1e-9)


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="variant"):
        max_margin_planning(FEW, world(), FEATURES, variant="exact")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="step"):
        max_margin_planning(FEW, world(), FEATURES, variant="subgradient", regulariser=1.0, step=1.5)
    with pytest.raises(InputError, match="regulariser"):
        max_margin_planning(FEW, world(), FEATURES, regulariser=float("nan"))
    with pytest.raises(InputError, match="gap"):
        max_margin_planning(FEW, world(), FEATURES, gap=0.0)
    with pytest.raises(InputError, match="unordered"):
        max_margin_planning(Demonstrations.from_arrays(FEW.states, FEW.actions), world(), FEATURES)
