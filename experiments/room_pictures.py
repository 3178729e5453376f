"""Drawings of Room World in the thesis's colours of walls and rewards, with demonstrations or relevance."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Rectangle

from experiments.common import INK
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.rooms import RoomWorld
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

WALL, NONE, POSITIVE, NEGATIVE, PATH = "#6d1a1a", "#dff3f7", "#1f3b8c", "#f2d024", "#d62728"
RELEVANCE: Any = LinearSegmentedColormap.from_list("relevance", [NONE, POSITIVE])
JITTER = 0.13
"""Of demonstrations, in cells, so that those that lie on each other can be told apart."""


def draw_world(axis: Axes, world: RoomWorld) -> None:
    """Walls, and cells in the colour of the sign of their reward."""
    tints = np.where(world.reward > 0, POSITIVE, np.where(world.reward < 0, NEGATIVE, NONE))
    _cells(axis, world, tints.tolist())


def draw_relevance(axis: Axes, world: RoomWorld, relevance: Floats) -> None:
    """Walls, and cells from light (0) to dark (1)."""
    _cells(axis, world, [RELEVANCE(value) for value in relevance])


def draw_paths(axis: Axes, world: RoomWorld, demos: Demonstrations, count: int, width: float = 0.8) -> None:
    """The first demonstrations, each shifted a little, and a ring where all begin."""
    shift = stream(0, 33).uniform(-JITTER, JITTER, size=(demos.n_trajectories, 2)) if count > 1 else np.zeros((1, 2))
    for k in range(count):
        states: Any = demos.states[demos.offset[k] : demos.offset[k + 1]]
        axis.plot(*(world.grid.cells[states] + 1 + shift[k]).T, color=PATH, lw=width, solid_joinstyle="round")
    axis.plot(*(world.grid.cells[world.start] + 1), "o", ms=7, mfc="white", mec=INK, mew=1.4, zorder=5)


def _cells(axis: Axes, world: RoomWorld, tints: Any) -> None:
    height, width = world.grid.free.shape
    axis.set_facecolor(WALL)
    for (x, y), tint in zip(world.grid.cells.tolist(), tints, strict=True):
        axis.add_patch(Rectangle((x + 0.5, y + 0.5), 1, 1, facecolor=tint, edgecolor="white", lw=0.4))
    axis.set(xlim=(0.5, width + 0.5), ylim=(0.5, height + 0.5), aspect="equal")
    axis.set_xticks([1, 5, 10, 15])
    axis.set_yticks([1, 5, 10, 15])
    axis.grid(visible=False)
