"""The envelope: the states of a large world that planning has looked at, and those at its edge that it has only met."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from subgoal._kernels import envelope as loops
from subgoal._kernels.first_passage import compress_rows, distance_order, find_predecessors
from subgoal.mdp.local_world import LocalWorld, Rows
from subgoal.mdp.planners.compressed import CompressedRows
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, Ints

FIRST_ROOM = 1024


class Envelope:
    """States of a ``LocalWorld`` by place: 0, 1, 2 … as they were met. It only grows.

    A state that is *inside* has its transition rows; one that was only *met*, as a successor, is at the edge.
    """

    def __init__(self, world: LocalWorld) -> None:
        self.world = world
        self.n_met, self.n_entries = 0, 0
        self._known = np.empty(FIRST_ROOM, np.int64)
        self._key, self._place = np.zeros(4 * FIRST_ROOM, np.int64), np.full(4 * FIRST_ROOM, loops.EMPTY)
        self._first, self._number = np.zeros(FIRST_ROOM, np.int64), np.full(FIRST_ROOM, -1)
        self._parts: list[tuple[Ints, Any, Floats, Floats]] = []
        self._n_rows = 0
        self._whole: tuple[Ints, Any, Floats, Floats] = (np.zeros(1, np.int64), *_nothing())

    @property
    def states(self) -> Ints:
        """(S,) the states met, by place."""
        return self._known[: self.n_met]

    @property
    def inside(self) -> Bools:
        """(S,) whose rows are here."""
        return self._number[: self.n_met] >= 0

    @property
    def n_inside(self) -> int:
        """How many."""
        return int(self.inside.sum())

    def meet(self, states: Ints) -> Ints:
        """(M,) places of states, new ones for those not met before."""
        out, done = np.empty(states.size, np.int64), 0
        while True:
            self.n_met, done = loops.meet(states, done, self._key, self._place, self.n_met, self._known, out)
            if done == states.size:
                return out
            self._make_room()

    def places(self, states: Ints) -> Ints:
        """(M,) places of states, −1 for those not met."""
        out = np.empty(states.size, np.int64)
        loops.places_of(states, self._key, self._place, out)
        return out

    def expand(self, places: Ints) -> Ints:
        """Take states in, given by place, that are not inside yet; returns the places met for the first time."""
        before = self.n_met
        if not places.size:
            return np.zeros(0, np.int64)
        states = self._known[places]
        rows = self.world.rows(states)
        to = self.meet(rows.successor)
        edge, row_edge, kept, weight, gain = compress_rows(
            rows.offset, to, rows.probability, self.world.n_actions, self.world.discount, places
        )
        self._first[places] = self._n_rows + edge[:-1]
        self._number[places] = np.diff(edge)
        self._n_rows += int(edge[-1])
        self._parts.append((self.n_entries + row_edge[1:], kept, weight, gain))
        self.n_entries += kept.size
        return np.arange(before, self.n_met)

    def expand_rings(self, places: Ints, always: int, most: int, worth: Callable[[Ints], Bools]) -> None:
        """Take in states at the edge, then what they lead to, ring after ring.

        Beyond ``always`` rings only what is ``worth`` it; beyond ``most`` states nothing but the first ring.
        """
        ring, rings = places[self._number[places] < 0], 0
        while ring.size:
            self.expand(ring)
            most, rings = most - ring.size, rings + 1
            found = np.unique(self._reached(ring))
            ring = found[self._number[found] < 0]
            if rings >= always:
                ring = ring[worth(ring)]
            if ring.size > most:
                return

    def table(self) -> CompressedRows:
        """The rows by place, states at the edge having none."""
        row_edge, to, weight, gain = self._joined()
        number = np.maximum(self._number[: self.n_met], 0)
        rows = loops.rows_in_order(self._first[: self.n_met], number, row_edge, to, weight, gain)
        return CompressedRows(*rows, *find_predecessors(*rows[:3]))

    def order(self, table: CompressedRows, goals: Ints) -> Ints:
        """Places inside, those first from which a goal is reached soonest."""
        return np.asarray(loops.sweep_order(distance_order(goals, table.edge, table.before), self.inside))

    def action_rows(self, states: Ints) -> Rows:
        """Transition rows of states inside whose successors are places."""
        rows = self.world.rows(states)
        return Rows(rows.offset, self.places(rows.successor), rows.probability)

    def sub_world(self) -> TabularMDP:
        """The states met as a world of their own, numbered by place, in which episodes are over at the edge."""
        rows = self.world.rows(self.states)
        counts = np.diff(rows.offset).reshape(self.n_met, self.world.n_actions)
        kept = np.repeat(self.inside, counts.sum(axis=1))
        legal = (counts > 0) & self.inside[:, None]
        offset = np.concatenate([[0], np.cumsum(np.where(legal, counts, 0))])
        return TabularMDP(
            offset, self.places(rows.successor[kept]), rows.probability[kept], self.world.n_actions,
            self.world.discount, available=legal, terminal=~legal.any(axis=1),
        )  # fmt: skip

    def _reached(self, places: Ints) -> Ints:
        row_edge, to, _, _ = self._joined()
        first, last = self._first[places], self._first[places] + self._number[places]
        begin, count = row_edge[first], row_edge[last] - row_edge[first]
        start = np.concatenate([[0], np.cumsum(count)])
        return np.asarray(to[np.arange(start[-1]) + np.repeat(begin - start[:-1], count)], np.int64)

    def _joined(self) -> tuple[Ints, Any, Floats, Floats]:
        """All appended rows as one: ``row_edge`` from 0, ``to``, ``weight``, ``gain``."""
        if self._parts:
            whole: Any = zip(self._whole, *self._parts, strict=True)
            row_edge, to, weight, gain = (np.concatenate(parts) for parts in whole)
            self._whole, self._parts = (row_edge, to, weight, gain), []
        return self._whole

    def _make_room(self) -> None:
        """Twice as much of it; places that were not given out are not inside."""
        for name, empty in (("_known", 0), ("_first", 0), ("_number", -1)):
            grown = np.full(2 * self._known.size if name == "_known" else self._known.size, empty, np.int64)
            grown[: self.n_met] = getattr(self, name)[: self.n_met]
            setattr(self, name, grown)
        size = 4 * self._known.size
        self._key, self._place = np.zeros(size, np.int64), np.full(size, loops.EMPTY)
        again = self.states.copy()
        loops.meet(again, 0, self._key, self._place, 0, self._known, np.empty(again.size, np.int64))


def _nothing() -> tuple[Any, Floats, Floats]:
    return np.zeros(0, np.uint32), np.zeros(0), np.zeros(0)
