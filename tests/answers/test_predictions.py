"""Rules of action prediction (thesis 4.5): what each of them is, worked out from the draws."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from scipy.special import log_softmax, logsumexp, softmax

import subgoal
from subgoal.answers.predictions import (
    best_bandwidth,
    predict_literal,
    predict_mixture,
    predict_nearby,
    predict_waypoints,
    waypoints,
)
from subgoal.answers.scores import bits_per_decision
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.bnirl import bnirl
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError
from tests.mdp.small_worlds import corridor
from tests.oracles.subgoal_planning import subgoal_values

pytestmark = pytest.mark.filterwarnings("ignore")
WIDTH = 12


def there_and_back() -> Demonstrations:
    """Three trajectories along a corridor: from 4 up to 9, where they stay once, then down to 1, where they stay."""
    states = np.array([4, 5, 6, 7, 8, 9, 9, 8, 7, 6, 5, 4, 3, 2, 1])
    actions = np.array([1, 1, 1, 1, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 2])
    ends = np.array([1, 1, 1])
    return Demonstrations.from_arrays(
        np.tile(states, 3), np.tile(actions, 3), [0, 15, 30, 45], final_states=ends,
        coordinates=np.arange(WIDTH, dtype=float)[:, None],
    )  # fmt: skip


@pytest.fixture(scope="module")
def world() -> TabularMDP:
    return corridor(WIDTH, 0.9)


@pytest.fixture(scope="module")
def posterior(world: TabularMDP) -> Posterior:
    return bnirl(there_and_back(), world, confidence=5.0, draws=200, warmup=100, thin=2)


def policies(posterior: Posterior, states: np.ndarray) -> np.ndarray:
    """(M, A, G) by dense planning."""
    mdp = posterior.likelihood.source.mdp
    dense = mdp.matrix.toarray().reshape(mdp.n_states, mdp.n_actions, -1), mdp.available, mdp.terminal
    goals = posterior.candidates.goal_sets
    values = [subgoal_values(*dense, g.tolist(), mdp.discount, "continuing")[1] for g in goals]
    return np.stack([softmax(posterior.settings.confidence * q[states], axis=1) for q in values], axis=2)


def test_the_two_goals_are_found(posterior: Posterior) -> None:
    top = np.argsort(-posterior.expected_shares)[:2]
    assert {int(posterior.candidates.goal_sets[g][0]) for g in top} == {1, 9}


def test_mixture_is_the_average_over_the_draws_of_the_predictive(posterior: Posterior) -> None:
    states = np.arange(WIDTH)
    eta, n = posterior.settings.concentration, posterior.n_observations
    prior = np.exp(posterior.candidates.log_prior)
    table = policies(posterior, states)
    draws = posterior.assignments.reshape(-1, n)
    each = [(np.bincount(theta, minlength=prior.size) + eta * prior) / (n + eta) for theta in draws]
    wanted = np.mean([table @ weights for weights in each], axis=0)
    made = predict_mixture(posterior, states)
    np.testing.assert_allclose(made, wanted, atol=1e-6)
    np.testing.assert_allclose(made.sum(axis=1), 1, rtol=1e-12)


def test_the_printed_rule_ignores_the_state(posterior: Posterior) -> None:
    """Σ_a P(z, (s, a)) = CRP(z): one subgoal everywhere, that of the largest cluster (erratum to 4.14)."""
    states = np.arange(WIDTH)
    table = policies(posterior, states)
    size = np.bincount(posterior.best_assignment, minlength=table.shape[2])
    crp = size / (posterior.n_observations - 1 + posterior.settings.concentration)
    for state in states:
        np.testing.assert_allclose((crp * table[state]).sum(axis=0), crp, rtol=1e-12)
    np.testing.assert_allclose(predict_literal(posterior, states), table[:, :, np.argmax(size)], atol=1e-6)


def test_the_printed_rule_takes_the_larger_cluster_where_the_smaller_is_surer(posterior: Posterior) -> None:
    """23 pairs for the goal at 9 and 22 for the goal at 1: from 2, the way to 1 is far surer, and yet 9 is followed."""
    place = {int(members[0]): g for g, members in enumerate(posterior.candidates.goal_sets)}
    split = replace(
        posterior, best_assignment=np.repeat([place[9], place[1]], [23, 22]),
        settings=replace(posterior.settings, confidence=0.3),
        likelihood=posterior.likelihood.at(0.3),
    )  # fmt: skip
    table = policies(split, np.array([2]))[0]
    assert 22 * table[:, place[1]].max() > 23 * table[:, place[9]].max()
    np.testing.assert_allclose(predict_literal(split, [2])[0], table[:, place[9]], atol=1e-6)


def test_nearby_is_the_mixture_for_a_wide_kernel_and_local_for_a_narrow_one(posterior: Posterior) -> None:
    states = np.arange(WIDTH)
    np.testing.assert_allclose(
        predict_nearby(posterior, states, bandwidth=1e6), predict_mixture(posterior, states), atol=1e-9
    )
    near = np.flatnonzero(posterior.demonstrations.states == 3)
    eta, prior = posterior.settings.concentration, np.exp(posterior.candidates.log_prior)
    weights = np.asarray(posterior.shares[near].sum(axis=0)).ravel() + eta * prior
    wanted = policies(posterior, np.array([3]))[0] @ (weights / weights.sum())
    np.testing.assert_allclose(predict_nearby(posterior, [3], bandwidth=0.05)[0], wanted, atol=1e-6)


def test_the_bandwidth_is_the_best_of_those_tried_on_other_trajectories(posterior: Posterior) -> None:
    chosen = best_bandwidth(posterior)
    assert 0.5 <= chosen <= 8
    np.testing.assert_array_equal(predict_nearby(posterior, [3]), predict_nearby(posterior, [3], bandwidth=chosen))


def test_the_bandwidth_is_found_where_no_subgoal_makes_an_action_likely(world: TabularMDP) -> None:
    """Standing still at 5 serves neither 1 nor 9: at confidence 1e4 its probability is 0 in floating point."""
    demos = Demonstrations.from_arrays(
        np.array([2, 4, 5, 6, 8, 3, 5, 7]), np.array([0, 0, 2, 1, 1, 0, 0, 1]), [0, 5, 8],
        coordinates=np.arange(WIDTH, dtype=float)[:, None],
    )  # fmt: skip
    made = bnirl(demos, world, candidates=Candidates.from_states([1, 9]), confidence=1e4, draws=50, warmup=50)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        chosen = best_bandwidth(made)
    dense = world.matrix.toarray().reshape(WIDTH, world.n_actions, WIDTH), world.available, world.terminal
    values = [subgoal_values(*dense, [g], world.discount, "continuing")[1] for g in (1, 9)]
    log_taken = np.stack([log_softmax(1e4 * q, axis=1)[demos.states, demos.actions] for q in values], axis=1)
    apart = demos.trajectory[:, None] != demos.trajectory
    tried, scores = np.geomspace(0.5, 6, 12), []
    for width in tried:
        near = np.exp(-0.5 * ((demos.states[:, None] - demos.states) / width) ** 2) * apart
        weights = near @ made.shares + made.settings.concentration * np.exp(made.candidates.log_prior)
        scores.append(logsumexp(log_taken + np.log(weights / weights.sum(axis=1, keepdims=True)), axis=1).sum())
    assert chosen == pytest.approx(tried[int(np.argmax(scores))])
    assert chosen > 0.5


def test_blocks_change_nothing(posterior: Posterior, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, chosen = predict_nearby(posterior, np.arange(WIDTH), bandwidth=2), best_bandwidth(posterior)
    monkeypatch.setattr("subgoal.answers.predictions.MOST_DISTANCES", 100)
    np.testing.assert_array_equal(predict_nearby(posterior, np.arange(WIDTH), bandwidth=2), whole)
    assert best_bandwidth(posterior) == pytest.approx(chosen)


def test_one_trajectory_is_predicted_from_its_other_observations(world: TabularMDP) -> None:
    lie = {"coordinates": np.arange(WIDTH, dtype=float)[:, None]}
    demos = Demonstrations(np.array([0, 1, 2, 9, 8, 7]), np.array([1, 1, 1, 0, 0, 0]), np.array([0, 6]), **lie)
    made = bnirl(demos, world, candidates=Candidates.from_states([4, 5]), confidence=5.0, draws=50, warmup=50)
    assert 0.5 <= best_bandwidth(made) <= 9
    still = Demonstrations.from_arrays(np.array([3, 3]), np.array([1, 1]), **lie)
    assert best_bandwidth(bnirl(still, world, draws=5, warmup=0)) == 1.0


def test_waypoints_come_in_the_order_of_their_first_use(posterior: Posterior) -> None:
    sequence = [int(posterior.candidates.goal_sets[g][0]) for g in waypoints(posterior)]
    assert sequence[:2] == [9, 1]


@pytest.mark.parametrize(
    "served",
    [
        [1, *[9] * 6, *[1] * 8],  # a stray pair at the start
        [*[9] * 3, 1, *[9] * 3, *[1] * 8],
        [1, 9, 9, 1, *[9] * 3, *[1] * 3, 9, *[1] * 4],
        [*[9] * 3, *[1] * 3, *[9] * 3, *[1] * 2, *[9] * 4],  # rounds: all steps of 9 have a later median
    ],
)  # fmt: skip
def test_neither_stray_pairs_nor_rounds_change_the_order_of_waypoints(posterior: Posterior, served: list[int]) -> None:
    place = {int(members[0]): g for g, members in enumerate(posterior.candidates.goal_sets)}
    changed = replace(posterior, best_assignment=np.tile([place[each] for each in served], 3))
    assert [int(posterior.candidates.goal_sets[g][0]) for g in waypoints(changed)][:2] == [9, 1]


def test_a_trajectory_with_nothing_but_a_stray_pair_has_no_say_in_the_order(posterior: Posterior) -> None:
    place = {int(members[0]): g for g, members in enumerate(posterior.candidates.goal_sets)}
    served = [*[9] * 7, *[1] * 8, *[1, *[9] * 14], *[1, *[9] * 14]]
    changed = replace(posterior, best_assignment=np.array([place[each] for each in served]))
    assert [int(posterior.candidates.goal_sets[g][0]) for g in waypoints(changed)][:2] == [9, 1]


def test_the_follower_turns_at_waypoints(world: TabularMDP) -> None:
    """Only the two goals are candidates, so that the order is certain."""
    demos = there_and_back()
    posterior = bnirl(demos, world, candidates=Candidates.from_states([1, 9]), confidence=20.0, draws=50, warmup=50)
    likely = predict_waypoints(posterior, demos, dwell=1).argmax(axis=1)
    np.testing.assert_array_equal(likely, demos.actions)
    hasty = predict_waypoints(posterior, demos).argmax(axis=1)[:15]
    np.testing.assert_array_equal(np.flatnonzero(hasty != demos.actions[:15]), [5])
    again = Demonstrations.from_arrays(np.array([9, 8, 1, 2]), np.array([0, 0, 1, 1]), [0, 4])
    np.testing.assert_array_equal(predict_waypoints(posterior, again, cyclic=True).argmax(axis=1), [0, 0, 1, 1])
    stays = predict_waypoints(posterior, again)
    np.testing.assert_array_equal(stays.argmax(axis=1), [0, 0, 2, 0])


def test_rules_that_know_the_place_or_the_past_predict_better(posterior: Posterior) -> None:
    demos = posterior.demonstrations
    bits = {
        "mixture": bits_per_decision(predict_mixture(posterior, demos.states), demos.actions),
        "literal": bits_per_decision(predict_literal(posterior, demos.states), demos.actions),
        "waypoints": bits_per_decision(predict_waypoints(posterior, demos, dwell=1), demos.actions),
    }
    assert bits["literal"] < bits["mixture"] < bits["waypoints"] < 0


def test_waypoints_that_share_a_state_are_passed_without_end(world: TabularMDP) -> None:
    demos = Demonstrations(np.array([4, 5, 6, 7]), np.ones(4, int), np.array([0, 4]))
    candidates = Candidates.from_states([[6, 7], [6, 1]])
    made = bnirl(demos, world, candidates=candidates, confidence=0.01, draws=100, warmup=10)
    assert waypoints(made).size == 2
    np.testing.assert_allclose(predict_waypoints(made, demos, cyclic=True).sum(axis=1), 1)


def test_nothing_is_near_where_states_lie_nowhere(world: TabularMDP) -> None:
    made = bnirl(Demonstrations.from_arrays(np.array([1, 2]), np.array([1, 1])), world, draws=5, warmup=0)
    for call in (lambda: predict_nearby(made, [1], bandwidth=1.0), lambda: best_bandwidth(made)):
        with pytest.raises(InputError, match="coordinates"):
            call()


def test_bad_input(posterior: Posterior) -> None:
    with pytest.raises(InputError, match="found 12"):
        predict_mixture(posterior, [12])
    for states in ([[0, 1], [2, 3]], np.empty(0, int)):
        for predict in (predict_mixture, predict_literal, predict_nearby):
            with pytest.raises(InputError, match=r"states: found shape"):
                predict(posterior, states)
    with pytest.raises(InputError, match="bandwidth"):
        predict_nearby(posterior, [1], bandwidth=0)
    with pytest.raises(InputError, match="dwell"):
        predict_waypoints(posterior, posterior.demonstrations, dwell=-1)
    other = subgoal.sample(LogLikelihood.from_table(np.zeros((2, 2))), draws=5, warmup=0)
    with pytest.raises(InputError, match="planned_actions"):
        predict_mixture(other, [0])
    table = np.zeros((2, 1, 2))
    table[0, 0, 1] = 1
    ending = TabularMDP.from_dense(table, 0.9)
    made = bnirl(Demonstrations.from_arrays(np.array([0]), np.array([0])), ending, draws=5, warmup=0)
    with pytest.raises(InputError, match="terminal state 1"):
        predict_mixture(made, [0, 1])
