"""Mice in a labyrinth (Rosenberg et al., eLife 2021) as a discrete world: the maze, its walks, and Markov chains.

The maze is a binary tree of corridors. Node 0 is the first junction, n leads to 2n + 1 and 2n + 2, nodes 63 to 126 are
dead ends, and behind node 0 lies the home cage, 127.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from subgoal.demonstrations.readers.labyrinth import BACK, EXIT, LEFT, RIGHT, read_labyrinth
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.cloning import counted
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, Ints

WALKS, NODES = "node_visits.csv", "maze_nodes.csv"
HOME = EXIT
N_STATES, N_ACTIONS, FIRST_DEAD_END = HOME + 1, 3, HOME // 2


@dataclass(frozen=True, eq=False)
class Maze:
    """Where the nodes lie (128, 2), and which of them has the water."""

    places: Floats
    water: int


def read_maze(folder: Path) -> Maze:
    """Columns node, x, y and is_water_port."""
    with (folder / NODES).open(newline="") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: int(row["node"]))
    places = np.array([[float(row["x"]), float(row["y"])] for row in rows])
    return Maze(places, next(int(row["node"]) for row in rows if row["is_water_port"] == "1"))


def world(discount: float, maze: Maze) -> TabularMDP:
    """Every action leads where it should. Home is terminal: no decision was recorded there, a bout is over."""
    transition = np.zeros((N_STATES, N_ACTIONS, N_STATES))
    for node in range(HOME):
        if node < FIRST_DEAD_END:
            transition[node, LEFT, 2 * node + 1] = 1
            transition[node, RIGHT, 2 * node + 2] = 1
        transition[node, BACK, (node - 1) // 2 if node else HOME] = 1
    names = ("left", "right", "back")
    return TabularMDP.from_dense(transition, discount, coordinates=maze.places, action_names=names)


def walks(folder: Path, session: str, maze: Maze) -> Demonstrations:
    """The bouts of one session, with coordinates."""
    demos = read_labyrinth(folder / WALKS, session=session)
    return replace(demos, coordinates=maze.places, names=("x", "y"))


def water_deliveries(folder: Path, session: str) -> int:
    """How often a session's mouse got water; the learner is not told."""
    with (folder / WALKS).open(newline="") as file:
        return sum(int(row["rewards"]) for row in csv.DictReader(file) if row["session"] == session)


def some_bouts(demos: Demonstrations, chosen: Sequence[int] | Ints) -> Demonstrations:
    """Those bouts, in the order given."""
    bouts = np.asarray(chosen)
    rows = np.concatenate([np.arange(demos.offset[k], demos.offset[k + 1]) for k in bouts])
    return replace(
        demos,
        states=demos.states[rows],
        actions=demos.actions[rows],
        offset=np.append(0, np.cumsum(np.diff(demos.offset)[bouts])),
        times=None if demos.times is None else demos.times[rows],
        final_states=demos.final_states[bouts],
        truncated=demos.truncated[bouts],
        trajectory_names=tuple(demos.trajectory_names[k] for k in bouts),
        groups=tuple(demos.groups[k] for k in bouts) if demos.groups else (),
    )


def decisions(demos: Demonstrations) -> Bools:
    """(N,) observations with more than one legal action: in a dead end there is only the way back."""
    return np.asarray(demos.states < FIRST_DEAD_END)


def chance(demos: Demonstrations) -> Floats:
    """(N, A) all legal actions alike."""
    return np.where(decisions(demos)[:, None], 1 / N_ACTIONS, np.eye(N_ACTIONS)[BACK])


def markov(learned: Demonstrations, asked: Demonstrations, order: int, smoothing: float) -> Floats:
    """(N, A) p(action | node), or with ``order`` 2 p(action | node before, node), by counts of the ``learned`` bouts.

    ``smoothing`` is added to the count of each legal action (a Dirichlet prior).
    """
    counts = counted(learned, asked, shape=(N_STATES, N_ACTIONS), order=order)
    weight = (counts + smoothing) * (chance(asked) > 0)
    return np.asarray(weight / weight.sum(axis=1, keepdims=True))
