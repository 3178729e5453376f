"""``ImplicitGrid``: a grid world of any size, of which only the cells that are asked for are ever looked at."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.grid_rows import grid_rows
from subgoal.mdp.grids.grid import CLOCKWISE, COMPASS, STAY, turn_chances
from subgoal.mdp.grids.travel_bound import TravelBound, travel_bound
from subgoal.mdp.local_world import Rows
from subgoal.mdp.tabular import check_discount
from subgoal.runtime.checks import Bools, Floats, Ints, copied, whole
from subgoal.runtime.errors import InputError
from subgoal.storage.archive import digest_arrays

FreeCells = Callable[[Ints, Ints], NDArray[np.bool_]]


@dataclass(frozen=True, eq=False, repr=False)
class ImplicitGrid:
    """Cells of a rectangle as states, number y·width + x; steps and slips are those of ``GridWorld``.

    Nothing is held for each cell, so that 10⁹ of them cost no more than ten.

    Attributes
    ----------
    width, height:
        Cells.
    discount:
        γ.
    free:
        Where one can be: ``free(x, y)`` for integer arrays inside the rectangle, or (height, width) booleans, which may
        be a memory map. None: everywhere.
    moves, stay, slip, origin, cut_corners:
        As of ``GridWorld``.
    name:
        What stands for the function ``free`` where plans are kept by content: another function, another name.

    Raises
    ------
    InputError
        What ``GridWorld`` refuses, more than 2⁶² cells, ``free`` of another shape.
    """

    width: int
    height: int
    discount: float
    free: FreeCells | Bools | None = None
    moves: int = 8
    stay: bool = True
    slip: Any = None
    origin: Literal["lower", "upper"] = "lower"
    cut_corners: bool = True
    name: str = ""

    def __post_init__(self) -> None:
        width, height, moves = whole("width", self.width), whole("height", self.height), whole("moves", self.moves)
        if width * height > 2**62:
            raise InputError("width · height", found=width * height, wanted="2⁶² cells at most")
        if moves not in (4, 8):
            raise InputError("moves", found=moves, wanted="4 or 8")
        if self.origin not in ("lower", "upper"):
            raise InputError("origin", found=repr(self.origin), wanted="'lower' or 'upper'")
        free = self.free
        told = free is None or callable(free)
        if not told and not (isinstance(free, np.ndarray) and free.dtype == bool and free.shape == (height, width)):
            found = f"{free.dtype} of shape {free.shape}" if isinstance(free, np.ndarray) else type(free).__name__
            wanted = f"a function of x and y, or booleans of shape {(height, width)}"
            raise InputError("free", found=found, wanted=wanted)
        checked: dict[str, Any] = {
            "width": width, "height": height, "moves": moves, "slip": turn_chances(self.slip, moves),
            "discount": check_discount(self.discount),
        }  # fmt: skip
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"ImplicitGrid({self.width} × {self.height}, {self.n_actions} actions, discount {self.discount:g})"

    @property
    def n_actions(self) -> int:
        """A."""
        return self.moves + int(self.stay)

    @property
    def action_names(self) -> tuple[str, ...]:
        """A labels: directions of the compass, and "stay"."""
        return (*COMPASS[:: 8 // self.moves], *([STAY] if self.stay else []))

    @cached_property
    def directions(self) -> Ints:
        """(moves, 2) the step (dx, dy) of each direction."""
        return np.asarray(CLOCKWISE[:: 8 // self.moves] * (1, 1 if self.origin == "lower" else -1))

    def is_free(self, x: Ints, y: Ints) -> Bools:
        """Whether one can be in cells (x, y); not outside the rectangle."""
        inside = (x >= 0) & (x < self.width) & (y >= 0) & (y < self.height)
        if self.free is None:
            return np.asarray(inside)
        at = np.where(inside, x, 0), np.where(inside, y, 0)
        told = np.asarray(self.free(*at) if callable(self.free) else self.free[at[1], at[0]])
        if told.dtype != bool or told.shape != inside.shape:
            raise InputError("free", found=f"{told.dtype} of shape {told.shape}", wanted=f"booleans of shape {x.shape}")
        return np.asarray(inside & told)

    def cells(self, states: Ints) -> Ints:
        """(M, 2) the cell (x, y) of each state."""
        return np.stack([states % self.width, states // self.width], axis=-1)

    def states(self, cells: Any) -> Ints:
        """(M,) states of cells (M, 2). Raises ``InputError`` for cells outside or inside a wall."""
        array = copied("cells", cells)
        if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 2:
            raise InputError("cells", found=f"{array.dtype} of shape {array.shape}", wanted="integers (M, 2) of (x, y)")
        x, y = array.astype(np.int64).T
        bad = ~self.is_free(x, y)
        if bad.any():
            i = int(np.argmax(bad))
            raise InputError("cell", where=f"index {i}", found=f"({x[i]}, {y[i]})", wanted="a free cell of the grid")
        return np.asarray(y * self.width + x)

    def rows(self, states: Ints) -> Rows:
        """Transition rows of some states (M,); see ``LocalWorld``."""
        x, y = states % self.width, states // self.width
        target = np.empty((states.size, self.moves), np.int64)
        for k, (dx, dy) in enumerate(self.directions):
            open_ = self.is_free(x + dx, y + dy)
            if not self.cut_corners and dx and dy:
                open_ &= self.is_free(x + dx, y) & self.is_free(x, y + dy)
            target[:, k] = np.where(open_, (y + dy) * self.width + x + dx, states)
        slip = np.array([*self.slip, 0.0][: self.moves + 1])
        return Rows(*grid_rows(states, target, np.zeros(states.size, bool), slip, self.moves, self.stay))

    def reach_bound(self, states: Ints, goals: Ints) -> Floats:
        """(M, G) upper bounds of E[γ^T], T the time from a state to a goal, that hold whatever the walls."""
        return self._travel(self.cells(states), self.cells(goals))

    def check(self, what: str, states: Any) -> Ints:
        """``states`` as 64-bit numbers of free cells; raises ``InputError`` naming the index of another one."""
        array = copied(what, states)
        if array.dtype.kind not in "iu":
            raise InputError(what, found=f"{array.dtype} of shape {array.shape}", wanted="integers")
        array = array.astype(np.int64)
        bad = (array < 0) | (array >= self.width * self.height)
        bad |= ~self.is_free(np.where(bad, 0, array) % self.width, np.where(bad, 0, array) // self.width)
        if bad.any():
            i = int(np.argmax(bad))
            where = f"index {i}" if array.ndim else None
            wanted = f"a free cell's y·{self.width} + x, below {self.width * self.height}"
            raise InputError(what, where=where, found=int(array.ravel()[i]), wanted=wanted)
        return array

    def fingerprint(self) -> str | None:
        """A checksum of everything that planning depends on; None where ``free`` is a function without a ``name``."""
        if callable(self.free) and not self.name:
            return None
        walls = self.free if isinstance(self.free, np.ndarray) else np.zeros(0, bool)
        size = [self.width, self.height, self.moves, self.stay, self.origin == "lower", self.cut_corners]
        told = np.frombuffer(self.name.encode(), np.uint8)
        return digest_arrays(walls, np.array([*size, self.discount, *self.slip], float), told)

    @cached_property
    def _travel(self) -> TravelBound:
        return travel_bound(self.directions, self.slip, self.discount)
