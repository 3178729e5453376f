"""The methods of one reward in figures 4-2 and 4-3 and table 4.1: how they are scored, and what is said of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments import fig_4_2, fig_4_3, rival_choices, table_4_1
from experiments.common import Options
from experiments.extreme_cases import FEW, STEP_OF, costs, few_pairs
from experiments.grid_worlds import state, world
from experiments.linear_world import PAIRS, shown
from experiments.rivals import (
    ABBEEL,
    BAYESIAN,
    MARGIN,
    Learned,
    Rival,
    abbeel,
    abbeel_both,
    curve,
    losses_of,
    margin,
    wrong,
)
from subgoal.irl.max_margin import max_margin_planning

CASE = 102


def test_features_have_a_range_of_one_and_the_true_reward_the_loss_of_its_ties() -> None:
    case = shown(CASE)
    np.testing.assert_allclose(np.ptp(case.features, axis=0), 1)
    assert case.demonstrations.n_observations == PAIRS
    assert PAIRS * wrong(case.policy, case.demonstrations) == pytest.approx(case.floor)
    assert (case.demonstrations.states != case.fresh.states).any()


def test_losses_of_a_trace_and_the_first_policy_of_the_least() -> None:
    case = shown(CASE)
    mdp, demos = case.grid.mdp, case.demonstrations
    nothing, learned = np.zeros(mdp.n_states), max_margin_planning(demos, mdp, case.features).trace[-1]
    losses, best = losses_of(np.stack([nothing, learned, learned, nothing]), demos, mdp)
    assert losses[0] == losses[3] == pytest.approx(8 / 9)
    assert losses[1] == losses[2] < losses[0]
    assert wrong(best, demos) == losses.min()
    assert wrong(losses_of(np.stack([learned, nothing]), demos, mdp)[1], demos) == losses[1]


def test_curves_hold_their_last_loss_and_fall_where_asked() -> None:
    policy = np.ones((1, 1))
    learned = Learned(np.array([0.5, 0.2, 0.4]), policy, policy, 3)
    np.testing.assert_allclose(curve(learned, 5, so_far=False), [0.5, 0.2, 0.4, 0.4, 0.4])
    np.testing.assert_allclose(curve(learned, 5, so_far=True), [0.5, 0.2, 0.2, 0.2, 0.2])
    np.testing.assert_allclose(curve(learned, 2, so_far=False), [0.5, 0.2])


@pytest.mark.parametrize("rival", [abbeel, margin])
def test_searches_explain_one_reward(rival: Rival) -> None:
    case = shown(CASE)
    found = rival(case.demonstrations, case.grid.mdp, case.features, 0)
    assert wrong(found.best, case.demonstrations) == found.by_iteration.min() <= 0.2
    assert wrong(found.best, case.fresh) <= 0.25


def test_both_of_abbeels_programs_give_the_better_of_two_policies() -> None:
    for number in (102, 103):
        case = shown(number)
        given = (case.demonstrations, case.grid.mdp, case.features)
        each = [abbeel(*given, variant=variant) for variant in ("max_margin", "projection")]
        both = abbeel_both(*given)
        assert wrong(both.best, given[0]) == min(wrong(one.best, given[0]) for one in each) == both.by_iteration.min()


def test_the_loop_is_cut_into_rounds_that_end_at_home() -> None:
    grid = world(2)
    walk = fig_4_3.fresh_walk(grid, 0)
    cut = fig_4_3.rounds(grid, walk)
    home = state(grid, (10, 1))
    assert cut.n_trajectories == 5
    np.testing.assert_array_equal(cut.states, walk.states)
    ends = cut.offset[1:] - 1
    assert (cut.states[ends] == home).all()
    assert (cut.actions[ends] == grid.action("stay")).all()


def test_verdicts_of_figures_4_2_and_4_3() -> None:
    methods = {"a": {"in_sample": 5.0, "held_out": 9.0}, "b": {"in_sample": 7.0, "held_out": 8.0}}
    methods[fig_4_2.TRUTH] = {"in_sample": 0.0, "held_out": 0.0}
    assert fig_4_2.spread(methods) == {"in_sample": 2.0, "held_out": 1.0}
    shares = {
        fig_4_3.STATES: {"in_sample": 0.04, "held_out": 0.06},
        ABBEEL: {"in_sample": 0.5, "held_out": 0.5, "in_sample, best iteration": 0.19},
        MARGIN: {"in_sample": 0.2, "held_out": 0.5},
    }
    assert fig_4_3.met(shares) == {
        fig_4_3.STATES: {"in_sample": True, "held_out": False}, ABBEEL: False, MARGIN: True,
    }  # fmt: skip


def test_the_least_held_out_loss_is_chosen() -> None:
    rows = [
        {"held_out": 3.0, "in_sample": 1.0},
        {"held_out": 2.0, "in_sample": 5.0},
        {"held_out": 2.0, "in_sample": 4.0},
    ]
    assert rival_choices.least(rows) is rows[2]


def test_the_table_of_the_thesis_adds_up_and_bnirl_is_the_unit() -> None:
    for start, each, iterations, total in table_4_1.THESIS.values():
        assert start + each * iterations == pytest.approx(total, rel=0.005)
    rows = [table_4_1.row_of(name, [(2.0 * k, k, np.ones(4), 7)] * 2) for name, k in (("BNIRL", 1.0), (BAYESIAN, 3.0))]
    first, second = table_4_1.with_ratios(rows)
    assert (first["plans"], second["plans"]) == (7, 1)
    assert set(first["over_bnirl"].values()) == {1.0}
    assert second["over_bnirl"]["iteration"] == 3
    assert second["over_bnirl"]["total"] == pytest.approx(6 / 3)
    assert second["thesis_over_bnirl"]["iterations"] == 10.5


def test_bnirl_solves_one_world_for_each_visited_state_and_explains_many_subgoals() -> None:
    grid, walk, features = few_pairs(1)
    found = costs(grid, walk, features, 1, True, STEP_OF[FEW])
    assert found["BNIRL"]["plans"] == np.unique(walk.states).size
    assert found["BNIRL"]["wrong"] < 0.2 < 0.4 < min(found[name]["wrong"] for name in (ABBEEL, MARGIN, BAYESIAN))


@pytest.mark.t2
def test_quick_runs_say_what_they_should(tmp_path: Path) -> None:
    headline, figure = fig_4_2.experiment(Options(tmp_path, quick=True))
    assert set(headline["spread"]) == {fig_4_2.FIRST_SET, fig_4_2.CHOSEN}
    assert len(figure.axes) == 3
    headline, figure = fig_4_3.experiment(Options(tmp_path, quick=True))
    assert all(headline["met"][name] for name in (ABBEEL, MARGIN, BAYESIAN))
    assert headline["met"][fig_4_3.LASTING] == {"in_sample": True, "held_out": True}
    headline, figure = table_4_1.experiment(Options(tmp_path, quick=True))
    assert [row["method"] for row in headline["rows"]] == list(table_4_1.METHODS)
    assert len(figure.axes) == 7
