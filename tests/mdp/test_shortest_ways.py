"""Shortest ways against a search by dictionary, walls and corners included."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.shortest_ways import shortest_ways, steps_between
from tests.oracles.cells import Room


def ways_between(world, cells):
    """Cells gone through for each pair of cells."""
    pairs = np.stack([world.states(first_last) for first_last in cells])
    return [[tuple(world.cells[s].tolist()) for s in way] for way in shortest_ways(world, pairs)]


@settings(max_examples=80, deadline=None)
@given(st.data())
def test_ways_of_any_world(data) -> None:
    height, width = data.draw(st.integers(1, 6)), data.draw(st.integers(1, 6))
    free = np.array(data.draw(st.lists(st.integers(0, 3), min_size=height * width, max_size=height * width))) > 0
    free[0] = True
    free = free.reshape(height, width)
    moves, corners = data.draw(st.sampled_from([4, 8])), data.draw(st.booleans())
    origin = data.draw(st.sampled_from(["lower", "upper"]))
    world = GridWorld(free, 0.9, moves=moves, cut_corners=corners, origin=origin)
    room = Room(free.tolist(), moves=moves, corners=corners, y_down=origin == "upper")
    cells = [tuple(cell) for cell in world.cells.tolist()]
    asked = data.draw(st.lists(st.tuples(st.sampled_from(cells), st.sampled_from(cells)), min_size=1, max_size=8))
    for pair, way in zip(asked, ways_between(world, asked), strict=True):
        assert way == (room.way(*pair) or [])


def test_ways_keep_to_the_line() -> None:
    world = GridWorld(np.ones((9, 9), bool), 0.9)
    [way] = ways_between(world, [[(0, 0), (8, 4)]])
    assert way == [(0, 0), (1, 1), (2, 1), (3, 2), (4, 2), (5, 3), (6, 3), (7, 4), (8, 4)]
    [way] = ways_between(GridWorld(np.ones((3, 3), bool), 0.9, moves=4), [[(0, 0), (2, 2)]])
    assert way == [(0, 0), (0, 1), (1, 1), (1, 2), (2, 2)]


def test_ways_round_a_wall_and_none() -> None:
    free = np.array([[1, 0, 1, 0], [1, 0, 1, 0], [1, 1, 1, 0], [0, 0, 0, 1]], bool)
    world = GridWorld(free, 0.9)
    there, squeezed, stay = ways_between(world, [[(0, 0), (2, 0)], [(0, 0), (3, 3)], [(2, 1), (2, 1)]])
    assert there == [(0, 0), (0, 1), (1, 2), (2, 1), (2, 0)]
    assert squeezed == [(0, 0), (0, 1), (1, 2), (2, 2), (3, 3)]
    assert stay == [(2, 1)]
    [lost] = ways_between(GridWorld(free, 0.9, cut_corners=False), [[(0, 0), (3, 3)]])
    assert lost == []
    assert shortest_ways(world, np.zeros((0, 2), np.int64)) == []


@pytest.mark.parametrize("moves", [4, 8])
def test_single_steps(moves) -> None:
    free = np.array([[1, 1, 0], [1, 0, 1], [1, 1, 1]], bool)
    world, room = GridWorld(free, 0.9, moves=moves, stay=False), Room(free.tolist(), moves=moves)
    cells = [tuple(cell) for cell in world.cells.tolist()]
    names = [*world.action_names, "stay"]
    for start, cell in enumerate(cells):
        ahead = {there: name for name, there in room.neighbours(cell).items()} | {cell: "stay"}
        found = steps_between(world, np.full(len(cells), start), np.arange(len(cells)))
        assert [names[k] if k >= 0 else None for k in found] == [ahead.get(there) for there in cells]
