"""The games of one cook's room as rows to be cut, with the true times at which tiles were used."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from experiments.overcooked import DEFAULT_GAMMA, GAMMAS, SCORED
from experiments.overcooked_world import INTERACT, Kitchen, kitchen, shown, start_of
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.maps import TextMap
from subgoal.runtime.checks import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class Side:
    """The games of one cook's room in one division of the recording.

    Attributes
    ----------
    rooms:
        The room at each discount.
    demonstrations:
        Rows in which something was done, a trajectory per game; without the presses of "interact" if they are hidden.
    names:
        Which game each trajectory is of; the same for both cooks.
    true:
        Times of the true change points of each game: of each row between which and the next a segment ends.
    """

    rooms: dict[float, Kitchen]
    demonstrations: Demonstrations
    names: tuple[str, ...]
    true: tuple[Floats, ...]

    @property
    def games(self) -> list[slice]:
        """Rows of each game."""
        offset = self.demonstrations.offset
        return [slice(int(a), int(b)) for a, b in pairwise(offset)]

    @property
    def states(self) -> Ints:
        """(N,) 4·cell + facing."""
        return np.asarray(self.demonstrations.states)

    @property
    def actions(self) -> Ints:
        """(N,) index into ``ACTIONS``."""
        return np.asarray(self.demonstrations.actions)

    @property
    def times(self) -> Floats:
        """(N,) game steps."""
        return np.asarray(self.demonstrations.times)

    @property
    def places(self) -> Floats:
        """(N, 2) the cell stood on."""
        return np.asarray(self.demonstrations.places)


def side(maps: dict[str, TextMap], table: Any, player: int, split: str, hidden: bool) -> Side:
    """One cook's room in one division; with ``hidden`` presses nothing is seen but steps and turns."""
    rows = table[(table["player"] == player) & (table["split"] == split)]
    rooms = {gamma: kitchen(maps[SCORED], start_of(rows), gamma) for gamma in GAMMAS}
    demonstrations = shown(rows, rooms[DEFAULT_GAMMA]).demonstrations
    if hidden:
        demonstrations = kept_rows(demonstrations, np.asarray(demonstrations.actions) != INTERACT)
    times, offset = np.asarray(demonstrations.times), demonstrations.offset
    names, true = [], []
    for k, (name, game) in enumerate(rows.groupby(["split", "worker", "round"], sort=True)):
        used = game["t"].to_numpy(float)[(game["event"] != "").to_numpy()]
        names.append(":".join(map(str, name)))
        true.append(ends_of_segments(times[offset[k] : offset[k + 1]], used))
    return Side(rooms, demonstrations, tuple(names), tuple(true))


def kept_rows(demonstrations: Demonstrations, kept: Bools) -> Demonstrations:
    """Some rows of each trajectory."""
    before = np.append(0, np.cumsum(kept))
    return Demonstrations(
        np.asarray(demonstrations.states)[kept], np.asarray(demonstrations.actions)[kept],
        before[demonstrations.offset], times=np.asarray(demonstrations.times)[kept],
        final_states=demonstrations.final_states, names=demonstrations.names, coordinates=demonstrations.coordinates,
        time_unit=demonstrations.time_unit, source=demonstrations.source,
    )  # fmt: skip


def ends_of_segments(times: Floats, used: Floats) -> Floats:
    """Times of the rows of one game that are the last up to some use; the last row of all ends nothing.

    ``times`` (n,) are those of the rows, ``used`` those of the uses, both sorted. Uses between the same two rows make
    one change point; uses before the first row make none.
    """
    last = np.unique(np.searchsorted(times, used, side="right") - 1)
    return np.asarray(times[last[(last >= 0) & (last < times.size - 1)]])
