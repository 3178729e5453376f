"""Grid worlds: transitions against a dictionary filled cell by cell, and what is refused at the door."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.mdp.grids.grid import ROOM_SLIP, THESIS_SLIP, GridWorld
from subgoal.runtime.errors import InputError

ROUNDING = 1e-14
"""A chance of staying is a sum of at most eight numbers, in another order than the oracle's."""
UP = {
    "N": (0, 1), "NE": (1, 1), "E": (1, 0), "SE": (1, -1),
    "S": (0, -1), "SW": (-1, -1), "W": (-1, 0), "NW": (-1, 1), "stay": (0, 0),
}  # fmt: skip
DOWN = {
    "N": (0, -1), "NE": (1, -1), "E": (1, 0), "SE": (1, 1),
    "S": (0, 1), "SW": (-1, 1), "W": (-1, 0), "NW": (-1, -1), "stay": (0, 0),
}  # fmt: skip
AROUND = {4: ["N", "E", "S", "W"], 8: ["N", "NE", "E", "SE", "S", "SW", "W", "NW"]}


def stepped(open_cells, cell, step, corners):
    """Where one step leads, or the same cell."""
    (x, y), (dx, dy) = cell, step
    there = (x + dx, y + dy)
    if there not in open_cells:
        return cell
    if dx and dy and not corners and not ((x + dx, y) in open_cells and (x, y + dy) in open_cells):
        return cell
    return there


def transitions(rows, *, moves, slip, origin, corners, terminal=(), stay=True):
    """{(cell, name): {cell: chance}} for rows of booleans, row 0 being y = 0; nothing for terminal cells."""
    open_cells = {(x, y) for y, row in enumerate(rows) for x, free in enumerate(row) if free}
    steps, names, table = UP if origin == "lower" else DOWN, AROUND[moves], {}
    for cell in sorted(open_cells - set(terminal)):
        for k, name in enumerate(names):
            chances = defaultdict(float, {cell: sum(slip[moves:])})
            for turn, chance in enumerate(slip[:moves]):
                turned = (names[k:] + names[:k])[turn]
                chances[stepped(open_cells, cell, steps[turned], corners)] += chance
            table[cell, name] = {there: chance for there, chance in chances.items() if chance}
        if stay:
            table[cell, "stay"] = {cell: 1.0}
    return table


def table_of(world):
    """The same dictionary out of the world's process; every successor must be listed once."""
    cells, mdp, table = [tuple(cell) for cell in world.cells.tolist()], world.mdp, {}
    for state, cell in enumerate(cells):
        for action, name in enumerate(mdp.action_names):
            successors, chances = mdp.row(state, action)
            assert len(set(successors.tolist())) == len(successors)
            if len(successors):
                assert abs(chances.sum() - 1) <= 1e-12
                table[cell, name] = {cells[s]: p for s, p in zip(successors.tolist(), chances.tolist(), strict=True)}
    return table


def assert_same(found, wanted):
    assert set(found) == set(wanted)
    for key, row in wanted.items():
        assert found[key] == pytest.approx(row, abs=ROUNDING), key


LAYOUTS = {
    "room": [[1, 1, 1, 0], [1, 0, 1, 1], [1, 1, 0, 1]],
    "one cell": [[1]],
    "corridor": [[1, 1, 1, 1]],
    "shaft": [[1], [1], [0], [1]],
    "islands": [[1, 0, 1], [0, 1, 0], [1, 0, 1]],
}
LOPSIDED = {4: (0.4, 0.3, 0.2, 0.1), 8: (0.3, 0.2, 0.15, 0.1, 0.09, 0.08, 0.05, 0.03)}
"""Different chances all round, so that turning the wrong way shows."""


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("moves", [4, 8])
@pytest.mark.parametrize("origin", ["lower", "upper"])
@pytest.mark.parametrize("corners", [True, False])
def test_transitions_cell_by_cell(layout, moves, origin, corners) -> None:
    rows, slip = LAYOUTS[layout], LOPSIDED[moves]
    world = GridWorld(np.array(rows, bool), 0.9, moves=moves, slip=slip, origin=origin, cut_corners=corners)
    assert_same(table_of(world), transitions(rows, moves=moves, slip=slip, origin=origin, corners=corners))


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_transitions_of_any_world(data) -> None:
    height, width = data.draw(st.integers(1, 5)), data.draw(st.integers(1, 5))
    free = np.array(data.draw(st.lists(st.booleans(), min_size=height * width, max_size=height * width)))
    free = free.reshape(height, width)
    free[data.draw(st.integers(0, height - 1)), data.draw(st.integers(0, width - 1))] = True
    moves = data.draw(st.sampled_from([4, 8]))
    weights = np.array(data.draw(st.lists(st.integers(0, 9), min_size=moves, max_size=moves + 1))) + 0.0
    weights[data.draw(st.integers(0, moves - 1))] += 1
    slip = tuple((weights / weights.sum()).tolist())
    cells = np.argwhere(free)[:, ::-1].tolist()
    ends = [tuple(cell) for cell in data.draw(st.lists(st.sampled_from(cells), max_size=2))]
    origin, corners, stay = (
        data.draw(st.sampled_from(["lower", "upper"])),
        data.draw(st.booleans()),
        data.draw(st.booleans()),
    )
    world = GridWorld(
        free, 0.9, moves=moves, slip=slip, origin=origin, cut_corners=corners, terminal=ends, stay=stay
    )  # fmt: skip
    wanted = transitions(
        free.tolist(), moves=moves, slip=slip, origin=origin, corners=corners, terminal=ends, stay=stay
    )
    assert_same(table_of(world), wanted)


def test_the_slips_of_the_thesis() -> None:
    """0.7 and 0.15 to either side with eight directions; 0.75, 0.1, 0.1 and 0.05 to stay with four."""
    for slip, moves, middle, corner in (
        (THESIS_SLIP, 8, {(2, 3): 0.7, (3, 3): 0.15, (1, 3): 0.15}, {(0, 4): 1.0}),
        (
            ROOM_SLIP,
            4,
            {(2, 3): 0.75, (3, 2): 0.1, (1, 2): 0.1, (2, 2): 0.05},
            {(0, 4): 0.9, (1, 4): 0.1},
        ),
    ):
        table = table_of(GridWorld(np.ones((5, 5), bool), 0.9, moves=moves, slip=slip))
        assert table[(2, 2), "N"] == pytest.approx(middle)
        assert table[(0, 4), "N"] == pytest.approx(corner)


def test_without_slip_every_action_does_as_chosen() -> None:
    world = GridWorld(np.ones((3, 3), bool), 0.9)
    assert world.slip == (1.0, 0, 0, 0, 0, 0, 0, 0)
    for name, (dx, dy) in UP.items():
        assert table_of(world)[(1, 1), name] == {(1 + dx, 1 + dy): 1.0}
    assert world.mdp.n_entries == 9 * 9


def test_states_are_the_free_cells_row_by_row() -> None:
    world = GridWorld(np.array([[1, 0, 1], [0, 1, 1]], bool), 0.9, moves=4)
    assert world.cells.tolist() == [[0, 0], [2, 0], [1, 1], [2, 1]]
    assert world.numbers.tolist() == [[0, -1, 1], [-1, 2, 3]]
    assert world.state(2, 0) == 1
    assert world.states([(2, 1), (0, 0)]).tolist() == [3, 0]
    assert world.states(np.zeros((0, 2), int)).tolist() == []
    assert world.mdp.coordinates.tolist() == world.cells.tolist()
    assert world.targets.tolist() == [[0, 0, 0, 0], [3, 1, 1, 1], [2, 3, 2, 2], [3, 3, 1, 2]]
    assert repr(world) == "GridWorld(3 × 2, 4 free cells, 5 actions, discount 0.9)"


def test_coordinates_of_ones_own() -> None:
    places = [[0.5, 0.25], [10.5, 0.25]]
    world = GridWorld(np.array([[1, 0, 1]], bool), 0.9, coordinates=places)
    assert world.mdp.coordinates.tolist() == places
    assert world.cells.tolist() == [[0, 0], [2, 0]]
    for bad in ([[0.0, 1.0]], [0.0, 1.0], [[0, np.nan], [1, 1]], [["a"], ["b"]]):
        with pytest.raises(InputError, match="coordinates"):
            GridWorld(np.array([[1, 0, 1]], bool), 0.9, coordinates=bad)


def test_directions_and_names_go_together() -> None:
    for origin, steps in (("lower", UP), ("upper", DOWN)):
        for moves in (4, 8):
            for stay in (True, False):
                world = GridWorld(np.ones((2, 2), bool), 0.9, moves=moves, stay=stay, origin=origin)
                assert list(world.action_names) == AROUND[moves] + ["stay"] * stay
                assert [tuple(step) for step in world.directions.tolist()] == [steps[n] for n in world.action_names]
                assert [world.action(name) for name in world.action_names] == list(range(moves + stay))
    with pytest.raises(InputError, match=r"action: found 'NE', wanted 'N' or 'E' or 'S' or 'W'\."):
        GridWorld(np.ones((2, 2), bool), 0.9, moves=4, stay=False).action("NE")


def test_terminal_cells_end_the_episode() -> None:
    world = GridWorld(np.ones((2, 3), bool), 1.0, terminal=[(2, 1)])
    assert np.flatnonzero(world.mdp.terminal).tolist() == [world.state(2, 1)]
    assert not world.mdp.available[5].any()
    assert world.mdp.available[:5].all()


def test_the_world_is_a_copy() -> None:
    free, ends = np.ones((2, 2), bool), [(0, 0)]
    world = GridWorld(free, 0.9, terminal=ends)
    free[0, 0] = False
    ends.append((7, 7))
    assert world.n_states == 4
    assert int(world.mdp.terminal.sum()) == 1
    for array in (world.free, world.cells, world.numbers, world.targets, world.directions):
        assert not array.flags.writeable


def test_another_discount_or_map_is_one_replacement_away() -> None:
    world = GridWorld(np.ones((2, 2), bool), 0.9, slip=THESIS_SLIP, terminal=[(1, 1)])
    assert replace(world, discount=0.5).mdp.discount == 0.5
    np.testing.assert_array_equal(replace(world, discount=0.5).mdp.probability, world.mdp.probability)
    assert replace(world, free=np.ones((3, 2), bool)).mdp.n_states == 6


@pytest.mark.parametrize(
    ("cells", "match"),
    [
        ([(0, 0), (1, 0)], r"cell at index 1: found \(1, 0\), which is inside a wall, wanted a free cell"),
        (
            [(0, 0), (0, 2)],
            r"cell at index 1: found \(0, 2\), which is outside the map, wanted x of 0 to 2, y of 0 to 1",
        ),
        ([(-1, 0)], r"cell at index 0: found \(-1, 0\), which is outside"),
        ([(3, 0)], r"outside the map"),
        ([(0, -1)], r"outside the map"),
        ([(2**40, 0)], r"outside the map"),
        ([(0.0, 1.0)], r"cells: found float64"),
        ([0, 1], r"cells: found int64 of shape \(2,\), wanted integers \(M, 2\)"),
        ([(0, 1, 2)], r"cells"),
    ],
)
def test_cells_that_do_not_exist(cells, match) -> None:
    free = np.array([[1, 0, 1], [1, 1, 1]], bool)
    with pytest.raises(InputError, match=match):
        GridWorld(free, 0.9).states(cells)
    with pytest.raises(InputError, match=match):
        GridWorld(free, 0.9, terminal=cells)


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"free": np.zeros((2, 2), bool)}, "free: .* one at least True"),
        ({"free": np.ones((2, 2))}, "free: found float64"),
        ({"free": np.ones(4, bool)}, r"free: found bool of shape \(4,\)"),
        ({"free": np.ones((0, 3), bool)}, "free"),
        ({"free": [[True, False], [True]]}, "free"),
        ({"moves": 6}, "moves: found 6, wanted 4 or 8"),
        ({"moves": "all"}, "moves"),
        ({"moves": True}, "moves"),
        ({"origin": "left"}, "origin: found 'left'"),
        ({"origin": None}, "origin"),
        ({"discount": 1.5}, "discount: found 1.5"),
        ({"discount": float("nan")}, "discount"),
        ({"discount": -0.1}, "discount"),
        ({"discount": None}, "discount"),
        ({"slip": (1.0,)}, "slip: found 1 numbers that sum to 1, wanted 8 probabilities"),
        ({"slip": ROOM_SLIP}, "slip: found 5 numbers"),
        ({"slip": (0.7, 0.15, 0, 0, 0, 0, 0, 0.14)}, r"slip: found 8 numbers that sum to 0\.99"),
        ({"slip": (0.7, 0.15, 0, 0, 0, 0, 0, 0.15 + 1e-8)}, "slip"),
        ({"slip": (1.2, -0.2, 0, 0, 0, 0, 0, 0)}, "slip"),
        ({"slip": (np.nan, 0, 0, 0, 0, 0, 0, 0)}, "slip"),
        ({"slip": 0.7}, "slip"),
        ({"slip": "often"}, "slip"),
        ({"terminal": 3}, "cells"),
        ({"terminal": "end"}, "cells"),
    ],
)
def test_bad_worlds(fields, match) -> None:
    with pytest.raises(InputError, match=match):
        GridWorld(**{"free": np.ones((2, 2), bool), "discount": 0.9, **fields})


def test_an_undiscounted_world_needs_an_end() -> None:
    with pytest.raises(InputError, match="discount"):
        _ = GridWorld(np.ones((2, 2), bool), 1.0).mdp
