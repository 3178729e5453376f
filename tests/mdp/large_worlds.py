"""Worlds to plan for in part, and what they are exactly."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.mdp.grids.grid import ROOM_SLIP, THESIS_SLIP, GridWorld
from subgoal.mdp.local_world import TableWorld
from tests.mdp.small_worlds import world

SLIPS: tuple[Any, ...] = (None, THESIS_SLIP, (0.6, 0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.1, 0.15))


def random_grid(seed: int) -> GridWorld:
    """Four to sixteen cells a side, few walls or many, every option drawn."""
    draw = np.random.default_rng(seed)
    size = tuple(int(n) for n in draw.integers(4, 17, size=2))
    free = draw.random(size) >= draw.choice([0.0, 0.2, 0.4])
    free[tuple(int(draw.integers(n)) for n in size)] = True
    moves = int(draw.choice([4, 8]))
    slip = SLIPS[int(draw.integers(3))] if moves == 8 else (None, ROOM_SLIP)[int(draw.integers(2))]
    cells = np.argwhere(free)[:, ::-1]
    terminal = cells[:1] if draw.random() < 0.2 and len(cells) > 2 else ()
    return GridWorld(
        free, float(draw.choice([0.3, 0.9, 0.99])), moves=moves, stay=bool(draw.integers(2)) or moves == 4, slip=slip,
        cut_corners=bool(draw.integers(2)), terminal=terminal,
    )  # fmt: skip


def random_table(seed: int) -> TableWorld:
    """A world that is no grid, without a heuristic, with illegal actions and endings."""
    draw = np.random.default_rng(seed)
    kind = {"n_states": int(draw.integers(3, 40)), "n_actions": int(draw.integers(1, 5)), "illegal": bool(seed % 2)}
    mdp, _ = world(seed, float(draw.choice([0.3, 0.9, 0.99])), terminal=int(draw.integers(2)), **kind)
    return TableWorld(mdp)


def detour() -> tuple[GridWorld, np.ndarray, int]:
    """A wall with a gap near, which the demonstration leaves aside for the way round at the far end; and its goal."""
    free = np.ones((24, 24), bool)
    free[1:, 12] = False
    free[20, 12] = True
    grid = GridWorld(free, 0.95)
    down = [(6, y) for y in range(16, 0, -1)]
    cells = [*down, *[(x, 0) for x in range(6, 19)], *[(18, y) for y in range(1, 17)]]
    return grid, grid.states(np.array(cells)), grid.state(18, 16)
