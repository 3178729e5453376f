"""What demonstrators and policies collect, against series written out; and which demonstrations are refused."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.expectations import Demonstrator, optimal_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError
from tests.irl.linear_world import DISCOUNT, FEATURES, TRUE, demonstrations, dense, optimal, visits_by_series, world

TWO = Demonstrations(
    np.array([0, 1, 1, 3]), np.array([2, 1, 2, 2]), np.array([0, 3, 4]), final_states=np.array([2, 4])
)  # fmt: skip


def test_visits_of_a_policy_are_those_of_the_series() -> None:
    generator = np.random.default_rng(0)
    policy = generator.dirichlet(np.ones(3), size=9)
    made = Demonstrator.of(TWO, world(), FEATURES, "held")
    start = np.array([0.5, 0, 0, 0.5, 0, 0, 0, 0, 0])
    np.testing.assert_allclose(made.policy_visits(policy), visits_by_series(dense(), policy, start), atol=1e-12)


def test_visits_of_a_policy_end_in_terminal_states() -> None:
    mdp = world(ending=True)
    policy = np.where(mdp.available, 1 / 3, 0.0)
    made = Demonstrator.of(TWO, mdp, FEATURES, "held")
    start = np.array([0.5, 0, 0, 0.5, 0, 0, 0, 0, 0])
    series = visits_by_series(dense(ending=True), policy, start)
    np.testing.assert_allclose(made.policy_visits(policy), series, atol=1e-12)


def test_demonstrations_that_break_off_stay_where_they_ended() -> None:
    g = DISCOUNT
    wanted = np.zeros(9)
    wanted[[0, 1, 2]] += np.array([1 - g, (1 - g) * (g + g**2), g**3]) / 2
    wanted[[3, 4]] += np.array([1 - g, g]) / 2
    np.testing.assert_allclose(Demonstrator.of(TWO, world(), FEATURES, "held").visits, wanted)


def test_demonstrations_that_end_collect_their_end_once() -> None:
    g = DISCOUNT
    visits = Demonstrator.of(TWO, world(ending=True), FEATURES, "held").visits
    assert visits[4] == pytest.approx((1 - g) * g / 2)


def test_without_a_tail_what_was_not_recorded_collects_nothing() -> None:
    g = DISCOUNT
    found = Demonstrator.of(TWO, world(), FEATURES, "none")
    assert found.visits.sum() == pytest.approx(((1 - g**3) + (1 - g)) / 2)
    assert any("2 of 2 demonstrations break off before 66% of discounted time" in note for note in found.notes)
    assert any("collect nothing" in note for note in found.notes)


def test_only_what_breaks_off_is_noted() -> None:
    found = Demonstrator.of(TWO, world(ending=True), FEATURES, "held")
    assert any("1 of 2 demonstrations break off before 51% of discounted time" in note for note in found.notes)


def test_the_difference_from_the_demonstrator_itself_is_small() -> None:
    mdp = world()
    made = Demonstrator.of(demonstrations(mdp, each=200), mdp, FEATURES, "held")
    assert np.abs(made.difference(made.policy_visits(optimal(mdp, TRUE)))).max() < 0.01


def test_rewards_of_scaled_and_given_features_are_the_same() -> None:
    made = Demonstrator.of(TWO, world(), FEATURES, "held")
    np.testing.assert_allclose(np.ptp(made.features, axis=0), 1.0)
    weights = np.array([0.3, -0.7])
    np.testing.assert_allclose(made.reward(weights), FEATURES @ made.given(weights))


def test_constant_features_are_kept_and_noted() -> None:
    made = Demonstrator.of(TWO, world(), np.column_stack([FEATURES, np.full(9, 5.0)]), "held")
    np.testing.assert_allclose(made.features[:, 2], 1.0)
    assert made.undetermined.shape == (3, 1)
    assert any("1 of 3 directions" in note for note in made.notes)


def test_ties_of_optimal_policies_are_split() -> None:
    np.testing.assert_allclose(optimal_policy(world(), np.zeros(9)), 1 / 3)
    np.testing.assert_allclose(optimal_policy(world(), TRUE), optimal(world(), TRUE))


def test_unordered_pairs_are_refused() -> None:
    pairs = Demonstrations.from_arrays(np.array([0, 1]), np.array([2, 2]))
    with pytest.raises(InputError, match="unordered pairs"):
        Demonstrator.of(pairs, world(), FEATURES, "held")


def test_bad_input_is_named() -> None:
    with pytest.raises(InputError, match="features"):
        Demonstrator.of(TWO, world(), np.where(FEATURES == 3, np.nan, FEATURES), "held")
    with pytest.raises(InputError, match="tail"):
        Demonstrator.of(TWO, world(), FEATURES, "forgotten")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="Demonstrations"):
        Demonstrator.of([], world(), FEATURES, "held")  # type: ignore[arg-type]
    stray = Demonstrations(np.array([0, 5]), np.array([2, 2]), np.array([0, 2]))
    with pytest.raises(InputError, match="observation 1"):
        Demonstrator.of(stray, world(), FEATURES, "held")


def test_discount_one_is_refused() -> None:
    mdp = TabularMDP.from_dense(dense(ending=True), 1.0)
    with pytest.raises(InputError, match="discount"):
        Demonstrator.of(TWO, mdp, FEATURES, "held")
