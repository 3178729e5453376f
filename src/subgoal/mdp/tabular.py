"""``TabularMDP``: a finite Markov decision process without a reward (thesis 2.1), successors stored sparsely."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from subgoal.runtime.checks import Bools, Floats, Ints, copied, frozen, real_array, whole
from subgoal.runtime.errors import InputError

ROW_TOLERANCE = 1e-8
"""How far the probabilities of a row may sum from one."""


@dataclass(frozen=True, eq=False, repr=False)
class TabularMDP:
    """S states, A actions, P(s' | s, a) and a discount; what is rewarded is somebody else's affair.

    One convention for endings: an episode is over on entering a terminal state. No action is taken there, its rows are
    empty, and its value is its own state reward R(s), collected once.

    Attributes
    ----------
    offset:
        (S·A + 1,) row s·A + a of the transition table is entries ``offset[s·A + a]`` to ``offset[s·A + a + 1]``.
    successor, probability:
        (entries,) states s' and P(s' | s, a).
    n_actions:
        A.
    discount:
        γ in [0, 1]; 1 only if a terminal state can be reached from everywhere.
    available:
        (S, A) booleans: legal actions. Not given: all, in every state that is not terminal.
    terminal:
        (S,) booleans; not given: none.
    start:
        (S,) probabilities of the first state, or None.
    reward:
        (S, A) expected immediate reward that the world came with, or None.
    coordinates:
        (S, d) where the states lie, for distances and pictures, or None.
    action_names:
        A labels.

    Raises
    ------
    InputError
        Rows that do not sum to one within 1e-8, negative probabilities, successors that do not exist, an action in a
        terminal state, a state without any action: each naming state and action.
    """

    offset: Ints
    successor: Any
    probability: Floats
    n_actions: int
    discount: float
    available: Any = None
    terminal: Any = None
    start: Any = None
    reward: Any = None
    coordinates: Any = None
    action_names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        n_actions = whole("n_actions", self.n_actions)
        offset = _integers("offset", self.offset)
        if offset.size < 2 or (offset.size - 1) % n_actions or offset[0] != 0 or (np.diff(offset) < 0).any():
            wanted = f"S·{n_actions} + 1 numbers from 0 that do not fall"
            raise InputError("offset", found=f"{offset.size} numbers", wanted=wanted)
        shape = ((offset.size - 1) // n_actions, n_actions)
        terminal = _booleans("terminal", self.terminal, shape[:1], np.zeros(shape[0], bool))
        available = _booleans("available", self.available, shape, np.broadcast_to(~terminal[:, None], shape))
        self._set(n_actions=n_actions, offset=frozen(offset), terminal=terminal, available=available)
        self._set(discount=check_discount(self.discount), action_names=_names(self.action_names, n_actions))
        self._check_rows()
        self._set(start=_start(self.start, shape[0]), reward=_optional("reward", self.reward, shape))
        coordinates = _optional("coordinates", self.coordinates, (shape[0], -1))
        self._set(coordinates=coordinates)
        if self.discount == 1.0:
            self._check_endings()

    def __repr__(self) -> str:
        ends = f", {int(self.terminal.sum())} terminal" if self.terminal.any() else ""
        return f"TabularMDP({self.n_states} states × {self.n_actions} actions, discount {self.discount:g}{ends})"

    @classmethod
    def from_dense(cls, transition: Any, discount: float, **fields: Any) -> TabularMDP:
        """From P(s' | s, a) as an array (S, A, S); rows of illegal actions and of terminal states are all zero.

        ``available`` and ``terminal`` are read off the zero rows unless given among the other ``fields``.
        """
        table = real_array("transition", transition, ndim=3)
        states, actions, successors = table.shape
        if states != successors or not table.size:
            raise InputError("transition", found=f"shape {table.shape}", wanted="(S, A, S)")
        rows = sparse.csr_array(table.reshape(-1, states))
        full = (table != 0).any(axis=2)
        fields.setdefault("terminal", ~full.any(axis=1))
        fields.setdefault("available", full)
        return cls(rows.indptr.astype(np.int64), rows.indices, rows.data, actions, discount, **fields)

    @classmethod
    def from_gymnasium(cls, env: Any, *, discount: float) -> TabularMDP:
        """From a Gymnasium environment that carries its table; see ``subgoal.mdp.gym.from_gymnasium``."""
        from subgoal.mdp.gym import from_gymnasium

        return from_gymnasium(env, discount=discount)

    @classmethod
    def from_callable(
        cls, model: Any, starts: Iterable[Hashable], *, n_actions: int, discount: float, available: Any = None
    ) -> tuple[TabularMDP, tuple[Hashable, ...]]:
        """From ``model(state, action)``: what can be reached from ``starts``, and its states; see ``ImplicitMDP``."""
        from subgoal.mdp.implicit import ImplicitMDP

        return ImplicitMDP(model, n_actions, discount, available).tabulate(starts)

    @property
    def n_states(self) -> int:
        """S."""
        return (len(self.offset) - 1) // self.n_actions

    @property
    def n_entries(self) -> int:
        """Entries of the transition table."""
        return len(self.successor)

    @cached_property
    def matrix(self) -> sparse.csr_array:
        """(S·A, S) the transition table; empty rows for illegal actions and terminal states."""
        shape = (len(self.offset) - 1, self.n_states)
        return sparse.csr_array((self.probability, self.successor, self.offset), shape=shape)

    def row(self, state: int, action: int) -> tuple[Ints, Floats]:
        """Successors and probabilities of one action."""
        check_states("state", state, self.n_states)
        if not isinstance(action, (int, np.integer)) or not 0 <= action < self.n_actions:
            raise InputError("action", found=repr(action), wanted=f"0 to {self.n_actions - 1}")
        entries = slice(self.offset[state * self.n_actions + action], self.offset[state * self.n_actions + action + 1])
        return self.successor[entries].astype(np.int64), self.probability[entries]

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _check_rows(self) -> None:
        probability = real_array("probability", self.probability, ndim=1)
        successor = copied("successor", self.successor)
        if successor.dtype.kind not in "iu" or successor.shape != probability.shape:
            found = f"{successor.dtype} of shape {successor.shape}"
            raise InputError("successor", found=found, wanted=f"integers of shape {probability.shape}")
        if self.offset[-1] != probability.size:
            raise InputError("offset", found=f"{self.offset[-1]} entries", wanted=f"{probability.size}")
        for what, values, bad in (
            ("successor", successor, (successor < 0) | (successor >= self.n_states)),
            ("probability", probability, ~(probability >= 0)),
        ):
            if bad.any():
                k = int(np.argmax(bad))
                place = self._place(int(np.searchsorted(self.offset, k, side="right")) - 1)
                wanted = f"a state of 0 to {self.n_states - 1}" if what == "successor" else "at least 0"
                raise InputError(what, where=place, found=values[k], wanted=wanted)
        self._set(successor=frozen(np.array(successor, np.int32)), probability=probability)
        self._check_sums()

    def _check_sums(self) -> None:
        empty = np.diff(self.offset) == 0
        sums = np.zeros(empty.size)
        if self.probability.size:
            sums[~empty] = np.add.reduceat(self.probability, self.offset[:-1][~empty])
        legal = self.available.ravel()
        for what, bad, wanted in (
            ("transition row", legal & ~(np.abs(sums - 1) <= ROW_TOLERANCE), "1 within 1e-8"),
            ("transition row of an action that is not available", ~legal & ~empty, "no successors"),
        ):
            if bad.any():
                row = int(np.argmax(bad))
                raise InputError(what, where=self._place(row), found=f"probabilities that sum to {sums[row]:.12g}",
                                 wanted=wanted)  # fmt: skip
        idle = ~self.available.any(axis=1) & ~self.terminal
        busy = self.available.any(axis=1) & self.terminal
        for bad, found, wanted in (
            (idle, "no action", "one at least, or a terminal state"),
            (busy, "an action in a terminal state", "none: the episode is over there"),
        ):
            if bad.any():
                raise InputError("available", where=f"state {int(np.argmax(bad))}", found=found, wanted=wanted)

    def _place(self, row: int) -> str:
        return f"state {row // self.n_actions}, action {row % self.n_actions}"

    def _check_endings(self) -> None:
        """With discount 1 the total reward is only finite if episodes end."""
        n_states = self.n_states
        leads = sparse.coo_array(self.matrix)
        ends = np.flatnonzero(self.terminal)
        before = np.concatenate([leads.col, np.full(ends.size, n_states)])
        after = np.concatenate([leads.row // self.n_actions, ends])
        backwards = sparse.csr_array((np.ones(before.size), (before, after)), shape=(n_states + 1, n_states + 1))
        reached = np.zeros(n_states + 1, bool)
        reached[csgraph.breadth_first_order(backwards, n_states, return_predecessors=False)] = True
        reached = reached[:-1]
        if not reached.all():
            state = int(np.argmin(reached))
            raise InputError("discount", found=1.0, wanted=f"below 1: no terminal state is reached from state {state}")


def check_world(mdp: Any) -> None:
    """Raise ``InputError`` for anything but a ``TabularMDP``, with a hint for what has one."""
    if not isinstance(mdp, TabularMDP):
        hint = "world.mdp" if hasattr(mdp, "mdp") else None
        raise InputError("mdp", found=type(mdp).__name__, wanted="a TabularMDP", hint=hint)


def check_states(what: str, states: Any, n_states: int) -> Ints:
    """``states`` as integers, each an existing state; raises ``InputError`` naming the index."""
    array = copied(what, states)
    if array.dtype.kind not in "iu":
        raise InputError(what, found=f"{array.dtype} of shape {array.shape}", wanted="integers")
    outside = (array < 0) | (array >= n_states)
    if outside.any():
        k = int(np.argmax(outside))
        where = f"index {k}" if array.ndim else None
        raise InputError(what, where=where, found=int(array.ravel()[k]), wanted=f"a state of 0 to {n_states - 1}")
    return array.astype(np.int64)


def _integers(what: str, value: Any) -> Ints:
    array = copied(what, value)
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InputError(what, found=f"{array.dtype} of shape {array.shape}", wanted="integers of one dimension")
    return array.astype(np.int64)


def _booleans(what: str, value: Any, shape: tuple[int, ...], default: NDArray[np.bool_]) -> Bools:
    array = copied(what, default if value is None else value)
    if array.dtype != bool or array.shape != shape:
        raise InputError(what, found=f"{array.dtype} of shape {array.shape}", wanted=f"booleans of shape {shape}")
    return np.asarray(frozen(array))


def check_discount(value: Any) -> float:
    """``value`` as a number from 0 to 1; raises ``InputError`` for others."""
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = float("nan")
    if not 0 <= number <= 1:
        raise InputError("discount", found=repr(value), wanted="a number from 0 to 1")
    return number


def _names(names: Sequence[str], count: int) -> tuple[str, ...]:
    if names and len(names) != count:
        raise InputError("action_names", found=f"{len(names)} names", wanted=f"{count}")
    return tuple(str(name) for name in names) or tuple(str(k) for k in range(count))


def _start(value: Any, n_states: int) -> Any:
    start = _optional("start", value, (n_states,))
    if start is not None and not ((start >= 0).all() and abs(start.sum() - 1) <= ROW_TOLERANCE):
        raise InputError("start", found=f"numbers that sum to {start.sum():.12g}", wanted="probabilities that sum to 1")
    return start


def _optional(what: str, value: Any, shape: tuple[int, ...]) -> Any:
    if value is None:
        return None
    array = real_array(what, value, ndim=len(shape))
    if any(wanted not in (-1, size) for size, wanted in zip(array.shape, shape, strict=True)):
        raise InputError(what, found=f"shape {array.shape}", wanted=str(shape).replace("-1", "d"))
    return array
