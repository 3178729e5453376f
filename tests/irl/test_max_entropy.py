"""Maximum entropy: matched visits, policies that are found, and what is said of bad input."""

from __future__ import annotations

import signal

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.causal_objective import CausalObjective
from subgoal.irl.max_entropy import max_causal_entropy, max_entropy
from subgoal.irl.single_reward import shown
from subgoal.irl.trajectory_objective import TrajectoryObjective
from subgoal.mdp.planners.flow import expected_visits
from subgoal.mdp.planners.soft import soft_value_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.progress import Silent
from tests.irl.entropy_worlds import DISCOUNTS, OBJECTIVES, acted, features_of, tiny, world
from tests.mdp.small_worlds import corridor
from tests.oracles import entropy as oracle


@pytest.mark.parametrize("discount", DISCOUNTS)
def test_visits_of_the_policy_found_match_those_shown_at_the_discount_of_the_world(discount: float) -> None:
    """By default arguments alone: Σ ρ = 1/(1 − γ), ρ flows, and Φᵀρ is what was shown and what the model adds to it."""
    mdp = world(7, discount)
    demonstrations, _ = acted(mdp, trajectories=30, steps=40)
    phi = features_of(mdp, 3)
    found = max_causal_entropy(demonstrations, mdp, phi, objective="feature_matching")
    assert found.outcome is Outcome.CONVERGED
    pairs = shown(demonstrations, mdp)
    start = np.bincount(pairs.starts, minlength=6) / pairs.n_trajectories
    rho = expected_visits(mdp, found.policy, start)
    assert rho.sum() == pytest.approx(1 / (1 - discount), rel=1e-9)
    table = mdp.matrix.toarray().reshape(6, 3, 6)
    np.testing.assert_allclose(rho, start + discount * np.einsum("s,sa,sat->t", rho, found.policy, table), rtol=1e-9)
    matched = np.zeros(3)
    for first, stop in zip(pairs.offset, pairs.offset[1:], strict=False):
        matched += discount ** np.arange(stop - first) @ phi[pairs.states[first:stop]]
        after = table[pairs.states[stop - 1], pairs.actions[stop - 1]]
        matched += discount ** float(stop - first) * phi.T @ expected_visits(mdp, found.policy, after)
    mass = min(1 / (1 - discount), 40)
    np.testing.assert_allclose(phi.T @ rho, matched / 30, rtol=0, atol=2e-6 * mass)


@pytest.mark.parametrize("discount", DISCOUNTS)
@pytest.mark.parametrize("objective", OBJECTIVES)
def test_both_objectives_find_the_policy_of_a_soft_planner(objective: str, discount: float) -> None:
    """From 20,000 pairs; matching features at a discount looks at the first of each trajectory most."""
    mdp = world(8, discount)
    steps = 4 if discount < 0.9 else 40
    demonstrations, reward = acted(mdp, trajectories=20_000 // steps, steps=steps)
    found = max_causal_entropy(demonstrations, mdp, objective=objective)
    assert found.outcome is Outcome.CONVERGED
    assert abs(found.policy - soft_value_iteration(mdp, reward).policy).max() < (
        0.03 if objective == "likelihood" else 0.1
    )


def test_the_likelihood_does_not_look_at_the_order_of_pairs() -> None:
    mdp = world(9, 0.9)
    demonstrations, _ = acted(mdp)
    mixed = np.random.default_rng(0).permutation(demonstrations.n_observations)
    single = Demonstrations.from_arrays(demonstrations.states[mixed], demonstrations.actions[mixed])
    one, other = (max_causal_entropy(each, mdp, l2=0.1) for each in (demonstrations, single))
    np.testing.assert_allclose(one.policy, other.policy, atol=1e-5)


def test_trajectories_find_the_reward_of_their_own_law() -> None:
    """Drawn from the enumerated law itself; 3,000 trajectories of four lengths."""
    mdp, table = tiny()
    reward, generator = np.array([0.3, -0.7, 1.1, 0.6]), np.random.default_rng(0)
    states, actions, finals, offset = [], [], [], [0]
    for length in (2, 3, 4, 5):
        every = list(oracle.trajectories(table, 0, length))
        weight = np.array([chance * np.exp(reward[list(path)].sum()) for path, _, chance in every])
        for k in generator.choice(len(every), 750, p=weight / weight.sum()):
            states += every[k][0][:-1]
            actions += every[k][1]
            finals.append(every[k][0][-1])
            offset.append(len(states))
    demonstrations = Demonstrations(np.array(states), np.array(actions), np.array(offset), final_states=finals)
    found = max_entropy(demonstrations, mdp)
    assert found.outcome is Outcome.CONVERGED
    law = TrajectoryObjective(shown(demonstrations, mdp), mdp, np.eye(4), 1.0, 0.0).expected(reward)[2]
    np.testing.assert_allclose(found.policy[:3], law[:3] / law[:3].sum(axis=1, keepdims=True), atol=0.03)
    assert (found.policy[3] == 0).all()
    assert found.undetermined.shape == (4, 1)
    assert any("lets the demonstrator choose" in note for note in found.notes)


def test_results_say_what_they_are() -> None:
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp)
    phi = features_of(mdp, 3)
    for found in (max_causal_entropy(demonstrations, mdp, phi, l2=0.1), max_entropy(demonstrations, mdp, phi, l2=0.1)):
        assert found.outcome is Outcome.CONVERGED and "Ziebart" in found.reference
        np.testing.assert_array_equal(found.reward, phi @ found.weights)
        assert found.trace.shape == (found.iterations + 1, 6)
        np.testing.assert_allclose(found.trace[-1], found.reward, atol=1e-12)
        np.testing.assert_allclose(found.trace[0], 0)
        assert found.solutions >= found.iterations
        assert found.undetermined.shape == (3, 0)
        np.testing.assert_allclose(found.policy.sum(axis=1), 1, atol=1e-12)
        assert (found.policy[~mdp.available] == 0).all()


def test_l2_is_the_precision_of_a_normal_prior() -> None:
    """At the optimum, the gradient of the log likelihood is l2 times the weights."""
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp)
    found = max_causal_entropy(demonstrations, mdp, l2=2.0, tolerance=1e-8)
    plain = CausalObjective.likelihood(shown(demonstrations, mdp), mdp, np.eye(6), 0.0)
    np.testing.assert_allclose(plain(found.weights)[1], 2.0 * found.weights, atol=1e-5)


def test_constant_rewards_and_dependent_features_are_undetermined() -> None:
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp)
    found = max_causal_entropy(demonstrations, mdp)
    np.testing.assert_allclose(abs(found.undetermined), np.full((6, 1), 6**-0.5), atol=1e-6)
    assert any("1 of 6 directions" in note for note in found.notes)
    one = features_of(mdp, 2)
    twice = max_causal_entropy(demonstrations, mdp, np.column_stack([one, one[:, 0]]))
    np.testing.assert_allclose(abs(twice.undetermined[:, 0]), [0.5**0.5, 0, 0.5**0.5], atol=1e-6)


@pytest.mark.parametrize("kind", ["ending", "parity", "discount 0", "plain"])
def test_no_policy_depends_on_undetermined_directions(kind: str) -> None:
    """An ending is worth 1/(1 − γ) of a constant; where all ways are odd, places may be worth more in turn."""
    mdp = {"ending": world(7, 0.9, ends=True), "parity": corridor(6, 0.9, stay=False), "plain": world(7, 0.9),
           "discount 0": world(7, 0.0)}[kind]  # fmt: skip
    if kind == "parity":
        table = np.zeros((6, 2, 6))
        for s in range(6):
            table[s, 0, (s + 1) % 6] = table[s, 1, (s - 1) % 6] = 1
        mdp = TabularMDP.from_dense(table, 0.9)
    demonstrations, reward = acted(TabularMDP.from_dense(mdp.matrix.toarray().reshape(6, -1, 6), mdp.discount,
                                                         start=np.eye(6)[0]))  # fmt: skip
    free = max_causal_entropy(demonstrations, mdp).undetermined
    assert free.shape == (6, {"ending": 1, "parity": 2, "discount 0": 6, "plain": 1}[kind])
    policy = soft_value_iteration(mdp, reward).policy
    for direction in free.T:
        moved = soft_value_iteration(mdp, reward + 3 * direction).policy
        np.testing.assert_allclose(moved, policy, atol=1e-6)
    if kind == "ending":
        np.testing.assert_allclose(free[-1, 0] / free[:-1, 0], 10, rtol=1e-5)


def test_a_demonstrator_who_never_errs_is_told_of_and_l2_keeps_the_weights_finite() -> None:
    mdp = corridor(5, 0.9)
    demonstrations = Demonstrations(np.array([0, 1, 2, 3]), np.array([1, 1, 1, 2]), np.array([0, 4]))
    found = max_causal_entropy(demonstrations, mdp)
    assert any("hardly errs" in note for note in found.notes)
    assert found.policy[[0, 1, 2, 3], [1, 1, 1, 2]].min() > 0.99
    held = max_causal_entropy(demonstrations, mdp, l2=0.1)
    assert not any("hardly errs" in note for note in held.notes)
    assert np.ptp(held.reward) < np.ptp(found.reward)


@pytest.mark.parametrize("objective", OBJECTIVES)
def test_at_discount_1_a_cost_of_steps_is_where_the_search_begins(objective: str) -> None:
    mdp = world(3, 1.0, ends=True)
    demonstrations, reward = acted(mdp, trajectories=300, steps=1000)
    assert mdp.terminal[demonstrations.final_states].all()
    found = max_causal_entropy(demonstrations, mdp, objective=objective, l2=0.1)
    assert found.outcome is Outcome.CONVERGED
    assert (found.trace[0][:-1] < -1).all()
    if objective == "likelihood":
        assert abs(found.policy - soft_value_iteration(mdp, reward).policy).max() < 0.15


def test_visits_that_no_policy_can_match_are_told_of() -> None:
    """Outcomes were luckier than chance: in the limit of large weights the best policy still visits less."""
    mdp = world(3, 1.0, ends=True)
    demonstrations, _ = acted(mdp, trajectories=300, steps=1000)
    found = max_causal_entropy(demonstrations, mdp, objective="feature_matching", most_iterations=30)
    assert found.outcome is Outcome.OUT_OF_ITERATIONS
    assert any("no policy visits what was shown" in note for note in found.notes)


def test_at_discount_1_features_that_cannot_cost_are_refused() -> None:
    table = np.zeros((3, 2, 3))
    table[0, 0, 0] = table[0, 1, 1] = table[1, 0, 0] = table[1, 1, 2] = 1
    mdp = TabularMDP.from_dense(table, 1.0)
    demonstrations = Demonstrations(np.array([0, 1]), np.array([1, 1]), np.array([0, 2]), final_states=np.array([2]))
    with pytest.raises(InputError, match="a cost in every step"):
        max_causal_entropy(demonstrations, mdp, np.array([[0.0], [0.0], [1.0]]))


class Pressed(Silent):
    """Remembers what it was told, and presses Ctrl-C at step 2 if asked to."""

    def __init__(self, press: bool) -> None:
        self.told: list[tuple[int, int, str]] = []
        self._press = press

    def update(self, done: int, total: int, note: str = "") -> None:
        self.told.append((done, total, note))
        if self._press and done == 2:
            signal.raise_signal(signal.SIGINT)


@pytest.mark.parametrize("method", [max_causal_entropy, max_entropy])
def test_ctrl_c_gives_back_what_was_found_and_limits_are_said(method) -> None:
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp, trajectories=50)
    pressed, heard = Pressed(True), Pressed(False)
    stopped = method(demonstrations, mdp, progress=pressed)
    assert (stopped.outcome, stopped.iterations) == (Outcome.INTERRUPTED, 2)
    limited = method(demonstrations, mdp, progress=heard, most_iterations=3)
    assert (limited.outcome, limited.iterations) == (Outcome.OUT_OF_ITERATIONS, 3)
    assert [done for done, _, _ in heard.told] == [1, 2, 3]
    assert heard.told[0][1] == 3 and "gradient" in heard.told[0][2]


@pytest.mark.parametrize("method", [max_causal_entropy, max_entropy])
@pytest.mark.parametrize(
    ("what", "options"),
    [("l2", {"l2": -1}), ("l2", {"l2": np.nan}), ("tolerance", {"tolerance": 0}), ("tolerance", {"tolerance": np.nan}),
     ("most_iterations", {"most_iterations": 0}), ("features", {"features": np.full((6, 2), np.nan)}),
     ("features", {"features": np.ones((5, 2))}), ("features", {"features": np.ones((6, 0))})],
)  # fmt: skip
def test_bad_settings_are_named(method, what: str, options: dict) -> None:
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp)
    with pytest.raises(InputError, match=what):
        method(demonstrations, mdp, **options)


def test_unknown_objectives_and_discounts_are_named() -> None:
    mdp = world(7, 0.9)
    demonstrations, _ = acted(mdp)
    with pytest.raises(InputError, match="objective"):
        max_causal_entropy(demonstrations, mdp, objective="margin")
    with pytest.raises(InputError, match="discount"):
        max_entropy(demonstrations, mdp, discount=np.nan)


@pytest.mark.parametrize("method", [max_causal_entropy, max_entropy])
def test_steps_that_are_impossible_and_no_demonstrations_are_refused(method) -> None:
    mdp = corridor(5, 0.9)
    with pytest.raises(InputError, match="observation 1"):
        method(Demonstrations(np.array([0, 4]), np.array([1, 1]), np.array([0, 2])), mdp)
    with pytest.raises(InputError, match="demonstrations"):
        method(None, mdp)


def test_trajectories_need_pairs_in_order() -> None:
    mdp = corridor(5, 0.9)
    with pytest.raises(InputError, match="max_causal_entropy, which takes pairs in any order"):
        max_entropy(Demonstrations.from_arrays(np.array([0, 3]), np.array([1, 1])), mdp)


def test_trajectories_too_long_for_a_table_are_refused_before_it_is_made() -> None:
    mdp = corridor(1000, 0.9)
    still = Demonstrations(np.zeros(600_000, int), np.full(600_000, 2), np.array([0, 600_000]))
    with pytest.raises(BudgetError, match="max_causal_entropy"):
        max_entropy(still, mdp, np.arange(1000.0)[:, None])


def test_states_that_such_trajectories_never_see_are_counted() -> None:
    mdp = corridor(9, 0.9)
    demonstrations = Demonstrations(np.array([0, 1]), np.array([1, 0]), np.array([0, 2]), final_states=np.array([0]))
    found = max_entropy(demonstrations, mdp, l2=0.1)
    assert any("in 7 states" in note for note in found.notes)
    np.testing.assert_allclose(found.policy[5], 1 / 3)
