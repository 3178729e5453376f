"""Room World: the 15 × 15 cells and five rooms of thesis 3.2.1, in two layouts and their variants."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy import ndimage

from subgoal.mdp.grids.grid import ROOM_SLIP, GridWorld
from subgoal.mdp.grids.maps import TextMap, read_map
from subgoal.mdp.tabular import check_discount
from subgoal.runtime.checks import Floats, Ints, frozen, positive
from subgoal.runtime.errors import InputError

DISCOUNT, MAGNITUDE = 0.93, 0.01
START = (9, 5)
"""The cell (x, y) in which the expert starts; (10, 6) where cells are counted from one, as in the thesis."""
SHUT = {"drawn": "m", "moved": "d", "double": ""}
"""Which doors of a drawing are walls: those marked m, those marked d, or none, so that doors are two cells wide."""
CORNERS = {
    "lower left": (0, 0), "lower right": (14, 0), "upper left": (0, 14), "upper right": (14, 14), "centre": (7, 7),
}  # fmt: skip
"""A cell of each room."""
DRAWINGS = {
    "A": """
.......#.......
.......d.......
.......m.......
.......#.......
....#md####....
....#.....m....
....#.---.d....
#dm##.---.##md#
++++d.---.#....
++++m.....#....
++++####dm#....
+++++++#.......
+++++++m.......
+++++++d.......
+++++++#.......
""",
    "B": """
......#........
......#........
......d........
......m........
......#........
......#........
...#dm#m#......
...#----d......
...#----###md##
#dm#----#......
+++d----#......
+++#m#md#......
+++++m.........
+++++d.........
+++++#.........
""",
}
"""Top row first. + is positive, − negative; d and m are doors."""


@dataclass(frozen=True, eq=False, repr=False)
class RoomWorld:
    """Five rooms, the reward that is true in them, and where the expert starts.

    Attributes
    ----------
    name:
        Layout and variant.
    grid:
        The world: 15 × 15 cells, four directions with ``ROOM_SLIP``, no action that stays.
    reward:
        (S,) positive in the lower left room, negative in a block of the centre room, zero elsewhere.
    start:
        State of the cell (10, 6), counted from one.
    rooms:
        States of each room by name: "lower left", "lower right", "upper left", "upper right", "centre". Doors belong
        to none.
    """

    name: str
    grid: GridWorld
    reward: Floats
    start: int
    rooms: Mapping[str, Ints]

    def __repr__(self) -> str:
        return f"RoomWorld({self.name}: {self.grid.n_states} free cells)"


def room_world(
    layout: str = "A",
    *,
    mirror: bool = False,
    doors: str = "drawn",
    magnitude: float = MAGNITUDE,
    discount: float = DISCOUNT,
) -> RoomWorld:
    """The Room World of thesis 3.2.1, whose walls are known only in words.

    Parameters
    ----------
    layout:
        "A": the expert starts inside the centre room, in whose middle lies the negative block of 3 × 3. "B": it starts
        in the lower right room; the centre room is smaller and negative altogether.
    mirror:
        Whether x and y change places. The lower left room stays where it is, and the start too.
    doors:
        "drawn", "moved" by a cell (some round a corner), or "double": both of these are open.
    magnitude:
        Size of the rewards.
    discount:
        γ.

    Raises ``InputError`` for another layout or other doors, and a magnitude that is not above 0.
    """
    for what, given, known in (("layout", layout, DRAWINGS), ("doors", doors, SHUT)):
        if given not in known:
            raise InputError(what, found=repr(given), wanted=" or ".join(map(repr, known)))
    size, drawn = positive("magnitude", magnitude), read_map(DRAWINGS[layout], blocked=SHUT[doors])
    turn = -1 if mirror else 1
    free = drawn.free.T if mirror else drawn.free
    grid = GridWorld(free.copy(), check_discount(discount), moves=4, stay=False, slip=ROOM_SLIP)
    reward = np.zeros(grid.n_states)
    for tile, value in (("+", size), ("-", -size)):
        reward[grid.states(drawn.tiles[tile][:, ::turn])] = value
    name = " ".join([layout, *["mirrored"] * mirror, *[f"doors {doors}"] * (doors != "drawn")])
    return RoomWorld(name, grid, np.asarray(frozen(reward)), grid.state(*START), _rooms(grid, drawn, turn))


def _rooms(grid: GridWorld, drawn: TextMap, turn: int) -> dict[str, Ints]:
    """What is connected when all doors are shut."""
    inside = grid.free.copy()
    for door in ("d", "m"):
        x, y = drawn.tiles[door][:, ::turn].T
        inside[y, x] = False
    label, _ = ndimage.label(inside)
    of_state = label[grid.free]
    return {name: np.flatnonzero(of_state == label[y, x]) for name, (x, y) in CORNERS.items()}
