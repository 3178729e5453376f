"""Grid worlds: cells with walls, four or eight directions, slip, and the tabular process they are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from subgoal._kernels.grid_rows import grid_rows
from subgoal.mdp.grids.travel_bound import TravelBound, travel_bound
from subgoal.mdp.local_world import Rows
from subgoal.mdp.tabular import TabularMDP, check_discount, check_states
from subgoal.runtime.checks import Bools, Floats, Ints, copied, frozen, real_array, whole
from subgoal.runtime.errors import InputError
from subgoal.storage.archive import digest_arrays

COMPASS = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")
CLOCKWISE = np.array([(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)])
"""(8, 2) one step in each direction of the compass, y upwards."""
STAY = "stay"
THESIS_SLIP = (0.7, 0.15, 0.0, 0.0, 0.0, 0.0, 0.0, 0.15)
"""Thesis 4.7 with eight directions: 0.7 as chosen, 0.15 for each direction beside it."""
ROOM_SLIP = (0.75, 0.1, 0.0, 0.1, 0.05)
"""Thesis 3.2.1 with four: 0.75 as chosen, 0.1 to the right and to the left, 0.05 not to move at all."""


@dataclass(frozen=True, eq=False, repr=False)
class GridWorld:
    """Free cells of a rectangle as states, steps to neighbouring cells as actions.

    Attributes
    ----------
    free:
        (height, width) booleans, ``free[y, x]``: where one can be. States are the free cells, row by row.
    discount:
        γ.
    moves:
        4 or 8 directions, clockwise from N.
    stay:
        Whether there is an action that stays, for certain; it is the last one.
    slip:
        One probability for each direction: ``slip[k]`` is the chance to go k directions clockwise of the chosen one.
        One more, if given, is the chance not to move. None: always as chosen. ``THESIS_SLIP`` and ``ROOM_SLIP`` are
        those of the thesis.
    origin:
        "lower": y upwards, so that N is y + 1. "upper": y downwards, as rows of text and images go; N is y − 1.
    cut_corners:
        Whether one may go diagonally past a cell that is not free.
    terminal:
        (T, 2) cells (x, y) in which episodes are over.
    coordinates:
        (S, 2) where the states lie, in units of one's own; not given: their cells.

    A step into a wall or over the edge stays where it is (thesis 4.7).

    Raises
    ------
    InputError
        Nothing free, chances that do not sum to one within 1e-9, a terminal cell that is a wall or outside.
    """

    free: Bools
    discount: float
    moves: int = 8
    stay: bool = True
    slip: tuple[float, ...] | None = None
    origin: Literal["lower", "upper"] = "lower"
    cut_corners: bool = True
    terminal: Any = ()
    coordinates: Any = None

    def __post_init__(self) -> None:
        free = copied("free", self.free)
        if free.dtype != bool or free.ndim != 2 or not free.any():
            found = f"{free.dtype} of shape {free.shape}"
            raise InputError("free", found=found, wanted="booleans (height, width), one at least True")
        if self.origin not in ("lower", "upper"):
            raise InputError("origin", found=repr(self.origin), wanted="'lower' or 'upper'")
        moves = whole("moves", self.moves)
        if moves not in (4, 8):
            raise InputError("moves", found=moves, wanted="4 or 8")
        discount = check_discount(self.discount)
        self._set(free=frozen(free), moves=moves, discount=discount, slip=turn_chances(self.slip, moves))
        ends = copied("terminal", self.terminal)
        ends = ends if ends.size else np.zeros((0, 2), np.int64)
        self.states(ends)
        self._set(terminal=frozen(ends))
        if self.coordinates is not None:
            coordinates = real_array("coordinates", self.coordinates, ndim=2)
            if len(coordinates) != self.n_states:
                wanted = f"{self.n_states}, one per state"
                raise InputError("coordinates", found=f"{len(coordinates)} rows", wanted=wanted)
            self._set(coordinates=coordinates)

    def __repr__(self) -> str:
        height, width = self.free.shape
        size = f"{width} × {height}, {self.n_states} free cells, {self.n_actions} actions"
        return f"GridWorld({size}, discount {self.discount:g})"

    @cached_property
    def cells(self) -> Ints:
        """(S, 2) the cell (x, y) of each state."""
        return np.asarray(frozen(np.argwhere(self.free)[:, ::-1].astype(np.int64)))

    @cached_property
    def numbers(self) -> Ints:
        """(height, width) the state of each cell, −1 where there is none."""
        numbers = np.full(self.free.shape, -1, np.int64)
        numbers[self.free] = np.arange(int(self.free.sum()))
        return np.asarray(frozen(numbers))

    @property
    def n_states(self) -> int:
        """S, the number of free cells."""
        return len(self.cells)

    @property
    def action_names(self) -> tuple[str, ...]:
        """A labels: directions of the compass, and "stay"."""
        return (*COMPASS[:: 8 // self.moves], *([STAY] if self.stay else []))

    @cached_property
    def directions(self) -> Ints:
        """(A, 2) the step (dx, dy) of each action; (0, 0) for staying."""
        steps = CLOCKWISE[:: 8 // self.moves] * (1, 1 if self.origin == "lower" else -1)
        return np.asarray(frozen(np.vstack([steps, *([[[0, 0]]] if self.stay else [])])))

    def action(self, name: str) -> int:
        """Number of the action of that name."""
        if name not in self.action_names:
            raise InputError("action", found=repr(name), wanted=" or ".join(map(repr, self.action_names)))
        return self.action_names.index(name)

    def state(self, x: int, y: int) -> int:
        """State of the cell (x, y); see ``states``."""
        return int(self.states([(x, y)])[0])

    def states(self, cells: Any) -> Ints:
        """(M,) states of cells (M, 2). Raises ``InputError`` for cells outside the map or inside a wall."""
        array = copied("cells", cells)
        if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != 2:
            raise InputError("cells", found=f"{array.dtype} of shape {array.shape}", wanted="integers (M, 2) of (x, y)")
        height, width = self.free.shape
        outside = (array < 0).any(axis=1) | (array[:, 0] >= width) | (array[:, 1] >= height)
        numbers = self.numbers[np.where(outside, 0, array[:, 1]), np.where(outside, 0, array[:, 0])]
        for bad, found, wanted in (
            (outside, "outside the map", f"x of 0 to {width - 1}, y of 0 to {height - 1}"),
            (numbers < 0, "inside a wall", "a free cell"),
        ):
            if bad.any():
                i = int(np.argmax(bad))
                x, y = array[i].tolist()
                raise InputError("cell", where=f"index {i}", found=f"({x}, {y}), which is {found}", wanted=wanted)
        return np.asarray(numbers)

    @cached_property
    def targets(self) -> Ints:
        """(S, moves) the state that a step in each direction leads to: the neighbour, or the same state if blocked."""
        height, width = self.free.shape
        walled = np.full((height + 2, width + 2), -1, np.int64)
        walled[1:-1, 1:-1] = self.numbers
        x, y = (self.cells + 1).T
        here = np.arange(self.n_states)
        targets = np.empty((self.n_states, self.moves), np.int32)
        for k, (dx, dy) in enumerate(self.directions[: self.moves]):
            there = walled[y + dy, x + dx]
            if not self.cut_corners and dx and dy:
                there = np.where((walled[y, x + dx] < 0) | (walled[y + dy, x] < 0), -1, there)
            targets[:, k] = np.where(there < 0, here, there)
        return np.asarray(frozen(targets))

    @cached_property
    def mdp(self) -> TabularMDP:
        """The world as a tabular process."""
        offset, successor, probability = self.rows(np.arange(self.n_states))
        probability.flags.writeable = False
        lie = self.cells.astype(float) if self.coordinates is None else self.coordinates
        return TabularMDP(
            offset, successor, probability, self.n_actions, self.discount, terminal=self._over, coordinates=lie,
            action_names=self.action_names,
        )  # fmt: skip

    @property
    def n_actions(self) -> int:
        """A."""
        return self.moves + int(self.stay)

    def rows(self, states: Ints) -> Rows:
        """Transition rows of some states (M,), so that planning need not write down the world; see ``LocalWorld``."""
        slip = np.array([*self.slip, 0.0][: self.moves + 1])  # type: ignore[misc]
        told = grid_rows(states, self.targets[states].astype(np.int64), self._over[states], slip, self.moves, self.stay)
        return Rows(*told)

    def reach_bound(self, states: Ints, goals: Ints) -> Floats:
        """(M, G) upper bounds of E[γ^T], T the time from a state to a goal, that hold whatever the walls."""
        return self._travel(self.cells[states], self.cells[goals])

    def check(self, what: str, states: Any) -> Ints:
        """``states`` as numbers of existing states; raises ``InputError`` naming the index of another one."""
        return check_states(what, states, self.n_states)

    def fingerprint(self) -> str | None:
        """A checksum of everything that planning depends on."""
        shape = [self.moves, self.stay, self.origin == "lower", self.cut_corners, self.discount, *self.slip]  # type: ignore[misc]
        return digest_arrays(self.free, self.terminal, np.array(shape, float))

    @cached_property
    def _over(self) -> Bools:
        over = np.zeros(self.n_states, bool)
        over[self.states(self.terminal)] = True
        return over

    @cached_property
    def _travel(self) -> TravelBound:
        return travel_bound(self.directions[: self.moves], self.slip, self.discount)  # type: ignore[arg-type]

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)


def turn_chances(slip: Any, moves: int) -> tuple[float, ...]:
    """The chance of each turn, checked."""
    chances = real_array("slip", np.eye(moves)[0] if slip is None else slip, ndim=1)
    if chances.size not in (moves, moves + 1) or not (chances >= 0).all() or not abs(chances.sum() - 1) <= 1e-9:
        found = f"{chances.size} numbers that sum to {chances.sum():.12g}"
        raise InputError("slip", found=found, wanted=f"{moves} probabilities that sum to 1, or {moves + 1}")
    return tuple(float(p) for p in chances)
