"""``ImplicitMDP``: a world that is told by a function, for those too large to be written down."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.mdp.entries import assembled
from subgoal.mdp.tabular import ROW_TOLERANCE, TabularMDP, check_discount
from subgoal.runtime.checks import Floats, frozen, real_array, whole
from subgoal.runtime.errors import InputError

Model = Callable[[Any, int], tuple[Sequence[Hashable], Any]]


@dataclass(frozen=True, eq=False, repr=False)
class ImplicitMDP:
    """States that are any hashable things, and a function that says where an action leads.

    Attributes
    ----------
    model:
        ``model(state, action)`` gives the successors and their probabilities; a successor may be named twice.
    n_actions:
        A; actions are 0 to A − 1.
    discount:
        γ in [0, 1].
    available:
        ``available(state)`` gives the legal actions, none where the episode is over; not given: all, everywhere.
    """

    model: Model
    n_actions: int
    discount: float
    available: Callable[[Any], Iterable[int]] | None = None

    def __post_init__(self) -> None:
        for what, function in (("model", self.model), ("available", self.available)):
            if not callable(function) and not (what == "available" and function is None):
                raise InputError(what, found=type(function).__name__, wanted="a function")
        object.__setattr__(self, "n_actions", whole("n_actions", self.n_actions))
        object.__setattr__(self, "discount", check_discount(self.discount))

    def __repr__(self) -> str:
        return f"ImplicitMDP({self.n_actions} actions, discount {self.discount:g})"

    def actions(self, state: Hashable) -> tuple[int, ...]:
        """The legal actions of a state, ascending; none where the episode is over."""
        if self.available is None:
            return tuple(range(self.n_actions))
        where = f"state {state!r}"
        given = _listed("available", self.available(state), where)
        for action in given:
            if not isinstance(action, (int, np.integer)) or not 0 <= action < self.n_actions:
                wanted = f"actions of 0 to {self.n_actions - 1}"
                raise InputError("available", where=where, found=repr(action), wanted=wanted)
        return tuple(sorted({int(action) for action in given}))

    def row(self, state: Hashable, action: int) -> tuple[tuple[Hashable, ...], Floats]:
        """Distinct successors of one action and their probabilities, all above zero.

        Raises ``InputError`` naming state and action: not available, probabilities that do not sum to one within 1e-8
        or are below zero, or not as many as successors, successors that are not hashable.
        """
        where = f"state {state!r}, action {action!r}"
        if action not in self.actions(state):
            raise InputError("action", where=where, found="an action that is not available", wanted="a legal one")
        told = self.model(state, action)
        if not isinstance(told, tuple) or len(told) != 2:
            raise InputError("model", where=where, found=type(told).__name__, wanted="(successors, probabilities)")
        successors = _listed("model", told[0], where)
        chances = real_array(f"probabilities of {where}", told[1], ndim=1)
        if len(successors) != chances.size:
            found = f"{len(successors)} successors and {chances.size} probabilities"
            raise InputError("model", where=where, found=found, wanted="one probability for each successor")
        if (chances < 0).any() or not abs(chances.sum() - 1) <= ROW_TOLERANCE:
            sums = f"probabilities that sum to {chances.sum():.12g}"
            found = f"a probability of {chances.min():g}" if (chances < 0).any() else sums
            raise InputError("model", where=where, found=found, wanted="probabilities that sum to 1 within 1e-8")
        return _merged(successors, chances, where)

    def tabulate(
        self, starts: Iterable[Hashable], *, most_states: int = 1_000_000
    ) -> tuple[TabularMDP, tuple[Hashable, ...]]:
        """The part of the world that can be reached from ``starts``, and its states in the order in which they are met.

        Breadth first; the states of ``starts`` come first. Raises ``InputError`` when there are more than
        ``most_states``, and whatever ``row`` raises.
        """
        most, number = whole("most_states", most_states), dict[Hashable, int]()
        states: list[Hashable] = []
        row, successor, probability = list[int](), list[int](), list[Floats]()
        for state in _listed("starts", starts, None):
            if not isinstance(state, Hashable):
                wanted = "something hashable, as a tuple of numbers is"
                raise InputError("starts", found=f"a {type(state).__name__}", wanted=wanted)
            _meet(state, number, states, most)
        if not states:
            raise InputError("starts", found="no state", wanted="at least one")
        for at, state in enumerate(states):
            for action in self.actions(state):
                reached, chances = self.row(state, action)
                for each in reached:
                    _meet(each, number, states, most)
                row += [at * self.n_actions + action] * len(reached)
                successor += [number[each] for each in reached]
                probability.append(chances)
        mdp = assembled(
            row, successor, np.concatenate(probability) if probability else np.zeros(0), n_states=len(states),
            n_actions=self.n_actions, discount=self.discount,
        )  # fmt: skip
        return mdp, tuple(states)


def _listed(what: str, values: Any, where: str | None) -> list[Any]:
    """What can be gone through, as a list."""
    try:
        return list(values)
    except TypeError:
        raise InputError(what, where=where, found=repr(values), wanted="a list") from None


def _merged(successors: list[Any], chances: Floats, where: str) -> tuple[tuple[Hashable, ...], Floats]:
    sums: dict[Hashable, float] = {}
    for state, chance in zip(successors, chances, strict=True):
        if not isinstance(state, Hashable):
            wanted = "something hashable, as a tuple of numbers is"
            raise InputError("model", where=where, found=f"a successor that is a {type(state).__name__}", wanted=wanted)
        if chance > 0:
            sums[state] = sums.get(state, 0.0) + float(chance)
    return tuple(sums), np.asarray(frozen(np.array(list(sums.values()))))


def _meet(state: Hashable, number: dict[Hashable, int], states: list[Hashable], most: int) -> None:
    if state in number:
        return
    if len(states) == most:
        hint = "a larger most_states, or planning that does not need all states"
        raise InputError("states reached", found=f"more than {most}", wanted=f"{most} at most", hint=hint)
    number[state] = len(states)
    states.append(state)
