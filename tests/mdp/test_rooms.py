"""Room World: both layouts as they are drawn, their variants, the slip at walls, and where its optimal policy goes."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from subgoal.mdp.grids.maps import print_map
from subgoal.mdp.grids.rooms import DRAWINGS, SHUT, room_world
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.runtime.errors import InputError

VARIANTS = list(itertools.product(DRAWINGS, (False, True), SHUT))
LAYOUT_A = """
.......#.......
...............
.......#.......
.......#.......
....##.####....
....#.....#....
....#.---......
#.###.---.###.#
++++..---.#....
++++#....S#....
++++####.##....
+++++++#.......
+++++++#.......
+++++++........
+++++++#.......
"""
LAYOUT_B = """
......#........
......#........
...............
......#........
......#........
......#........
...#.####......
...#----.......
...#----####.##
#.##----#S.....
+++.----#......
+++####.#......
+++++#.........
+++++..........
+++++#.........
"""


def marked(world) -> str:
    """The map of a world with its rewards and its start."""
    cells = world.grid.cells
    marks = {"+": cells[world.reward > 0], "-": cells[world.reward < 0], "S": cells[[world.start]]}
    return print_map(world.grid.free, marks=marks)


@pytest.mark.parametrize(("layout", "wanted"), [("A", LAYOUT_A), ("B", LAYOUT_B)])
def test_layouts_as_they_are_drawn(layout: str, wanted: str) -> None:
    assert marked(room_world(layout)) == wanted.removeprefix("\n")


@pytest.mark.parametrize(("layout", "mirror", "doors"), VARIANTS)
def test_every_variant_has_five_rooms_that_are_connected_and_a_free_start(layout, mirror, doors) -> None:
    world = room_world(layout, mirror=mirror, doors=doors)
    assert world.grid.free.shape == (15, 15)
    assert tuple(world.grid.cells[world.start] + 1) == (10, 6)
    reached, queue = {world.start}, [world.start]
    while queue:
        for there in set(world.grid.targets[queue.pop()].tolist()) - reached:
            reached.add(there)
            queue.append(there)
    assert reached == set(range(world.grid.n_states))
    inside = np.concatenate(list(world.rooms.values()))
    assert len(world.rooms) == 5 and len(set(inside.tolist())) == len(inside)
    for name, states in world.rooms.items():
        leads = set(world.grid.targets[states].ravel().tolist()) - set(states.tolist())
        assert leads and not leads & set(inside.tolist()), name
        assert len(leads) == (4 if name == "centre" else 3) * (2 if doors == "double" else 1), name


@pytest.mark.parametrize(("layout", "mirror", "doors"), VARIANTS)
def test_the_lower_left_room_is_positive_and_a_block_of_the_centre_negative(layout, mirror, doors) -> None:
    world = room_world(layout, mirror=mirror, doors=doors, magnitude=2.5)
    np.testing.assert_array_equal(np.flatnonzero(world.reward == 2.5), world.rooms["lower left"])
    negative = np.flatnonzero(world.reward == -2.5)
    assert set(negative.tolist()) <= set(world.rooms["centre"].tolist())
    assert len(negative) == {"A": 9, "B": 16}[layout]
    assert (world.reward[np.setdiff1d(np.arange(world.grid.n_states), world.rooms["lower left"])] <= 0).all()
    assert not world.reward.flags.writeable


def test_the_mirror_changes_x_and_y() -> None:
    drawn, mirrored = room_world("B"), room_world("B", mirror=True)
    np.testing.assert_array_equal(mirrored.grid.free, drawn.grid.free.T)
    cells = {tuple(cell[::-1]) for cell in drawn.grid.cells[drawn.reward < 0].tolist()}
    assert {tuple(cell) for cell in mirrored.grid.cells[mirrored.reward < 0].tolist()} == cells


def test_the_variants_differ() -> None:
    worlds = [room_world(layout, mirror=mirror, doors=doors) for layout, mirror, doors in VARIANTS]
    assert len({world.grid.free.tobytes() for world in worlds}) == len({world.name for world in worlds}) == 12
    for layout in DRAWINGS:
        drawn, moved, double = (room_world(layout, doors=doors).grid.free for doors in SHUT)
        np.testing.assert_array_equal(drawn | moved, double)
        assert (drawn & moved != drawn).any()


def test_the_slip_and_the_walls() -> None:
    """In the open 0.75, 0.1, 0.1, 0.05; what would enter a wall stays: 0.75 + 0.05 straight against one."""
    world = room_world("A")
    grid, mdp = world.grid, world.grid.mdp
    table = mdp.matrix.toarray().reshape(grid.n_states, 4, grid.n_states)
    np.testing.assert_allclose(table.sum(axis=2), 1, atol=1e-12)
    assert grid.action_names == ("N", "E", "S", "W") and mdp.discount == 0.93
    beside_a_wall = grid.state(5, 5)
    for cell, chance in {(5, 6): 0.75, (6, 5): 0.1, (5, 5): 0.05 + 0.1}.items():
        assert table[beside_a_wall, 0, grid.state(*cell)] == pytest.approx(chance)
    middle = grid.state(2, 3)
    for cell, chance in {(3, 3): 0.75, (2, 4): 0.1, (2, 2): 0.1, (2, 3): 0.05}.items():
        assert table[middle, 1, grid.state(*cell)] == pytest.approx(chance)
    corner = grid.state(0, 0)
    assert table[corner, 2, corner] == pytest.approx(0.75 + 0.1 + 0.05)


@pytest.mark.parametrize(("layout", "mirror", "doors"), VARIANTS)
def test_the_optimal_policy_reaches_the_positive_room_and_not_the_upper_right(layout, mirror, doors) -> None:
    """Over the 50 steps of a demonstration; slips make the rest possible, but rare."""
    world = room_world(layout, mirror=mirror, doors=doors)
    mdp = world.grid.mdp
    plan = policy_iteration(mdp, world.reward)
    step = mdp.matrix.toarray().reshape(mdp.n_states, 4, mdp.n_states)[np.arange(mdp.n_states), plan.policy]
    away = np.setdiff1d(np.arange(mdp.n_states), world.rooms["upper right"])
    here = np.eye(mdp.n_states)[world.start]
    for _ in range(50):
        here = here[away] @ step[away]
    assert 1 - here[away].sum() < 1e-3
    assert here[world.rooms["lower left"]].sum() > 0.9


@pytest.mark.parametrize(
    ("fields", "match"),
    [
        ({"layout": "C"}, "layout: found 'C', wanted 'A' or 'B'"),
        ({"doors": "open"}, "doors: found 'open', wanted 'drawn' or 'moved' or 'double'"),
        ({"magnitude": 0.0}, "magnitude"),
        ({"magnitude": float("nan")}, "magnitude"),
        ({"discount": 1.5}, "discount"),
    ],
)
def test_what_is_refused(fields, match) -> None:
    with pytest.raises(InputError, match=match):
        room_world(**fields)
