"""Positions in a plane, of a Recording or of Demonstrations, in the order they were taken."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError


class Samples(NamedTuple):
    """M positions in the order they were taken.

    ``positions`` (M, 2), ``times`` (M,) or None, ``trajectory`` (M,) the number of the trajectory, ``rows`` (M,) where
    in the data, −1 for the end of a trajectory that is none of its rows; ``names`` of the trajectories.
    """

    positions: Floats
    times: Any
    trajectory: Ints
    rows: Ints
    names: tuple[str, ...]

    def place(self, i: int) -> str:
        """Where sample i comes from, in words."""
        row, name = self.rows[i], self.names[self.trajectory[i]]
        return f"row {row}, trajectory {name!r}" if row >= 0 else f"the end of trajectory {name!r}"


def planar(data: Any) -> Floats:
    """(M, 2) all positions of a Recording or of continuous Demonstrations, ends of trajectories included."""
    if isinstance(data, Recording):
        positions = data.positions
    elif isinstance(data, Demonstrations) and not data.is_discrete:
        positions = np.vstack([data.states, data.final_states])
    else:
        found = "states of a discrete world" if isinstance(data, Demonstrations) else type(data).__name__
        raise InputError("data", found=found, wanted="a Recording, or Demonstrations with positions as states")
    if positions.shape[1] != 2:
        raise InputError("data", found=f"positions with {positions.shape[1]} columns", wanted="2: x and y")
    return positions


def samples_of(data: Any) -> Samples:
    """The samples of a Recording, or the states of Demonstrations and then their end where that is not the last one.

    The end is as long after the last state as that is after the one before; at the same time if there is none before.
    """
    positions = planar(data)
    trajectory = np.repeat(np.arange(data.n_trajectories), np.diff(data.offset))
    if isinstance(data, Recording):
        return Samples(positions, data.times, trajectory, np.arange(len(positions)), data.trajectory_names)
    last, after = data.offset[1:] - 1, data.offset[1:]
    moved = np.flatnonzero((data.final_states != data.states[last]).any(axis=1))
    times = data.times
    if times is not None:
        before = np.maximum(last - 1, data.offset[:-1])
        times = np.insert(times, after[moved], (2 * times[last] - times[before])[moved])
    return Samples(
        np.insert(data.states, after[moved], data.final_states[moved], axis=0),
        times,
        np.insert(trajectory, after[moved], moved),
        np.insert(np.arange(len(data.states)), after[moved], -1),
        data.trajectory_names,
    )
