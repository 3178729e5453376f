"""Apprenticeship learning inside an envelope: the whole world's answer, bounds that hold, what is refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp import THESIS_SLIP, GridWorld, ImplicitGrid, PlanStatus, policy_iteration
from subgoal.optima import Outcome
from subgoal.options.tabular import execute, goal_option
from subgoal.runtime.errors import InputError
from subgoal.single_reward import apprenticeship, apprenticeship_in_envelope

SMALL = GridWorld(np.ones((5, 6), bool), discount=0.9, slip=THESIS_SLIP)
LARGE = GridWorld(np.ones((40, 40), bool), discount=0.9, slip=THESIS_SLIP)


def shown(grid: GridWorld, start: tuple[int, int], goal: tuple[int, int]) -> Demonstrations:
    return execute(goal_option(grid.mdp, grid.state(*goal)), grid.mdp, start=grid.state(*start), steps=60, seed=1)


def indicators(demos: Demonstrations) -> tuple[Callable[[Any], Any], np.ndarray]:
    """One feature for each demonstrated state, and these states."""
    own = np.unique(demos.states)
    return (lambda states: (states[:, None] == own).astype(float)), own


DEMOS = shown(SMALL, (0, 0), (4, 3))
FEATURES, OWN = indicators(DEMOS)


def test_with_the_whole_world_inside_it_is_the_whole_worlds_answer() -> None:
    local = apprenticeship_in_envelope(DEMOS, SMALL, FEATURES, support=OWN, tolerance=1e-10)
    everything = np.arange(SMALL.n_states)
    whole = apprenticeship(DEMOS, SMALL.mdp, FEATURES(everything))
    assert local.status is PlanStatus.SOLVED
    assert sorted(local.states) == everything.tolist()
    assert local.learned.outcome is whole.outcome is Outcome.CONVERGED
    np.testing.assert_allclose(local.learned.weights, whole.weights, atol=1e-9)
    np.testing.assert_allclose(local.policy_at(everything), whole.policy, atol=1e-5)


def test_features_with_bounds_and_no_support_come_to_the_same() -> None:
    def features(states: Any) -> Any:
        return SMALL.cells[states] * 1.0

    bounds = [[0, 0], [5, 4]]
    local = apprenticeship_in_envelope(DEMOS, SMALL, features, feature_bounds=bounds, tolerance=1e-10)
    whole = apprenticeship(DEMOS, SMALL.mdp, SMALL.cells.astype(float))
    np.testing.assert_allclose(local.learned.weights, whole.weights, atol=1e-5)


@pytest.mark.parametrize("most_states", [200, 2000])
def test_bounds_hold_the_exact_values_of_the_learned_reward(most_states: int) -> None:
    demos = shown(LARGE, (6, 20), (26, 24))
    features, own = indicators(demos)
    local = apprenticeship_in_envelope(demos, LARGE, features, support=own, most_states=most_states, tolerance=0.01)
    exact = policy_iteration(LARGE.mdp, features(np.arange(LARGE.n_states)) @ local.learned.weights).value
    low, high = local.bounds.value
    states = local.bounds.states
    np.testing.assert_array_equal(states, np.unique(np.append(demos.states, demos.final_states)))
    assert (low <= exact[states] + 1e-9).all()
    assert (exact[states] <= high + 1e-9).all()
    solved = local.status is PlanStatus.SOLVED
    assert solved == (most_states == 2000) == (local.error_bound <= 0.01)
    assert local.bounds.envelope.n_inside < LARGE.n_states


def test_the_answer_is_of_the_envelope_that_its_own_reward_asks_for() -> None:
    demos = shown(LARGE, (6, 20), (26, 24))
    features, own = indicators(demos)
    local = apprenticeship_in_envelope(demos, LARGE, features, support=own, tolerance=0.01)
    assert local.rounds > 1
    assert local.mdp.n_states == len(local.states) == local.bounds.envelope.n_met
    once = apprenticeship_in_envelope(demos, LARGE, features, support=own, tolerance=0.01, most_rounds=1)
    assert once.rounds == 1
    assert once.mdp.n_states == len(once.states) < once.bounds.envelope.n_met


def test_a_world_of_a_thousand_million_cells() -> None:
    vast = ImplicitGrid(40_000, 25_000, 0.9, slip=THESIS_SLIP)
    here = shown(LARGE, (6, 20), (26, 24))
    corner, cells = np.array([30_000, 20_000]), LARGE.cells
    demos = Demonstrations(
        vast.states(cells[here.states] + corner), here.actions, here.offset,
        final_states=vast.states(cells[here.final_states] + corner),
    )  # fmt: skip
    features, own = indicators(demos)
    local = apprenticeship_in_envelope(demos, vast, features, support=own, tolerance=0.01)
    plain_features, plain_own = indicators(here)
    plain = apprenticeship_in_envelope(here, LARGE, plain_features, support=plain_own, tolerance=0.01)
    np.testing.assert_allclose(local.policy_at(demos.states), plain.policy_at(here.states), atol=1e-6)
    with pytest.raises(InputError, match=r"index 1.*found 3"):
        local.policy_at([demos.states[0], 3])


@pytest.mark.parametrize(
    ("message", "changed"),
    [
        ("found neither", {}),
        ("found both", {"support": OWN, "feature_bounds": [[0.0] * OWN.size, [1.0] * OWN.size]}),
        ("a function", {"support": OWN, "features": np.eye(30)}),
        ("0 outside the support", {"support": OWN[:-1]}),
        ("the least and the most", {"feature_bounds": [[1.0] * OWN.size, [0.0] * OWN.size]}),
        ("within feature_bounds", {"feature_bounds": [[0.0] * OWN.size, [0.5] * OWN.size]}),
        ("wanted .*, 2", {"feature_bounds": [[0.0] * 2, [1.0] * 2]}),
        ("support", {"support": [999]}),
        ("finite", {"support": OWN, "features": lambda states: FEATURES(states) * np.nan}),
        ("shape", {"support": OWN, "features": lambda states: FEATURES(states)[1:]}),
        ("most_rounds", {"support": OWN, "most_rounds": 0}),
        ("demonstrations", {"support": OWN, "demonstrations": "walk"}),
    ],
)
def test_what_is_refused(message: str, changed: dict[str, Any]) -> None:
    given: dict[str, Any] = {"demonstrations": DEMOS, "world": SMALL, "features": FEATURES} | changed
    with pytest.raises(InputError, match=message):
        apprenticeship_in_envelope(**given)
