"""People in a kitchen (Overcooked-AI, Carroll et al., NeurIPS 2019) as a discrete world: the game, its games, tiles.

A cook stands on a floor cell and faces one of four ways; that is the state. A step towards free floor moves the cook,
who then faces that way; a step against a tile only turns. "interact" uses the tile that is faced and leaves the state
as it is. The other cook is not in the model: in the layouts used here the two never share a room, and every recorded
step that the model does not foretell is dropped and counted.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.mdp.grids.maps import TextMap, read_maps
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, Ints

GAMES, LAYOUTS, TILES = "human_human_trials.csv.gz", "layouts.txt", "OPDS"
ACTIONS = ("N", "S", "E", "W", "interact")
STEPS = ((0, -1), (0, 1), (1, 0), (-1, 0))
"""(dx, dy) of the first four actions, and of the four ways to face; y is downwards."""
INTERACT = 4
Cell = tuple[int, int]


@dataclass(frozen=True, eq=False)
class Kitchen:
    """One cook's room.

    Attributes
    ----------
    mdp:
        State 4·c + f is cell c, facing ``STEPS[f]``.
    cells:
        The floor cells that can be reached, each with its number c.
    candidates:
        For every tile or counter that can be faced, the states that face it; called "O:5:1" (kind, x, y).
    """

    mdp: TabularMDP
    cells: dict[Cell, int]
    candidates: Candidates


@dataclass(frozen=True, eq=False)
class Shown:
    """What was recorded of one cook.

    Attributes
    ----------
    demonstrations:
        Pairs, a trajectory per game.
    next_tile:
        (N,) the candidate that the cook used next, −1 where none was used before the end.
    uses:
        (G,) successful uses of each candidate.
    """

    demonstrations: Demonstrations
    next_tile: Ints
    uses: Ints

    @property
    def use_shares(self) -> Floats:
        """(G,) share of all uses."""
        return np.asarray(self.uses / self.uses.sum())


def read_kitchens(folder: Path) -> dict[str, TextMap]:
    """The map of each layout; y is downwards, as in the recordings."""
    return read_maps(folder / LAYOUTS, blocked=TILES, origin="upper")


def read_games(folder: Path, layouts: Sequence[str]) -> Any:
    """The recorded rows of some layouts: a table of player and game step."""
    import pandas as pd

    table = pd.read_csv(folder / GAMES, keep_default_na=False)
    return table[table["layout"].isin(layouts)]


def kitchen(drawn: TextMap, start: Cell, discount: float) -> Kitchen:
    """The room that can be reached from ``start``."""
    cells = {cell: c for c, cell in enumerate(_reached(drawn, start))}
    n_states = 4 * len(cells)
    transition = np.zeros((n_states, len(ACTIONS), n_states))
    facing: dict[Cell, list[int]] = {}
    for (x, y), c in cells.items():
        for f, (dx, dy) in enumerate(STEPS):
            ahead = (x + dx, y + dy)
            transition[4 * c : 4 * c + 4, f, 4 * cells.get(ahead, c) + f] = 1
            if ahead not in cells:
                facing.setdefault(ahead, []).append(4 * c + f)
    transition[range(n_states), INTERACT, range(n_states)] = 1
    places = np.repeat(np.array(list(cells), float), 4, axis=0)
    tiles = sorted(facing)
    kinds = {(int(x), int(y)): kind for kind, found in drawn.tiles.items() for x, y in found}
    candidates = Candidates.from_states(
        [np.array(facing[tile]) for tile in tiles], points=np.array(tiles, float),
        names=[f"{kinds.get((x, y), 'X')}:{x}:{y}" for x, y in tiles],
    )  # fmt: skip
    mdp = TabularMDP.from_dense(transition, discount, coordinates=places, action_names=ACTIONS)
    return Kitchen(mdp, cells, candidates)


def _reached(drawn: TextMap, start: Cell) -> list[Cell]:
    """Floor cells that can be walked to, sorted."""
    found, ahead = {start}, [start]
    while ahead:
        x, y = ahead.pop()
        for dx, dy in STEPS:
            cell = (x + dx, y + dy)
            if cell not in found and drawn.free[cell[1], cell[0]]:
                found.add(cell)
                ahead.append(cell)
    return sorted(found)


def start_of(table: Any) -> Cell:
    """Where the first recorded row is."""
    first = table.iloc[0]
    return int(first["x"]), int(first["y"])


def shown(table: Any, room: Kitchen) -> Shown:
    """The pairs of one cook's games, without those in which nothing was done.

    Left out and counted in the source: "stay" (people think, and the game is fast), a step against the tile that is
    faced already (it changes nothing either), what the model did not foretell, and the last row of each game.
    """
    parts = [_game(game, room) for _, game in table.groupby(["split", "worker", "round"], sort=True)]
    states, actions, tiles, times = (np.concatenate([part[k] for part in parts]) for k in range(4))
    notes: dict[str, int] = {}
    for part in parts:
        for reason, count in part[5].items():
            notes[reason] = notes.get(reason, 0) + count
    names = {name: g for g, name in enumerate(room.candidates.names)}
    uses = np.zeros(len(names), np.int64)
    np.add.at(uses, [names[tile] for tile in _tiles(table["event"]) if tile], 1)
    demonstrations = Demonstrations(
        states, actions, np.append(0, np.cumsum([part[0].size for part in parts])), times=times,
        final_states=np.array([part[4] for part in parts]), names=("x", "y"), coordinates=room.mdp.coordinates,
        time_unit="step", source=Source(name=GAMES).noting(**notes),
    )  # fmt: skip
    return Shown(demonstrations, np.array([names.get(tile, -1) for tile in tiles]), uses)


def _game(game: Any, room: Kitchen) -> tuple[Ints, Ints, list[str], Floats, int, dict[str, int]]:
    """States, actions, names of the tiles used next and times of the pairs; the final state; what was left out."""
    states = np.array([
        4 * room.cells[x, y] + STEPS.index((dx, dy))
        for x, y, dx, dy in zip(game["x"], game["y"], game["ori_x"], game["ori_y"], strict=True)
    ])  # fmt: skip
    taken = np.array([ACTIONS.index(each) if each != "stay" else -1 for each in game["action"]])
    reached = room.mdp.matrix[states * len(ACTIONS) + np.maximum(taken, 0)].indices
    left_out = {"last_row_of_a_game": np.arange(states.size) == states.size - 1, "stay": taken < 0}
    left_out["steps_against_what_is_faced_already"] = (reached == states) & (taken < INTERACT)
    left_out["steps_the_model_does_not_foretell"] = reached != np.append(states[1:], -1)
    kept, notes = np.ones(states.size, bool), {}
    for reason, rows in left_out.items():
        notes[reason] = int((kept & rows).sum())
        kept &= ~rows
    tiles, following = _tiles(game["event"]), ""
    for row in range(len(tiles) - 1, -1, -1):
        following = tiles[row] or following
        tiles[row] = following
    times = game["t"].to_numpy(float)[kept]
    return states[kept], taken[kept], [tiles[row] for row in np.flatnonzero(kept)], times, int(states[-1]), notes


def _tiles(events: Any) -> list[str]:
    """The tile of each event "held_before>held_after@TILE:x:y", "" where nothing happened."""
    return [str(event).partition("@")[2] for event in events]
