"""The table of planned actions where the world is large: the same as the exact one, within the error that it states."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp import (
    THESIS_SLIP,
    GridWorld,
    ImplicitGrid,
    PlanningWarning,
    PlanStatus,
    plan_subgoals,
    rtdp_subgoals,
    simulate,
)  # fmt: skip
from subgoal.runtime.errors import InputError


def shown(side: int = 40, seed: int = 0) -> tuple[GridWorld, Demonstrations, Candidates]:
    """A walk that is mostly the best one to a goal, and some candidates on it."""
    draw = np.random.default_rng(seed)
    free = draw.random((side, side)) > 0.15
    free[5, 5] = free[20, 25] = True
    grid = GridWorld(free, 0.95, slip=THESIS_SLIP)
    goal, start = grid.state(25, 20), grid.state(5, 5)
    best = plan_subgoals(grid.mdp, [goal], states=np.arange(grid.n_states), relative=True).optimal[:, :, 0]
    demos = simulate(grid.mdp, best / best.sum(axis=1, keepdims=True), steps=60, start=start, seed=seed)
    states = np.unique(np.concatenate([demos.states, demos.final_states]))
    return grid, demos, Candidates.from_states(states[:: max(1, states.size // 12)], coordinates=grid.mdp.coordinates)


@pytest.mark.parametrize("confidence", [1.0, 10.0, 100.0])
def test_no_log_probability_is_further_off_than_is_said(confidence: float) -> None:
    for seed in range(4):
        grid, demos, candidates = shown(seed=seed)
        ours = planned_actions(demos, candidates, grid, confidence=confidence, planner=rtdp_subgoals)
        exact = planned_actions(demos, candidates, grid.mdp, confidence=confidence)
        off = np.abs(ours.rows(0, ours.n_observations) - exact.rows(0, exact.n_observations))
        assert off.max() <= ours.source.largest_error(confidence) + 1e-9
        assert ours.source.largest_error(confidence) <= 0.01
        assert off.max(axis=1).sum() <= ours.source.total_error(confidence) + 1e-9
        assert ours.source.total_error(confidence) <= ours.n_observations * ours.source.largest_error(confidence)
        theta = np.random.default_rng(seed).integers(candidates.n_candidates, size=ours.n_observations)
        assert abs(off[np.arange(off.shape[0]), theta].sum()) <= ours.source.total_error(confidence) + 1e-9


def test_small_grids_are_planned_for_exactly_and_large_ones_in_envelopes() -> None:
    grid, demos, candidates = shown()
    assert planned_actions(demos, candidates, grid).planner.startswith("exact, for the whole world")
    large = ImplicitGrid(40, 40, 0.95, free=grid.free, slip=THESIS_SLIP)
    states = large.states(grid.cells[demos.states])
    moved = Demonstrations.from_arrays(states, demos.actions, demos.offset)
    goals = [large.states(grid.cells[each]) for each in candidates.goal_sets]
    table = planned_actions(moved, Candidates.from_states(goals), large)
    assert table.planner.startswith("real-time dynamic programming in envelopes of up to")
    exact = planned_actions(demos, candidates, grid)
    order = np.argsort([int(each[0]) for each in goals])
    np.testing.assert_array_equal(order, np.arange(len(goals)))
    np.testing.assert_allclose(table.rows(0, 20), exact.rows(0, 20), atol=0.01)


def test_subgoals_are_learned_in_a_world_of_a_billion_cells() -> None:
    grid = ImplicitGrid(31_623, 31_623, 0.97, slip=THESIS_SLIP)
    east, north, stay = (grid.action_names.index(name) for name in ("E", "N", "stay"))
    cells = [(9_000 + k, 9_000) for k in range(25)] + [(9_024, 9_000)] + [(9_024, 9_000 + k) for k in range(1, 26)]
    actions = [east] * 24 + [stay] + [north] * 25 + [stay]
    states = grid.states(np.array(cells[: len(actions)]))
    demos = Demonstrations.from_arrays(states, np.array(actions))
    corner = Candidates.from_states(states[::4], points=grid.cells(states[::4]))
    posterior = subgoal.bnirl(demos, grid, candidates=corner, confidence=30, draws=200, warmup=100, chains=2, seed=0)
    found = subgoal.subgoals(posterior, merge_radius=4)
    assert found.n_subgoals == 2
    top = np.array([each.position for each in found.items[:2]])
    assert (np.linalg.norm(top[:, None] - [[9_024, 9_000], [9_024, 9_024]], axis=2).min(axis=0) <= 4).all()
    assert posterior.settings.planner.startswith("real-time dynamic programming")
    assert "log probabilities are wrong by at most" in posterior.settings.planner


def test_a_budget_is_warned_of_and_loses_nothing() -> None:
    grid, demos, candidates = shown()
    few = partial(rtdp_subgoals, most_states=20)
    with pytest.warns(PlanningWarning, match=r"budget of states.*wrong by up to"):
        table = planned_actions(demos, candidates, grid, planner=few)
    assert table.source.plan.status is PlanStatus.BUDGET
    exact = planned_actions(demos, candidates, grid.mdp)
    off = np.abs(table.rows(0, 30) - exact.rows(0, 30)).max()
    assert 0.01 < off <= table.source.largest_error(10.0)


def test_what_goes_on_from_a_table_plans_the_same_way() -> None:
    grid, demos, candidates = shown()
    table = planned_actions(demos, candidates, grid, planner=rtdp_subgoals)
    again = same_likelihood(table, demos)
    np.testing.assert_array_equal(again.rows(0, 40), table.rows(0, 40))
    posterior = subgoal.sample(table, draws=20, warmup=10, chains=2, thin=1, seed=0)
    here = demos.states[:5]
    policy = subgoal.predictions.predict_mixture(posterior, here)
    exact = subgoal.predictions.predict_mixture(
        subgoal.sample(planned_actions(demos, candidates, grid.mdp), draws=20, warmup=10, chains=2, thin=1, seed=0),
        here,
    )
    np.testing.assert_allclose(policy, exact, atol=0.05)
    lost = subgoal.scores.assignment_loss(table, posterior.best_assignment)
    exactly = subgoal.scores.assignment_loss(planned_actions(demos, candidates, grid.mdp), posterior.best_assignment)
    assert lost == pytest.approx(exactly, abs=2)
    with pytest.raises(InputError, match="planned for in part"):
        subgoal.options.option(posterior, 0)
