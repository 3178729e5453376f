"""Grids of any size with walls everywhere, and demonstrations between two random cells of them.

Walls are those of figures 4-1 to 4-3 (two to four straight ones with a gap each in 20 × 20 cells, 7 % of the cells),
each block of 20 × 20 having one of 64 layouts by a hash of its place, so that nothing need be written down.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.grids.layouts import random_walls
from subgoal.mdp.planners.horizon import flat_distance
from subgoal.options.tabular import execute, goal_option
from subgoal.runtime.checks import Bools, Ints
from subgoal.runtime.seeds import stream

DISCOUNT, CONFIDENCE = 0.99, 10.0
SIDE, LAYOUTS = 20, 64
SIZES = {
    2: (10, 10), 3: (40, 25), 4: (100, 100), 5: (400, 250), 6: (1000, 1000), 7: (4000, 2500), 8: (10_000, 10_000),
    9: (40_000, 25_000),
}  # fmt: skip
"""Width and height by the power of ten that is their product."""
WRITTEN_DOWN = 6
"""Up to this power worlds are ``GridWorld``, above it ``ImplicitGrid``."""
FLAT = 0.1
FARTHEST = int(flat_distance(DISCOUNT, CONFIDENCE, nats=FLAT))
"""Cells that a goal may be away along an axis: farther off no two actions differ by ``FLAT`` nats in the likelihood."""
MARGIN = 40
STEPS = 20_000
World = GridWorld | ImplicitGrid


@cache
def layouts() -> Bools:
    """(LAYOUTS, SIDE, SIDE) where one can be."""
    return np.stack([random_walls(SIDE, SIDE, k) for k in range(LAYOUTS)])


def free_cells(seed: int) -> Callable[[Ints, Ints], Bools]:
    """The walls of one draw as a function of x and y."""
    table, mixed = layouts(), np.uint64(seed * 0xC2B2AE3D27D4EB4F % 2**64)

    def free(x: Any, y: Any) -> Bools:
        x, y = np.asarray(x, np.int64), np.asarray(y, np.int64)
        block = (x // SIDE).astype(np.uint64) << np.uint64(32) | (y // SIDE).astype(np.uint64)
        with np.errstate(over="ignore"):
            for factor in (0xBF58476D1CE4E5B9, 0x94D049BB133111EB):
                block = (block ^ mixed ^ (block >> np.uint64(30))) * np.uint64(factor)
        return np.asarray(table[(block >> np.uint64(40)) % np.uint64(LAYOUTS), y % SIDE, x % SIDE])

    return free


def window(seed: int, left: int, low: int, width: int, height: int) -> GridWorld:
    """A part of the plane as a world of its own."""
    y, x = np.mgrid[low : low + height, left : left + width]
    return GridWorld(free_cells(seed)(x, y), discount=DISCOUNT, slip=THESIS_SLIP)


@dataclass(frozen=True, eq=False)
class Case:
    """A draw: a size, walls, and a demonstration in cells (N, 2) and actions (N,)."""

    power: int
    seed: int
    cells: Ints
    actions: Ints

    def world(self) -> World:
        """Made anew, so that what it keeps for later is paid for by each method."""
        width, height = SIZES[self.power]
        if self.power <= WRITTEN_DOWN:
            return window(self.seed, 0, 0, width, height)
        free = free_cells(self.seed)
        return ImplicitGrid(width, height, DISCOUNT, free=free, slip=THESIS_SLIP, name=f"blocks of walls {self.seed}")

    def demonstrations(self, world: World) -> Demonstrations:
        """In states of ``world``."""
        states = world.states(self.cells)
        return Demonstrations(
            states, self.actions, np.array([0, states.size]), final_states=states[-1:], time_unit="step"
        )

    @property
    def n_states(self) -> int:
        """Free cells; in worlds that are not written down as many as the layouts have on average."""
        width, height = SIZES[self.power]
        world = self.world()
        return world.n_states if isinstance(world, GridWorld) else int(width * height * layouts().mean())


def draw(power: int, seed: int) -> Case:
    """Optimal actions from one random cell to another, and a stay on arrival.

    The demonstrator plans exactly in the part of the world that holds both cells and 40 more on every side.
    """
    (width, height), generator = SIZES[power], stream(seed, power)
    while True:
        start = generator.integers((width, height))
        low = np.maximum(start - FARTHEST, 0)
        goal = generator.integers(low, np.minimum(start + FARTHEST + 1, (width, height)))
        free = free_cells(seed)(*np.stack([start, goal]).T)
        if not free.all() or (start == goal).all():
            continue
        corner = np.maximum(np.minimum(start, goal) - MARGIN, 0)
        size = np.minimum(np.maximum(start, goal) + MARGIN + 1, (width, height)) - corner
        part = window(seed, *corner.tolist(), *size.tolist())
        begin, end = part.states(np.stack([start, goal]) - corner)
        option = goal_option(part.mdp, int(end))
        if not option.initiation[begin]:
            continue
        leg = execute(option, part.mdp, start=begin, steps=STEPS, seed=seed)
        cells = part.cells[np.append(leg.states, end)] + corner
        return Case(power, seed, cells, np.append(leg.actions, part.action("stay")))
