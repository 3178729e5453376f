"""Objectives of maximum entropy: exact gradients, and likelihoods by recursion and enumeration."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.causal_objective import CausalObjective
from subgoal.irl.max_entropy import max_causal_entropy
from subgoal.irl.single_reward import shown
from subgoal.irl.trajectory_objective import TrajectoryObjective
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from tests.irl.entropy_worlds import DISCOUNTS, OBJECTIVES, acted, features_of, tiny, world
from tests.mdp.small_worlds import corridor
from tests.oracles import entropy as oracle


def check_gradient(objective, weights) -> None:
    """Against central differences of two widths, the error of which falls with the fourth power."""
    _, gradient = objective(weights)
    slow = np.empty_like(weights)
    for k, step in enumerate(np.eye(weights.size)):
        wide, narrow = ((objective(weights + h * step)[0] - objective(weights - h * step)[0]) / (2 * h)
                        for h in (2e-3, 1e-3))  # fmt: skip
        slow[k] = (4 * narrow - wide) / 3
    np.testing.assert_allclose(gradient, slow, rtol=0, atol=1e-6 * abs(slow).max() + 1e-9)


@pytest.mark.parametrize("l2", [0.0, 0.7])
@pytest.mark.parametrize("ends", [False, True])
@pytest.mark.parametrize("discount", [*DISCOUNTS[1:], 1.0])
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_causal_gradients_are_exact(objective: str, discount: float, ends: bool, l2: float) -> None:
    if discount == 1 and not ends:
        pytest.skip("no episode ends")
    mdp = world(3, discount, ends=ends)
    demonstrations, reward = acted(mdp)
    phi = np.column_stack([features_of(mdp), reward])
    search = getattr(CausalObjective, objective)(shown(demonstrations, mdp), mdp, phi, l2)
    check_gradient(search, np.array([0.05, -0.1, 0.1, 0.02, 0.9]))


@pytest.mark.parametrize("l2", [0.0, 0.7])
@pytest.mark.parametrize("ends", [False, True])
@pytest.mark.parametrize("discount", [0.0, 0.5, 0.9, 1.0])
def test_trajectory_gradients_are_exact(discount: float, ends: bool, l2: float) -> None:
    mdp = world(3, 0.9, ends=ends)
    demonstrations, _ = acted(mdp)
    check_gradient(
        TrajectoryObjective(shown(demonstrations, mdp), mdp, features_of(mdp), discount, l2),
        np.array([0.5, -0.8, 1.0, 0.3]),
    )  # fmt: skip


@pytest.mark.parametrize("discount", [0.5, 0.9])
def test_the_causal_likelihood_is_that_of_plain_recursion(discount: float) -> None:
    mdp = world(4, discount, ends=True)
    demonstrations, reward = acted(mdp)
    search = CausalObjective.likelihood(shown(demonstrations, mdp), mdp, np.eye(6), 0.0)
    table = mdp.matrix.toarray().reshape(6, 3, 6)
    _, policy = oracle.soft_values(table, (np.repeat(reward[:, None], 3, axis=1), reward), discount, 1.0, 400)
    slow = np.log(policy[demonstrations.states, demonstrations.actions]).sum()
    assert search(reward)[0] == pytest.approx(slow, rel=1e-9)


def without_ends(demonstrations: Demonstrations) -> Demonstrations:
    """The last states forgotten, a stand-in left that cannot follow: state 0 does not lead to itself in ``tiny``."""
    return Demonstrations(demonstrations.states, demonstrations.actions, demonstrations.offset)


@pytest.mark.parametrize("recorded", [True, False])
@pytest.mark.parametrize("discount", [0.6, 1.0])
def test_the_likelihood_of_trajectories_is_that_of_enumeration(discount: float, recorded: bool) -> None:
    mdp, table = tiny()
    reward = np.array([0.3, -0.7, 1.1, 0.6])
    demonstrations = simulate(mdp, np.full((4, 2), 0.5), steps=5, trajectories=12, seed=2)
    lengths = np.diff(demonstrations.offset)
    assert len(set(lengths)) > 2
    if not recorded:
        demonstrations = without_ends(demonstrations)
    slow = 0.0
    for d, (first, stop) in enumerate(zip(demonstrations.offset, demonstrations.offset[1:], strict=False)):
        states, actions = demonstrations.states[first:stop], demonstrations.actions[first:stop]
        final = int(demonstrations.final_states[d]) if recorded else None
        slow += oracle.trajectory_log_probability(table, reward, discount, states, actions, final)
    search = TrajectoryObjective(shown(demonstrations, mdp), mdp, np.eye(4), discount, 0.0)
    assert search.recorded.all() == recorded
    assert search(reward)[0] == pytest.approx(slow, rel=1e-12)


def test_expected_visits_and_actions_of_trajectories_are_those_of_enumeration() -> None:
    mdp, table = tiny()
    reward, discount = np.array([0.3, -0.7, 1.1, 0.6]), 0.8
    demonstrations = simulate(mdp, np.full((4, 2), 0.5), steps=4, trajectories=6, seed=3)
    visits, pairs, log_total = np.zeros(4), np.zeros((4, 2)), 0.0
    for first, stop in zip(demonstrations.offset, demonstrations.offset[1:], strict=False):
        every = list(oracle.trajectories(table, demonstrations.states[first], stop - first))
        fade = discount ** np.arange(stop - first + 1)
        weight = np.array([chance * np.exp(fade @ reward[list(path)]) for path, _, chance in every])
        log_total += np.log(weight.sum())
        for (path, actions, _), share in zip(every, weight / weight.sum(), strict=True):
            np.add.at(visits, list(path), share * fade)
            np.add.at(pairs, (list(path[:-1]), list(actions)), share)
    found = TrajectoryObjective(shown(demonstrations, mdp), mdp, np.eye(4), discount, 0.0).expected(reward)
    assert found[0] == pytest.approx(log_total, rel=1e-12)
    np.testing.assert_allclose(found[1], visits, rtol=1e-12)
    np.testing.assert_allclose(found[2], pairs, rtol=1e-12)


def test_with_single_pairs_both_objectives_are_one() -> None:
    mdp = world(9, 0.9)
    demonstrations, _ = acted(mdp)
    single = Demonstrations.from_arrays(demonstrations.states, demonstrations.actions)
    pairs, weights = shown(single, mdp), np.array([0.2, -0.3, 0.5, 0.1, 0.0, 0.4])
    (one, slope), (other, other_slope) = (
        getattr(CausalObjective, name)(pairs, mdp, np.eye(6), 0.0)(weights) for name in OBJECTIVES
    )  # fmt: skip
    assert one == pytest.approx(other, rel=1e-12)
    np.testing.assert_allclose(slope, other_slope, atol=1e-12)
    found = max_causal_entropy(single, mdp, objective="feature_matching")
    assert any("no trajectory has two pairs" in note for note in found.notes)


def test_where_outcomes_are_certain_trajectories_are_those_of_a_causal_planner_with_the_same_horizon() -> None:
    """π_t(a | s) ∝ exp(V_{t+1}) by soft backups, so that Σ_t log π_t(a_t | s_t) = log P(ζ)."""
    mdp = corridor(4, 0.9)
    reward, states, actions = np.array([0.2, -0.5, 0.9, 0.4]), [1, 2, 3, 3], [1, 1, 2, 0]
    demonstrations = Demonstrations(np.array(states), np.array(actions), np.array([0, 4]), final_states=np.array([2]))
    table = mdp.matrix.toarray().reshape(4, 3, 4)
    ahead, likely = reward.copy(), []
    for s, a in zip(reversed(states), reversed(actions), strict=True):
        likely.append((table[s, a] @ ahead) - np.log(np.exp(table[s] @ ahead).sum()))
        ahead = reward + np.log(np.exp(table @ ahead).sum(axis=1))
    found = TrajectoryObjective(shown(demonstrations, mdp), mdp, np.eye(4), 1.0, 0.0)(reward)[0]
    assert found == pytest.approx(sum(likely), rel=1e-12)


def test_longer_weights_than_doubles_hold_do_no_harm() -> None:
    """Two ways that part for ever, 1,000 steps long: sums that differ by a factor of exp(2,000)."""
    table = np.zeros((3, 2, 3))
    table[0, 0, 1] = table[0, 1, 2] = table[1, :, 1] = table[2, :, 2] = 1
    mdp = TabularMDP.from_dense(table, 0.9)
    demonstrations = Demonstrations(
        np.array([0] + [2] * 999), np.array([1] + [0] * 999), np.array([0, 1000]), final_states=np.array([2])
    )  # fmt: skip
    search = TrajectoryObjective(shown(demonstrations, mdp), mdp, np.eye(3), 1.0, 0.0)
    value, gradient = search(np.array([0.0, 1.0, -1.0]))
    assert value == pytest.approx(-2000 - 999 * np.log(2), rel=1e-12)
    np.testing.assert_allclose(gradient, [0, -1000, 1000], atol=1e-9)
