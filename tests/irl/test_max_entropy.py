"""Maximum entropy: exact gradients, matched visits, likelihoods by enumeration, and what is said of bad input."""

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
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.progress import Silent
from tests.mdp.small_worlds import corridor
from tests.oracles import entropy as oracle

DISCOUNTS = (0.0, 0.5, 0.9, 0.99, 0.999)
OBJECTIVES = ("likelihood", "feature_matching")


def world(seed: int, discount: float, *, ends: bool = False, states: int = 6) -> TabularMDP:
    """Some states with three uncertain actions, one of which is missing somewhere; the last state may be an ending."""
    generator = np.random.default_rng(seed)
    table = generator.dirichlet(np.full(states, 0.4), (states, 3))
    table[1, 2] = 0
    table[table < 1e-3] = 0
    if ends:
        table[-1] = 0
        table[:-1, 0, -1] += 0.3
    sums = table.sum(axis=2, keepdims=True)
    table = np.divide(table, sums, out=np.zeros_like(table), where=sums > 0)
    start = np.full(states, 1 / states)
    if ends:
        start = np.append(np.full(states - 1, 1 / (states - 1)), 0.0)
    return TabularMDP.from_dense(table, discount, start=start)


def acted(mdp: TabularMDP, *, trajectories: int = 8, steps: int = 5, seed: int = 0, size: float = 1.0):
    """What a soft planner shows, and its reward."""
    reward = size * np.random.default_rng(seed + 100).normal(size=mdp.n_states)
    if mdp.discount == 1:
        reward -= 2 + size
    policy = soft_value_iteration(mdp, reward).policy
    return simulate(mdp, policy, steps=steps, trajectories=trajectories, seed=seed), reward


def features_of(mdp: TabularMDP, count: int = 4) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(mdp.n_states, count))


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


def tiny() -> tuple[TabularMDP, np.ndarray]:
    """Four states, two actions, no state leads to itself; the last is an ending."""
    table = np.zeros((4, 2, 4))
    table[0] = [[0, 0.6, 0.4, 0], [0, 0, 1, 0]]
    table[1] = [[0.5, 0, 0.5, 0], [0.2, 0, 0, 0.8]]
    table[2] = [[0.7, 0.3, 0, 0], [0, 0.1, 0, 0.9]]
    return TabularMDP.from_dense(table, 0.9, start=np.array([0.5, 0.3, 0.2, 0])), table


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


def test_the_likelihood_does_not_look_at_the_order_of_pairs() -> None:
    mdp = world(9, 0.9)
    demonstrations, _ = acted(mdp)
    mixed = np.random.default_rng(0).permutation(demonstrations.n_observations)
    single = Demonstrations.from_arrays(demonstrations.states[mixed], demonstrations.actions[mixed])
    one, other = (max_causal_entropy(each, mdp, l2=0.1) for each in (demonstrations, single))
    np.testing.assert_allclose(one.policy, other.policy, atol=1e-5)


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
