"""Worlds told a few states at a time: the same rows as their tables, and bounds that hold whatever the walls."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.grids.grid import ROOM_SLIP, THESIS_SLIP, GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.implicit import ImplicitMDP
from subgoal.mdp.local_world import NumberedWorld, TableWorld, local_world, set_bound
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.horizon import discount_for, flat_distance
from subgoal.mdp.planners.rtdp import rtdp_subgoals
from subgoal.mdp.planners.rtdp_literal import rtdp_literal
from subgoal.runtime.errors import InputError
from tests.mdp.large_worlds import detour, random_grid, random_table


@pytest.mark.parametrize("moves", [4, 8])
@pytest.mark.parametrize("origin", ["lower", "upper"])
@pytest.mark.parametrize("cut", [True, False])
def test_an_implicit_grid_is_the_grid(moves: int, origin: str, cut: bool) -> None:
    free = np.random.default_rng(3).random((9, 13)) > 0.3
    how: dict = {"moves": moves, "origin": origin, "cut_corners": cut, "slip": THESIS_SLIP if moves == 8 else ROOM_SLIP}
    table = GridWorld(free, 0.9, **how)
    for walls in (free, lambda x, y: free[y, x]):
        grid = ImplicitGrid(13, 9, 0.9, free=walls, **how)
        states = grid.states(table.cells)
        rows = grid.rows(states)
        np.testing.assert_array_equal(rows.offset, table.mdp.offset)
        np.testing.assert_array_equal(rows.probability, table.mdp.probability)
        np.testing.assert_array_equal(grid.cells(rows.successor), table.cells[table.mdp.successor])
        np.testing.assert_array_equal(
            grid.reach_bound(states[:4], states[5:9]), table.reach_bound(np.arange(4), np.arange(5, 9))
        )


def test_rows_told_a_few_at_a_time_are_those_of_the_table() -> None:
    for seed in range(30):
        for world in (random_grid(seed), random_table(seed)):
            some = np.random.default_rng(seed).permutation(world.mdp.n_states)[:7]
            rows = world.rows(some)
            a = world.n_actions
            for i, s in enumerate(some):
                for k in range(a):
                    entry = slice(rows.offset[i * a + k], rows.offset[i * a + k + 1])
                    successors, chances = world.mdp.row(int(s), k)
                    np.testing.assert_array_equal(rows.successor[entry], successors)
                    np.testing.assert_array_equal(rows.probability[entry], chances)


def test_no_walls_make_anyone_faster_than_the_bound() -> None:
    for seed in range(60):
        grid = random_grid(seed)
        goals = np.random.default_rng(seed).integers(grid.n_states, size=4)
        exact = plan_subgoals(grid.mdp, goals, convention="absorbing")
        every = np.arange(grid.n_states)
        assert (grid.reach_bound(every, goals) >= exact.value - exact.error_bound).all()
        together = plan_subgoals(grid.mdp, [goals], convention="absorbing")
        assert (set_bound(grid, every, np.unique(goals)) >= together.value[:, 0] - together.error_bound).all()


@pytest.mark.parametrize(("slip", "within"), [(None, 1e-6), (THESIS_SLIP, 1.5)])
def test_in_the_open_the_bound_is_nearly_what_can_be_done(slip: tuple | None, within: float) -> None:
    grid = GridWorld(np.ones((61, 61), bool), 0.99, slip=slip)
    goal = grid.state(30, 30)
    exact = plan_subgoals(grid.mdp, [goal], convention="absorbing", relative=True).value[:, 0]
    bound = grid.reach_bound(np.arange(grid.n_states), np.array([goal]))[:, 0]
    steps_apart = np.log(bound / exact) / -np.log(0.99)
    assert steps_apart.max() < within
    assert steps_apart.min() > -1e-6


@pytest.mark.parametrize("discount", [0.0, 0.01, 0.5, 1.0])
def test_the_bound_at_the_ends_of_the_discount(discount: float) -> None:
    grid = ImplicitGrid(9, 9, discount, slip=THESIS_SLIP)
    bound = grid.reach_bound(grid.states(np.array([[1, 1], [2, 1], [8, 8]])), grid.states(np.array([[1, 1]])))[:, 0]
    assert bound[0] == 1
    assert (np.diff(bound) <= 0).all()
    assert bound[1] >= discount * 0.7 - 1e-12
    if discount == 1:
        np.testing.assert_allclose(bound, 1)


def numbered() -> NumberedWorld:
    """A line of whole numbers without end, on which one slips back now and then."""

    def model(place: int, action: int) -> tuple[list[int], list[float]]:
        step = (-1, 1)[action]
        return [place + step, place], [0.8, 0.2]

    world = NumberedWorld(ImplicitMDP(model, 2, 0.9))
    for place in range(-3, 4):
        world.number(place)
    return world


def test_a_world_told_by_a_function_is_planned_for_by_number() -> None:
    world = numbered()
    start, goal = world.number(0), world.number(3)
    plan = rtdp_subgoals(world, [goal], states=[start], convention="absorbing", tolerance=1e-6)
    ahead = 0.9 * 0.8 / (1 - 0.9 * 0.2)
    np.testing.assert_allclose(plan.value[0, 0], ahead**3, atol=1e-6)
    np.testing.assert_allclose(plan.action_values[0, 1, 0], 0.9 * (0.8 * ahead**2 + 0.2 * ahead**3), atol=1e-6)
    assert world.state(goal) == 3
    with pytest.raises(InputError, match=r"number at index|number: found"):
        world.state(10**6)


def test_a_heuristic_makes_the_envelope_smaller_and_changes_nothing_else() -> None:
    plain, told = numbered(), numbered()
    ahead = 0.9 * 0.8 / (1 - 0.9 * 0.2)

    def known(states: np.ndarray, goals: np.ndarray) -> np.ndarray:
        places = [[told.state(int(s)) for s in each] for each in (states, goals)]
        return ahead ** np.abs(np.subtract.outer(*places))

    told = NumberedWorld(told.mdp, known, told._number, told._states)
    plans = [rtdp_subgoals(w, [w.number(3)], states=[w.number(0)], tolerance=1e-4) for w in (plain, told)]
    assert plans[1].n_inside < plans[0].n_inside
    np.testing.assert_allclose(plans[0].action_values, plans[1].action_values, atol=2e-4)


@pytest.mark.parametrize(
    ("told", "match"),
    [
        (lambda s, g: np.ones(3), "heuristic: found shape"),
        (lambda s, g: np.full((s.size, g.size), np.nan), "heuristic"),
    ],
)
def test_a_heuristic_that_is_none_is_refused(told: object, match: str) -> None:
    world = TableWorld(random_grid(0).mdp, told)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=match):
        rtdp_subgoals(world, [0], states=[1])


@pytest.mark.parametrize("share", [0.0, 0.3, 0.8])
def test_a_heuristic_that_says_too_little_is_refused_where_it_shows(share: float) -> None:
    grid = GridWorld(np.ones((12, 12), bool), 0.95, slip=THESIS_SLIP)

    def low(states: np.ndarray, goals: np.ndarray) -> np.ndarray:
        return np.where(states[:, None] == goals, 1.0, share * grid.reach_bound(states, goals))

    world = TableWorld(grid.mdp, low)
    with pytest.raises(InputError, match=r"heuristic at state \d+, goal \[40\]: found .* wanted at least"):
        rtdp_subgoals(world, [40], states=[70], tolerance=1e-3)


def test_what_is_no_world_is_refused_with_what_to_do() -> None:
    with pytest.raises(InputError, match="NumberedWorld"):
        local_world(numbered().mdp)
    with pytest.raises(InputError, match="mdp: found int"):
        local_world(5)


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"width": 0}, "width"), ({"moves": 5}, "moves"), ({"discount": 1.5}, "discount"), ({"slip": (1.0,)}, "slip"),
        ({"origin": "left"}, "origin"), ({"free": np.ones((2, 3))}, "free: found float64"),
        ({"free": np.ones((2, 3), bool)}, r"booleans of shape \(4, 5\)"), ({"width": 2**40, "height": 2**40}, "cells"),
        ({"free": 3}, "free: found int"),
    ],
)  # fmt: skip
def test_bad_grids_are_named(fields: dict, match: str) -> None:
    with pytest.raises(InputError, match=match):
        ImplicitGrid(**({"width": 5, "height": 4, "discount": 0.9} | fields))


def test_cells_outside_and_in_walls_are_named() -> None:
    grid = ImplicitGrid(5, 4, 0.9, free=lambda x, y: x != 2)
    np.testing.assert_array_equal(grid.states([[4, 3], [0, 1]]), [19, 5])
    with pytest.raises(InputError, match=r"cell at index 1: found \(2, 0\), wanted a free cell"):
        grid.states([[0, 0], [2, 0]])
    with pytest.raises(InputError, match="cells: found float64"):
        grid.states([[0.0, 1.0]])
    with pytest.raises(InputError, match="states at index 0: found 7, wanted a free cell's"):
        grid.check("states", [7])
    bad = ImplicitGrid(5, 4, 0.9, free=lambda x, y: x)
    with pytest.raises(InputError, match="free: found int64"):
        bad.states([[0, 0]])


def test_the_envelope_as_a_world_is_over_at_its_edge() -> None:
    grid = random_grid(5)
    envelope = Envelope(grid)
    envelope.expand(envelope.meet(np.array([0, 3])))
    sub = envelope.sub_world()
    assert sub.n_states == envelope.n_met
    for place in np.flatnonzero(envelope.inside):
        for action in range(grid.n_actions):
            successors, chances = sub.row(int(place), action)
            theirs, theirs_chances = grid.mdp.row(int(envelope.states[place]), action)
            np.testing.assert_array_equal(envelope.states[successors], theirs)
            np.testing.assert_array_equal(chances, theirs_chances)
    np.testing.assert_array_equal(sub.terminal[~envelope.inside], True)


def test_the_printed_form_gives_lower_bounds_stage_by_stage() -> None:
    grid, states, goal = detour()
    exact = plan_subgoals(grid.mdp, [goal], convention="absorbing").value[:, 0]
    for stop in ("one", "all"):
        run = rtdp_literal(grid, goal, states=states, stop=stop, seed=2)
        assert all((stage.value <= exact[stage.states] + 1e-9).all() for stage in run.stages)
        sizes = [stage.states.size for stage in run.stages]
        assert sizes == sorted(sizes)
    for given, match in (({"stop": "never"}, "stop"), ({"states": [10**6]}, "states")):
        with pytest.raises(InputError, match=match):
            rtdp_literal(grid, goal, **({"states": states} | given))


def test_how_far_a_discount_is_felt() -> None:
    for gamma, alpha in ((0.9, 10.0), (0.99, 3.0), (0.999, 30.0)):
        d = flat_distance(gamma, alpha)
        assert alpha * gamma**d * (1 + gamma) == pytest.approx(0.01)
        assert discount_for(d, alpha, nats=0.01) == pytest.approx(gamma, abs=1e-9)
        corridor = GridWorld(np.ones((1, 40), bool), gamma, moves=4)
        q = plan_subgoals(corridor.mdp, [20], states=[10]).action_values[0, :, 0]
        assert q.max() - q[np.isfinite(q)].min() == pytest.approx(gamma**10 * (1 + gamma))
    assert flat_distance(0.5, 1e-6) == 0
    for call in (
        lambda: flat_distance(1.0, 1.0), lambda: flat_distance(0.9, float("nan")), lambda: discount_for(0, 1.0),
        lambda: discount_for(10, 0.4),
    ):  # fmt: skip
        with pytest.raises(InputError):
            call()
