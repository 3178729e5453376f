"""Random walls: connected, cells kept free, hanging on the seed alone, of the shape they are said to be."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.grids.layouts import random_walls
from subgoal.runtime.errors import InputError

SEEDS = range(150)


def reached(free):
    """Free cells that are reached from the first with steps to the four neighbours."""
    open_cells = {(x, y) for y, row in enumerate(free.tolist()) for x, is_free in enumerate(row) if is_free}
    queue = [min(open_cells)]
    seen = set(queue)
    while queue:
        x, y = queue.pop()
        for there in ((x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)):
            if there in open_cells - seen:
                seen.add(there)
                queue.append(there)
    return seen, open_cells


@pytest.mark.parametrize(("width", "height"), [(4, 4), (20, 20), (7, 12), (30, 5)])
def test_free_cells_are_connected_and_kept_ones_free(width, height) -> None:
    for seed in SEEDS:
        kept = [(seed % width, seed % height), (0, 0), (width - 1, height - 1), (width // 2, height // 2)]
        free = random_walls(width, height, seed, keep_free=kept)
        assert free.shape == (height, width) and free.dtype == bool
        seen, open_cells = reached(free)
        assert seen == open_cells
        assert set(kept) <= open_cells


def test_walls_stand_inside_and_there_are_some() -> None:
    """With two to four walls: some cells are walls, none lies along the whole edge, no side is closed off."""
    shares = []
    for seed in SEEDS:
        free = random_walls(20, 20, seed)
        assert free[[0, -1]].any(axis=1).all() and free[:, [0, -1]].any(axis=0).all()
        shares.append(1 - free.mean())
    assert min(shares) >= 6 / 400  # one wall of seven cells less its gap, if they lie upon each other
    assert max(shares) <= 4 * 14 / 400  # four of fifteen
    assert len({random_walls(20, 20, seed).tobytes() for seed in SEEDS}) > 0.95 * len(SEEDS)


def test_one_wall_is_straight_with_one_gap() -> None:
    upright = 0
    for seed in SEEDS:
        wall = np.argwhere(~random_walls(12, 9, seed, segments=(1, 1)))
        across, along = (0, 1) if len(set(wall[:, 0].tolist())) == 1 else (1, 0)
        assert len(set(wall[:, across].tolist())) == 1
        upright += across
        places = wall[:, along].tolist()
        length = (9, 12)[along]
        assert len(places) <= 3 * length // 4 - 1
        assert len(places) >= -(-length // 3) - 1
        inside = set(range(places[0], places[-1] + 1)) - set(places)
        assert len(inside) <= 1
        assert 0 < wall[0, across] < (9, 12)[across] - 1
    assert 0.3 * len(SEEDS) < upright < 0.7 * len(SEEDS)


def test_the_seed_decides() -> None:
    np.testing.assert_array_equal(random_walls(9, 8, 3), random_walls(9, 8, 3))
    assert (random_walls(9, 8, 3) != random_walls(9, 8, 4)).any()
    assert random_walls(5, 6, 0, segments=(0, 0)).all()


def test_a_layout_makes_a_world() -> None:
    free = random_walls(10, 10, 1, keep_free=[(0, 0), (9, 9)])
    assert GridWorld(free, 0.99).mdp.n_states == int(free.sum())


@pytest.mark.parametrize(
    ("arguments", "fields", "match"),
    [
        ((3, 9, 0), {}, "width"),
        ((9, 3, 0), {}, "height"),
        ((9.5, 9, 0), {}, "width"),
        ((9, 9, -1), {}, "seed"),
        ((9, 9, 0), {"segments": (4, 2)}, "segments: found .*wanted the fewest, then the most"),
        ((9, 9, 0), {"segments": (-1, 2)}, "segments"),
        ((9, 9, 0), {"segments": 3}, "segments"),
        ((9, 9, 0), {"segments": (1, 2, 3)}, "segments"),
        ((9, 9, 0), {"keep_free": [(0, 0), (9, 0)]}, r"keep_free.*found \(9, 0\), wanted a cell of 9 × 9"),
        ((9, 9, 0), {"keep_free": [(0, -1)]}, "keep_free"),
        ((9, 9, 0), {"keep_free": [(0.5, 1)]}, "keep_free"),
        ((9, 9, 0), {"keep_free": [(float("nan"), 1)]}, "keep_free"),
        ((9, 9, 0), {"keep_free": [(1, 2, 3)]}, "keep_free"),
        ((9, 9, 0), {"keep_free": 7}, "keep_free"),
        ((5, 5, 0), {"segments": (2, 2), "keep_free": np.argwhere(np.ones((5, 5)))}, "no layout in 1000"),
    ],
)  # fmt: skip
def test_bad_layouts(arguments, fields, match) -> None:
    with pytest.raises(InputError, match=match):
        random_walls(*arguments, **fields)
