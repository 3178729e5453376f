"""Loops of envelopes and grid rows against plain ones, compiled against their Python forms; what groups add up to."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from subgoal._kernels import envelope as loops
from subgoal._kernels.grid_rows import grid_rows, travel_bounds
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.local_world import TableWorld
from subgoal.mdp.planners.compressed import CompressedRows
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.growing import Bounds
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rtdp import half_gap, rtdp_subgoals
from tests.mdp.large_worlds import random_table

LOPSIDED = {4: (0.4, 0.3, 0.15, 0.1, 0.05), 8: (0.3, 0.2, 0.15, 0.1, 0.09, 0.07, 0.04, 0.03, 0.02)}
"""Different chances all round, and one not to move."""
SEEDS = range(40)
ROOM = 8
"""Slots of a hash table that must be searched further than where a state belongs."""


def forms(loop: Any) -> tuple[Any, Any]:
    """Compiled and in Python; the same twice where compilation is off."""
    return loop, getattr(loop, "py_func", loop)


def in_part(seed: int) -> tuple[TableWorld, Envelope, CompressedRows, np.ndarray, np.ndarray]:
    """A world, an envelope of half of it, taken in from the last, its rows, a reward and values (S, 2) of those met."""
    world = random_table(seed)
    draw = np.random.default_rng(seed)
    envelope = Envelope(world)
    some = draw.permutation(world.mdp.n_states)[: world.mdp.n_states // 2 + 1]
    for part in np.array_split(envelope.meet(some)[::-1], 2):
        envelope.expand(part)
    return world, envelope, envelope.table(), draw.random(envelope.n_met), draw.random((envelope.n_met, 2))


def dense(world: TableWorld, envelope: Envelope) -> Iterator[tuple[int, int, np.ndarray]]:
    """State, action and P(· | s, a) by place, of all that can be done inside."""
    for s in np.flatnonzero(envelope.inside):
        for a in range(world.n_actions):
            successors, chances = world.mdp.row(int(envelope.states[s]), a)
            if len(successors):
                row = np.zeros(envelope.n_met)
                row[envelope.places(np.asarray(successors, np.int64))] = chances
                yield int(s), a, row


def greedy(
    world: TableWorld, envelope: Envelope, reward: np.ndarray, value: np.ndarray
) -> dict[int, tuple[float, np.ndarray]]:
    """Of each state inside in which something can be done: the largest (R + γ Σ P v)/(1 − γ p_self), and its row."""
    found: dict[int, tuple[float, np.ndarray]] = {}
    for s, _, row in dense(world, envelope):
        away = np.where(np.arange(row.size) == s, 0.0, row)
        worth = float((reward[s] + world.discount * away @ value) / (1 - world.discount * row[s]))
        if s not in found or worth > found[s][0]:
            found[s] = worth, row
    return found


def test_a_state_has_the_same_slot_in_both_forms() -> None:
    compiled, python = forms(loops.slot_of)
    with np.errstate(over="ignore"):
        for state in [0, 1, 2, 7, 10**9, 2**62, -1, -(2**62)]:
            assert compiled(state, 1023) == python(np.int64(state), 1023)
            assert 0 <= compiled(state, 1023) < 1024


@pytest.mark.parametrize("form", [0, 1])
def test_states_have_places_in_the_order_in_which_they_were_met(form: int) -> None:
    meet, places_of = forms(loops.meet)[form], forms(loops.places_of)[form]
    key, place, known = np.zeros(ROOM, np.int64), np.full(ROOM, loops.EMPTY), np.empty(ROOM, np.int64)
    states, out = np.array([90, 5, 90, 10**12, 5, 33, 44, 90]), np.full(8, -9)
    with np.errstate(over="ignore"):
        count, done = meet(states, 0, key, place, 0, known, out)
        assert (count, done) == (4, 6)
        assert out.tolist() == [0, 1, 0, 2, 1, 3, -9, -9]
        assert known[:4].tolist() == [90, 5, 10**12, 33]
        again, asked = np.empty(5, np.int64), np.array([33, 44, 90, 5, 6])
        places_of(asked, key, place, again)
    assert again.tolist() == [3, -1, 0, 1, -1]


def test_rows_in_order_are_those_of_the_world() -> None:
    for seed in SEEDS:
        world, envelope, table, _, _ = in_part(seed)
        given = (envelope._first[: envelope.n_met], np.maximum(envelope._number[: envelope.n_met], 0))
        for form in forms(loops.rows_in_order):
            for ours, theirs in zip(form(*given, *envelope._whole), table, strict=False):
                np.testing.assert_array_equal(ours, theirs)
        expected = list(dense(world, envelope))
        assert table.row_edge.size - 1 == len(expected)
        for r, (s, _, row) in enumerate(expected):
            assert table.state_edge[s] <= r < table.state_edge[s + 1]
            entries = slice(table.row_edge[r], table.row_edge[r + 1])
            found = np.zeros(envelope.n_met)
            found[table.to[entries]] = table.weight[entries]
            gain = 1 / (1 - world.discount * row[s])
            row[s] = 0.0
            np.testing.assert_allclose(found, world.discount * row * gain, rtol=1e-12)
            np.testing.assert_allclose(table.gain[r], gain, rtol=1e-12)


@pytest.mark.parametrize("form", [0, 1])
def test_everything_inside_is_backed_up_once_and_the_near_first(form: int) -> None:
    inside = np.array([True, False, True, True, False, True])
    order = forms(loops.sweep_order)[form](np.array([3, 1, 0], np.int64), inside)
    assert order.tolist() == [3, 0, 2, 5]


def test_the_best_row_is_that_of_a_plain_search() -> None:
    for seed in SEEDS:
        world, envelope, table, reward, value = in_part(seed)
        rows = [(s, row) for s, _, row in dense(world, envelope)]
        for lane in (0, 1):
            found = greedy(world, envelope, reward, value[:, lane])
            for s in np.flatnonzero(envelope.inside):
                for form in forms(loops.best_row):
                    best, chosen = form(int(s), lane, *table[:5], reward, value)
                    if s not in found:
                        assert (best, chosen) == (-np.inf, -1)
                        continue
                    np.testing.assert_allclose(best, found[int(s)][0], rtol=1e-12)
                    np.testing.assert_array_equal(rows[chosen][1], found[int(s)][1])


@pytest.mark.parametrize("form", [0, 1])
def test_values_inside_solve_their_equation_and_those_at_the_edge_stay(form: int) -> None:
    for seed in SEEDS[::4]:
        world, envelope, table, reward, value = in_part(seed)
        before, order = value.copy(), np.flatnonzero(envelope.inside)
        sweeps = forms(loops.settle_reward)[form](order, 1e-12, 5_000, *table[:5], reward, value)
        assert 1 < sweeps < 5_000
        np.testing.assert_array_equal(value[~envelope.inside], before[~envelope.inside])
        for lane in (0, 1):
            wanted = greedy(world, envelope, reward, value[:, lane])
            for s in order:
                own = wanted[int(s)][0] if int(s) in wanted else reward[s]
                np.testing.assert_allclose(value[s, lane], own, atol=1e-10)


def expected_outside(
    world: TableWorld, envelope: Envelope, roots: np.ndarray, stops: np.ndarray, reward: np.ndarray,
    value: np.ndarray, outside: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """(S,) by solving for how often, discounted, greedy behaviour from the roots is in each state."""
    step = np.zeros((envelope.n_met, envelope.n_met))
    for s, (_, row) in greedy(world, envelope, reward, value).items():
        if not stops[s]:
            step[s] = world.discount * row
    begin = np.bincount(roots, minlength=envelope.n_met).astype(float)
    often = np.linalg.solve(np.eye(len(step)) - step.T, begin)
    return np.asarray(np.where(envelope.inside, 0.0, (often - begin) * outside))


@pytest.mark.parametrize("form", [0, 1])
def test_what_is_expected_outside_is_discounted_and_weighed_by_its_chance(form: int) -> None:
    leaving: Callable[..., None] = forms(loops.leaving)[form]
    seen = 0
    for seed in SEEDS[:: 1 + 3 * form]:
        world, envelope, table, reward, value = in_part(seed)
        draw = np.random.default_rng(seed)
        order = draw.permutation(np.flatnonzero(envelope.inside))
        roots, stops = order[:3], draw.random(envelope.n_met) < 0.2
        outside, excess = draw.random(envelope.n_met), np.zeros(envelope.n_met)
        leaving(
            order, roots, 1, stops, 1e-15, 5_000, *table[:5], reward, envelope.inside, value, outside, excess
        )  # fmt: skip
        wanted = expected_outside(world, envelope, roots, stops, reward, value[:, 1], outside)
        np.testing.assert_allclose(excess, wanted, atol=1e-11)
        seen += wanted.any()
    assert seen > 5


def test_mass_that_is_hardly_there_is_let_go() -> None:
    _, envelope, table, reward, value = in_part(4)
    inside = np.flatnonzero(envelope.inside)
    excess = np.zeros(envelope.n_met)
    loops.leaving(
        inside, inside, 0, np.zeros(envelope.n_met, bool), 1.0, 99, *table[:5], reward, envelope.inside, value,
        np.ones(envelope.n_met), excess,
    )  # fmt: skip
    assert not excess.any()


@pytest.mark.parametrize("moves", [4, 8])
@pytest.mark.parametrize("stay", [False, True])
def test_rows_of_a_grid_are_the_same_in_both_forms(moves: int, stay: bool) -> None:
    free = np.random.default_rng(moves).random((6, 7)) > 0.3
    grid = GridWorld(free, 0.9, moves=moves, slip=LOPSIDED[moves], stay=stay)
    here, over = np.arange(grid.n_states)[::2], np.zeros(grid.n_states, bool)[::2].copy()
    over[3] = True
    target = grid.targets[here].astype(np.int64)
    made = [form(here, target, over, np.array(LOPSIDED[moves]), moves, stay) for form in forms(grid_rows)]
    for ours, theirs in zip(*made, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    sums = np.add.reduceat(np.append(made[0][2], 0.0), made[0][0][:-1]).reshape(here.size, -1)
    np.testing.assert_allclose(sums[~over], 1.0)
    assert np.ptp(made[0][0].reshape(-1)[3 * sums.shape[1] : 4 * sums.shape[1] + 1]) == 0


@pytest.mark.parametrize("moves", [4, 8])
@pytest.mark.parametrize("origin", ["lower", "upper"])
def test_slips_turn_the_same_way_in_a_grid_of_any_size(moves: int, origin: Any) -> None:
    free = np.random.default_rng(moves).random((7, 9)) > 0.3
    how: dict[str, Any] = {"moves": moves, "origin": origin, "slip": LOPSIDED[moves]}
    table, grid = GridWorld(free, 0.9, **how), ImplicitGrid(9, 7, 0.9, free=free, **how)
    offset, successor, probability = grid.rows(grid.states(table.cells))
    np.testing.assert_array_equal(offset, table.mdp.offset)
    np.testing.assert_array_equal(grid.cells(successor), table.cells[table.mdp.successor])
    np.testing.assert_array_equal(probability, table.mdp.probability)


def test_travel_bounds_are_the_least_over_all_slopes() -> None:
    draw = np.random.default_rng(0)
    x, y, goal_x, goal_y = draw.integers(0, 30, (4, 12)).astype(float)
    slope_x, slope_y = np.abs(draw.normal(size=(2, 5)))
    each = slope_x * np.subtract.outer(goal_x, x)[..., None] + slope_y * np.subtract.outer(goal_y, y)[..., None]
    wanted = np.exp(-np.maximum(each.max(axis=2), 0)).T
    assert (wanted == 1).any()
    for form in forms(travel_bounds):
        out = np.empty((12, 12))
        form(x, y, goal_x, goal_y, slope_x, slope_y, out)
        np.testing.assert_allclose(out, wanted, rtol=1e-12)


def bounds(gap: np.ndarray, status: PlanStatus) -> Bounds:
    """Of two states, three actions and one goal: action values that are ``gap`` (2, 3) apart, values that meet."""
    rows = np.stack([np.zeros((2, 3, 1)), gap[:, :, None]])
    rows[:, 1, 2] = -np.inf
    return Bounds(np.ones((2, 2, 1)), rows, status, 5, 9, 1, 1, 1)


def test_the_error_is_half_of_the_largest_gap_of_any_action() -> None:
    found = half_gap(bounds(np.array([[0.1, 0.2, 0.6], [0.4, 0.1, 9.0]]), PlanStatus.SOLVED))
    np.testing.assert_allclose(found[:, 0], [0.3, 0.2])
    wide = bounds(np.zeros((2, 3)), PlanStatus.SOLVED)._replace(value=np.array([[[0.0], [1.0]], [[3.0], [1.0]]]))
    np.testing.assert_allclose(half_gap(wide)[:, 0], [1.5, 0.0])


def test_what_one_group_could_not_do_is_told_of_all() -> None:
    grid = ImplicitGrid(2_000, 2_000, 0.99)
    goals = grid.states([*([502, 500 + k] for k in range(10)), [560, 520]])
    plan = rtdp_subgoals(grid, goals, states=grid.states([[500, 500]]), most_states=1_500)
    gap = plan.half_gap[0] <= plan.tolerance
    assert gap.tolist() == [True] * 10 + [False]
    assert plan.status is PlanStatus.BUDGET
