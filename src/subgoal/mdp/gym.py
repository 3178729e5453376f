"""Tabular worlds out of Gymnasium's toy environments, which carry their transition table with them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from subgoal.mdp.entries import assembled
from subgoal.mdp.tabular import TabularMDP, check_discount
from subgoal.runtime.checks import Bools, Ints, real_array
from subgoal.runtime.errors import InputError


class _Entries(NamedTuple):
    """(entries,) each: what ``P[state][action]`` holds."""

    state: Ints
    action: Ints
    chance: Any
    after: Ints
    reward: Any
    over: Bools


def from_gymnasium(env: Any, *, discount: float) -> TabularMDP:
    """The world of an environment with a table ``P``: FrozenLake, CliffWalking, Taxi and others made alike.

    Rewards become the expected r(s, a), and the distribution of the first state is taken over if there is one. A state
    that is only ever entered with the end of the episode is terminal, whatever rows it has of its own. One that is also
    entered otherwise, or started in (as the table of Taxi has it), stays as it is, and a terminal twin of it is added
    after the last state, so that the numbers of Gymnasium hold. Time limits are no part of the world.

    Raises
    ------
    InputError
        No table, states or actions that are not numbered from 0, probabilities that do not sum to one: naming state
        and action.
    """
    table = getattr(getattr(env, "unwrapped", env), "P", None)
    if table is None:
        hint = "ImplicitMDP for a world that is told by a function"
        raise InputError("env", found=f"{env} without a table P", wanted="an environment that has one", hint=hint)
    gamma, entries = check_discount(discount), _read(table)
    n_states, n_actions = len(table), int(entries.action.max()) + 1
    start = _start(env, n_states)
    terminal, twins = _terminal(entries, n_states, np.zeros(n_states, bool) if start is None else start > 0)
    twin = np.full(n_states, -1)
    twin[twins] = n_states + np.arange(twins.size)
    alive = ~terminal[entries.state]
    row = (entries.state * n_actions + entries.action)[alive]
    chance, over = entries.chance[alive], entries.over[alive]
    after = np.where(over & (twin[entries.after[alive]] >= 0), twin[entries.after[alive]], entries.after[alive])
    total = n_states + twins.size
    reward = np.bincount(row, chance * entries.reward[alive], minlength=total * n_actions)
    return assembled(
        row, after, chance, n_states=total, n_actions=n_actions, discount=gamma,
        terminal=np.append(terminal, np.ones(twins.size, bool)), reward=reward.reshape(total, n_actions),
        start=None if start is None else np.append(start, np.zeros(twins.size)),
    )  # fmt: skip


def _read(table: Any) -> _Entries:
    """Entries of a chance above zero."""
    try:
        return _entries(table)
    except InputError:
        raise
    except (AttributeError, IndexError, KeyError, OverflowError, TypeError, ValueError) as problem:
        wanted = "state -> action -> list of (probability, next state, reward, terminated)"
        raise InputError("env.P", found=f"another form ({problem})", wanted=wanted) from None


def _entries(table: Any) -> _Entries:
    if set(table) != set(range(len(table))) or not len(table):
        raise InputError("env.P", found=f"{len(table)} states of other numbers", wanted="states numbered from 0")
    found: list[tuple[int, int, float, int, float, bool]] = []
    for state in range(len(table)):
        for action, rows in dict(table[state]).items():
            where = f"state {state}, action {action}"
            if not isinstance(action, (int, np.integer)) or action < 0:
                raise InputError("env.P", where=where, found=repr(action), wanted="actions numbered from 0")
            for chance, after, reward, over in rows:
                if not chance >= 0:
                    raise InputError("env.P", where=where, found=f"a probability of {chance}", wanted="at least 0")
                if after not in table:
                    raise InputError("env.P", where=where, found=f"state {after}", wanted="a state of the table")
                if chance > 0:
                    found.append((state, int(action), float(chance), int(after), float(reward), bool(over)))
    if not found:
        raise InputError("env.P", found="no transitions", wanted="at least one")
    columns = [np.array(column) for column in zip(*found, strict=True)]
    real_array("rewards of env.P", columns[4], ndim=1)
    return _Entries(*columns)


def _start(env: Any, n_states: int) -> Any:
    start = getattr(getattr(env, "unwrapped", env), "initial_state_distrib", None)
    if start is None:
        return None
    chances = real_array("initial_state_distrib", start, ndim=1)
    if chances.size != n_states:
        raise InputError("initial_state_distrib", found=f"{chances.size} numbers", wanted=f"{n_states}")
    return chances


def _terminal(entries: _Entries, n_states: int, begun: Bools) -> tuple[Bools, Ints]:
    """(S,) states that are entered with the end of the episode only, and those that are entered both ways.

    What a terminal state does does not count, but for ending in itself; it comes to count once the state turns out not
    to be terminal.
    """
    own = entries.state == entries.after
    terminal = np.zeros(n_states, bool)
    terminal[entries.after[entries.over]] = True
    while True:
        alive = ~terminal[entries.state]
        entered, ended = begun.copy(), np.zeros(n_states, bool)
        entered[entries.after[alive & ~entries.over]] = True
        ended[entries.after[(alive | own) & entries.over]] = True
        wrong = terminal & (entered | ~ended)
        if not wrong.any():
            return terminal, np.flatnonzero(ended & ~terminal)
        terminal &= ~wrong
