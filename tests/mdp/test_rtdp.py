"""Planning in an envelope: bounds that hold, the same plan however it is made, a status where it cannot be done."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.planners import growing
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.goals import goal_sets
from subgoal.mdp.planners.growing import Settings
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rtdp import near_groups, rtdp_subgoals
from subgoal.mdp.planners.rtdp_literal import rtdp_literal
from subgoal.runtime.errors import InputError, PlanningError
from tests.mdp.large_worlds import detour, random_grid, random_table

WORLDS = 150
"""Of each of two kinds."""
ROUNDING = 1e-11


def drawn(world: Any, seed: int, n_goals: int = 3, n_states: int = 4) -> tuple[Any, list[np.ndarray], np.ndarray]:
    """The world's table, some goals (the last a set) and some states in which an action can be taken."""
    mdp = world.mdp
    draw = np.random.default_rng(seed)
    goals = [draw.integers(mdp.n_states, size=1) for _ in range(n_goals - 1)] + [draw.integers(mdp.n_states, size=2)]
    return mdp, goals, np.unique(draw.integers(mdp.n_states, size=n_states))


def difference(ours: np.ndarray, exact: np.ndarray) -> np.ndarray:
    """Zero where both are −inf."""
    return np.where(np.isfinite(exact), ours, 0.0) - np.where(np.isfinite(exact), exact, 0.0)


@pytest.mark.parametrize("make", [random_grid, random_table])
@pytest.mark.parametrize("part", range(3))
def test_no_bound_is_violated_after_any_growth_of_the_envelope(make: Any, part: int) -> None:
    for seed in range(part, WORLDS, 3):
        world = make(seed)
        mdp, goals, states = drawn(world, seed)
        convention: Any = ("continuing", "absorbing")[seed // 2 % 2]
        top = 1 / (1 - world.discount) if convention == "continuing" else 1.0
        for sets in (goals[:2], goals[2:]):
            exact = plan_subgoals(mdp, sets, states=states, convention=convention)
            everywhere = plan_subgoals(mdp, sets, convention=convention).value
            settings = Settings(convention, 1e-7 * top, 10_000)
            run = growing.Growing(world, [np.unique(each) for each in sets], states, settings)
            done = False
            while not done:
                done = run.step()
                slack = exact.error_bound + ROUNDING * top
                assert (difference(run.rows[0], exact.action_values) <= slack).all()
                assert (difference(run.rows[1], exact.action_values) >= -slack).all()
                if run.pinned and convention == "absorbing":
                    met = everywhere[run.envelope.states]
                    assert (run.lower <= met + slack).all()
                    assert (run.upper >= met - slack).all()
                if not done:
                    run.grow()
            assert run.answer().status in (PlanStatus.SOLVED, PlanStatus.ROUNDING)


@pytest.mark.parametrize("tolerance", [1e-1, 1e-3, 1e-6])
def test_the_plan_is_as_exact_as_was_asked(tolerance: float) -> None:
    for seed in range(20):
        world = random_grid(seed)
        mdp, goals, states = drawn(world, seed)
        plan = rtdp_subgoals(world, goals, states=states, tolerance=tolerance)
        exact = plan_subgoals(mdp, goals, states=states)
        off = np.abs(difference(plan.action_values, exact.action_values)).max(axis=1)
        assert plan.status is PlanStatus.SOLVED
        assert plan.error_bound <= tolerance
        assert (off <= plan.half_gap + exact.error_bound + ROUNDING / (1 - world.discount)).all()
        assert (np.abs(plan.value - exact.value) <= plan.half_gap + exact.error_bound + ROUNDING).all()


def test_the_printed_form_misses_a_shortcut_that_the_bounds_find() -> None:
    grid, states, goal = detour()
    exact = plan_subgoals(grid.mdp, [goal], states=states).action_values[:, :, 0]
    literal = rtdp_literal(grid, goal, states=states, stop="all")
    assert literal.ended
    hidden = literal.stages[-1].states
    assert grid.state(12, 20) not in hidden
    scale = exact.max() / literal.action_values.max()
    order = np.argsort(np.unique(states))
    missed = exact[np.unique(states, return_index=True)[1]][order] - scale * literal.action_values
    assert missed.max() > 1.0
    bounded = rtdp_subgoals(grid, [goal], states=states, tolerance=1e-3)
    np.testing.assert_allclose(bounded.action_values[:, :, 0], exact, atol=1e-3)
    assert bounded.n_inside < grid.n_states


def test_far_away_a_world_of_a_billion_cells_is_as_a_small_one() -> None:
    small = ImplicitGrid(300, 300, 0.9, slip=THESIS_SLIP)
    large = ImplicitGrid(31_623, 31_623, 0.9, slip=THESIS_SLIP)
    cells = np.array([[140 + k, 150 + k // 3] for k in range(12)])
    plans = [
        rtdp_subgoals(world, world.states(cells[-3:] + shift), states=world.states(cells + shift), tolerance=1e-4)
        for world, shift in ((small, 0), (large, 15_000))
    ]
    assert plans[0].n_inside == plans[1].n_inside < 2_000
    np.testing.assert_array_equal(plans[0].action_values, plans[1].action_values)


def test_what_is_planned_follows_the_demonstration_and_not_the_world() -> None:
    sizes = []
    for side in (100, 1_000, 10_000):
        grid = ImplicitGrid(side, side, 0.95, slip=THESIS_SLIP)
        cells = side // 2 + np.array([[k, 0] for k in range(10)])
        sizes.append(rtdp_subgoals(grid, grid.states(cells[-1:]), states=grid.states(cells)).n_inside)
    assert sizes[0] == sizes[1] == sizes[2]


def test_a_goal_behind_walls_is_worth_nothing_and_known_to_be() -> None:
    free = np.ones((12, 12), bool)
    free[4:9, 4:9] = False
    free[6, 6] = True
    grid = GridWorld(free, 0.9, slip=THESIS_SLIP)
    plan = rtdp_subgoals(grid, [grid.state(6, 6)], states=[grid.state(0, 0)])
    assert plan.status is PlanStatus.SOLVED
    np.testing.assert_allclose(plan.action_values, 0.0, atol=plan.error_bound)


def test_a_budget_gives_the_bounds_so_far_and_says_so() -> None:
    grid = ImplicitGrid(2_000, 2_000, 0.99, slip=THESIS_SLIP)
    states, goal = grid.states([[500, 500]]), grid.states([[560, 520]])
    few = rtdp_subgoals(grid, goal, states=states, most_states=300)
    enough = rtdp_subgoals(grid, goal, states=states)
    assert few.status is PlanStatus.BUDGET
    assert few.n_inside < 2 * 300
    assert enough.status is PlanStatus.SOLVED
    assert few.error_bound > 100 * enough.error_bound
    off = np.abs(few.action_values - enough.action_values)
    assert (off <= few.error_bound + enough.error_bound).all()
    with pytest.raises(PlanningError, match="budget of states"):
        rtdp_subgoals(grid, goal, states=states, most_states=300, allow_unconverged=False)


def test_actions_that_cannot_be_told_apart_are_all_called_best() -> None:
    grid, states, goal = detour()
    exact = plan_subgoals(grid.mdp, [goal], states=states, relative=True).optimal
    loose = rtdp_subgoals(grid, [goal], states=states, most_states=1).optimal
    assert (loose | ~exact).all()
    assert loose.sum() > exact.sum()
    np.testing.assert_array_equal(rtdp_subgoals(grid, [goal], states=states, tolerance=1e-9).optimal, exact)


def test_groups_are_goals_that_lie_near_each_other() -> None:
    grid = ImplicitGrid(1_000, 1_000, 0.99)
    near = [[10 + k, 10] for k in range(12)]
    far = [[900 + k, 900] for k in range(12)]
    sets = goal_sets(grid.states(np.array([x for pair in zip(near, far, strict=True) for x in pair])), grid.check)
    groups = near_groups(grid, [*sets, np.array([1, 2])])
    assert sorted(np.concatenate(groups).tolist()) == list(range(25))
    assert [len(group) for group in groups] == [10, 10, 4, 1]
    assert {int(g) % 2 for g in groups[0]} == {0}
    assert {int(g) % 2 for g in groups[1]} == {1}


@pytest.mark.parametrize(
    ("given", "match"),
    [
        ({"goals": [10**7]}, r"goal 0 at index 0: found 10000000, wanted a free cell"),
        ({"goals": []}, "goals: found none"),
        ({"goals": [[]]}, "goal 0: found no state"),
        ({"states": [-1]}, "states at index 0: found -1"),
        ({"states": [0.5]}, "states: found float64"),
        ({"states": []}, r"states: found"),
        ({"tolerance": float("nan")}, "tolerance: found nan"),
        ({"most_states": 0}, "most_states: found 0"),
        ({"convention": "often"}, "convention: found 'often'"),
        ({"world": ImplicitGrid(9, 9, 1.0)}, "discount: found 1.0, wanted below 1"),
        ({"world": 3}, "mdp: found int, wanted a TabularMDP, GridWorld, ImplicitGrid"),
        ({"backend": "ray"}, "backend: found 'ray'"),
    ],
)
def test_bad_input_is_named(given: dict, match: str) -> None:
    arguments: dict = {"world": ImplicitGrid(1_000, 1_000, 0.9), "goals": [5], "states": [7]} | given
    with pytest.raises(InputError, match=match):
        rtdp_subgoals(arguments.pop("world"), arguments.pop("goals"), **arguments)
