"""What the figures of chapter 3 share: the expert, its 5,000 pairs, and the 0-1 policy loss by both rules for ties."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.room_worlds import (
    ANEW,
    EXPERTS,
    FLOORS,
    ONE_AT_RANDOM,
    PAIRS,
    all_worlds,
    demonstrate,
    losses,
    optimal_of,
    policy_of,
    true_losses,
)
from subgoal.answers.scores import policy_loss
from subgoal.mdp.grids.rooms import room_world
from subgoal.mdp.planners.policy_iteration import policy_iteration

WORLD = room_world("A")
STANDARD_DEVIATION = 13.4
"""Of the lower floor: 5,000 pairs, each wrong with probability 0.0375."""


def test_there_are_twelve_worlds_of_five_rooms() -> None:
    assert len({world.grid.free.tobytes() for world in all_worlds()}) == 12


@pytest.mark.parametrize(("may", "floor"), [(True, 187.5), (False, 250.0)])
def test_the_expert_errs_as_often_as_the_floor_says(may: bool, floor: float) -> None:
    demos = demonstrate(WORLD, 3, may_be_optimal=may)
    assert demos.n_observations == PAIRS and demos.n_trajectories == 100
    assert (demos.states[demos.offset[:-1]] == WORLD.start).all()
    assert floor in FLOORS.values()
    found = true_losses(WORLD, demos)
    assert found.first[0] == pytest.approx(floor, abs=4.5 * STANDARD_DEVIATION)
    assert found.even[0] > 1_000  # most pairs are in the positive room, where the true reward leaves ties


@pytest.mark.parametrize("ties", EXPERTS)
def test_experts_take_optimal_actions(ties: str) -> None:
    optimal, policy = optimal_of(WORLD), policy_of(WORLD, 0, ties)
    if policy.ndim == 2:
        np.testing.assert_array_equal(policy > 0, optimal)
    else:
        assert optimal[np.arange(len(policy)), policy].all()
    assert (optimal.sum(axis=1) > 1).sum() > 30


def test_ties_drawn_once_hang_on_the_seed() -> None:
    assert (policy_of(WORLD, 0, ONE_AT_RANDOM) != policy_of(WORLD, 1, ONE_AT_RANDOM)).any()
    assert (policy_of(WORLD, 0) == policy_of(WORLD, 1)).all()


def test_losses_are_those_of_the_scores() -> None:
    mdp, demos = WORLD.grid.mdp, demonstrate(WORLD, 1, ties=ANEW)
    rewards = np.random.default_rng(0).integers(-2, 3, size=(4, mdp.n_states)) / 3
    rewards[0] = 0
    values = np.stack([policy_iteration(mdp, reward).value for reward in rewards])
    found = losses(mdp, values, demos)
    for k, value in enumerate(values):
        ahead = (mdp.matrix @ value).reshape(mdp.n_states, 4)
        best = ahead >= ahead.max(axis=1, keepdims=True) - 1e-9
        wanted = [policy_loss(best[demos.states], demos.actions, ties=ties) for ties in ("uniform", "first")]
        assert [found.even[k], found.first[k]] == pytest.approx(wanted)
        shares = [
            1 - np.mean([best[s, a] / best[s].sum() for a in demos.actions[demos.states == s]])
            for s in np.unique(demos.states)
        ]
        assert found.by_state[k] == pytest.approx(np.mean(shares))
    assert found.even[0] == pytest.approx(0.75 * PAIRS) and found.by_state[0] == pytest.approx(0.75)
