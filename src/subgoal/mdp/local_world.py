"""``LocalWorld``: what planning needs of a world that is too large to be written down, and worlds seen that way."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, NamedTuple, Protocol

import numpy as np

from subgoal.mdp.implicit import ImplicitMDP
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError
from subgoal.storage.archive import digest_arrays

Heuristic = Callable[[Ints, Ints], Floats]
"""``heuristic(states (M,), goals (G,))`` gives (M, G) upper bounds of E[γ^T], T the time it takes to get there."""


WORLD = ("n_actions", "discount", "rows", "reach_bound", "check", "fingerprint")


class Rows(NamedTuple):
    """Transition rows of M states: row i·A + a is entries ``offset[i·A + a]`` to ``offset[i·A + a + 1]``.

    All rows of a state where episodes are over are empty; so is the row of an illegal action.
    """

    offset: Ints
    successor: Ints
    probability: Floats


class LocalWorld(Protocol):
    """A world whose states are 64-bit numbers, told a few states at a time."""

    @property
    def n_actions(self) -> int:
        """A."""

    @property
    def discount(self) -> float:
        """γ."""

    def rows(self, states: Ints) -> Rows:
        """Transition rows of (M,) states."""

    def reach_bound(self, states: Ints, goals: Ints) -> Floats:
        """(M, G) upper bounds of E[γ^T] over all policies, T the first time at the goal; one at a goal itself."""

    def check(self, what: str, states: Any) -> Ints:
        """``states`` as 64-bit numbers; raises ``InputError`` naming the index of one that does not exist."""

    def fingerprint(self) -> str | None:
        """A checksum by which the world is known again, None where there is none."""


@dataclass(frozen=True, eq=False)
class TableWorld:
    """A ``TabularMDP`` seen locally.

    Without a ``heuristic`` nothing is known but that another state is at least one step away.
    """

    mdp: TabularMDP
    heuristic: Heuristic | None = None

    def __post_init__(self) -> None:
        check_world(self.mdp)

    @property
    def n_actions(self) -> int:
        """A."""
        return self.mdp.n_actions

    @property
    def discount(self) -> float:
        """γ."""
        return self.mdp.discount

    def rows(self, states: Ints) -> Rows:
        """Slices of the table."""
        mdp = self.mdp
        row = (states[:, None] * mdp.n_actions + np.arange(mdp.n_actions)).ravel()
        first, counts = mdp.offset[row], mdp.offset[row + 1] - mdp.offset[row]
        offset = np.concatenate([[0], np.cumsum(counts)])
        entry = np.arange(offset[-1]) + np.repeat(first - offset[:-1], counts)
        return Rows(offset, mdp.successor[entry].astype(np.int64), mdp.probability[entry])

    def reach_bound(self, states: Ints, goals: Ints) -> Floats:
        """As ``LocalWorld.reach_bound``."""
        return one_step_bound(self.discount, self.heuristic, states, goals)

    def check(self, what: str, states: Any) -> Ints:
        """As ``LocalWorld.check``."""
        return check_states(what, states, self.mdp.n_states)

    def fingerprint(self) -> str | None:
        """Of the table; None with a heuristic, which cannot be told from others."""
        mdp = self.mdp
        if self.heuristic is not None:
            return None
        return digest_arrays(mdp.offset, mdp.successor, mdp.probability, mdp.discount, mdp.available)


@dataclass(frozen=True, eq=False)
class NumberedWorld:
    """An ``ImplicitMDP`` whose states are numbered as they are met, so that demonstrations can speak of them.

    ``number(state)`` gives the number of a state, ``state(number)`` the state of a number.
    """

    mdp: ImplicitMDP
    heuristic: Heuristic | None = None
    _number: dict[Hashable, int] = field(default_factory=dict, repr=False)
    _states: list[Hashable] = field(default_factory=list, repr=False)

    def number(self, state: Hashable) -> int:
        """The number of ``state``: the next one if it was not met before."""
        if state not in self._number:
            self._number[state] = len(self._states)
            self._states.append(state)
        return self._number[state]

    def state(self, number: int) -> Hashable:
        """The state of that number."""
        return self._states[int(self.check("number", number))]

    @property
    def n_actions(self) -> int:
        """A."""
        return self.mdp.n_actions

    @property
    def discount(self) -> float:
        """γ."""
        return self.mdp.discount

    def rows(self, states: Ints) -> Rows:
        """What the model says, one call for each state and action."""
        counts: list[int] = []
        successor: list[int] = []
        probability: list[Floats] = []
        for number in states.tolist():
            state = self._states[number]
            legal = self.mdp.actions(state)
            for action in range(self.n_actions):
                reached, chances = self.mdp.row(state, action) if action in legal else ((), np.zeros(0))
                counts.append(len(reached))
                successor += [self.number(each) for each in reached]
                probability.append(chances)
        offset = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        told = np.fromiter(chain.from_iterable(probability), float, count=len(successor))
        return Rows(offset, np.array(successor, np.int64), told)

    def reach_bound(self, states: Ints, goals: Ints) -> Floats:
        """As ``LocalWorld.reach_bound``; a heuristic is given numbers."""
        return one_step_bound(self.discount, self.heuristic, states, goals)

    def check(self, what: str, states: Any) -> Ints:
        """As ``LocalWorld.check``; a state exists once it has a number."""
        return check_states(what, states, len(self._states))

    def fingerprint(self) -> str | None:
        """None: functions cannot be told apart."""
        return None


def one_step_bound(discount: float, heuristic: Heuristic | None, states: Ints, goals: Ints) -> Floats:
    """(M, G) γ where the state is not the goal and one where it is, or what the heuristic says if that is less."""
    bound = np.where(states[:, None] == goals, 1.0, discount)
    if heuristic is None:
        return bound
    told = np.asarray(heuristic(states, goals), float)
    if told.shape != bound.shape or not (told >= 0).all():
        found = f"shape {told.shape}" if told.shape != bound.shape else f"{told.min():g}"
        raise InputError("heuristic", found=found, wanted=f"numbers of at least 0, shape {bound.shape}")
    return np.asarray(np.minimum(bound, told))


def set_bound(world: LocalWorld, states: Ints, members: Ints) -> Floats:
    """(M,) upper bounds of E[γ^T] until any of some states is reached: no more than the sum over them, nor than γ."""
    total = np.zeros(states.size)
    for member in members:
        total += world.reach_bound(states, np.array([member]))[:, 0]
    there = np.isin(states, members)
    return np.where(there, 1.0, np.minimum(total, world.discount))


def local_world(world: Any) -> LocalWorld:
    """``world`` as planning inside an envelope sees it. Raises ``InputError`` for what is no world."""
    if isinstance(world, TabularMDP):
        return TableWorld(world)
    if isinstance(world, ImplicitMDP):
        hint = "subgoal.mdp.NumberedWorld(world), whose number(state) says what demonstrations contain"
        found = "an ImplicitMDP, whose states have no numbers"
        raise InputError("mdp", found=found, wanted="a numbered one", hint=hint)
    if not all(hasattr(world, name) for name in WORLD):
        wanted = "a TabularMDP, GridWorld, ImplicitGrid or another LocalWorld"
        raise InputError("mdp", found=type(world).__name__, wanted=wanted)
    told: LocalWorld = world
    return told
