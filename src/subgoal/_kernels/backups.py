"""Bellman backups over a sparse transition table; row s·A + a is entries offset[row] to offset[row + 1].

A row without entries is an action that is not available. ``reward`` is (S,) or (S·A,); in terminal states, which have
no rows, ``ending`` (S,) is the value. No reward is ever written to, and no value but ``out`` and ``spare``.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def look_ahead(row, offset, successor, probability, value):
    """Σ P(s' | s, a) v(s') of one row."""
    total = 0.0
    for k in range(offset[row], offset[row + 1]):
        total += probability[k] * value[successor[k]]
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def best_of(state, offset, successor, probability, reward, n_actions, discount, value):
    """max_a r + γ Σ P v in a state that has actions."""
    each = reward.size != (offset.size - 1) // n_actions
    top = -np.inf
    for row in range(state * n_actions, (state + 1) * n_actions):
        if offset[row] < offset[row + 1]:
            gain = discount * look_ahead(row, offset, successor, probability, value)
            if each:
                gain += reward[row]
            if gain > top:
                top = gain
    return top if each else top + reward[state]


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_jacobi(
    sweeps, stop, offset, successor, probability, terminal, reward, ending, n_actions, discount, value, out, spare
):
    """Up to ``sweeps`` of v ← max_a r + γ P v from ``value`` into ``out``, until none changes a value by over ``stop``.

    Returns (sweeps made, largest change of the last).
    """
    n_states = terminal.size
    change, made = np.inf, 0
    out[:] = value
    source, target = out, spare
    while made < sweeps and not change <= stop:
        change = 0.0
        for state in range(n_states):
            if terminal[state]:
                target[state] = ending[state]
            else:
                target[state] = best_of(state, offset, successor, probability, reward, n_actions, discount, source)
            change = max(change, abs(target[state] - source[state]))
        source, target = target, source
        made += 1
    if made % 2:
        out[:] = spare
    return made, change


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_in_place(
    sweeps, stop, offset, successor, probability, terminal, reward, ending, n_actions, discount, value, out
):
    """As ``sweep_jacobi``, each state using the newest values of the others, from front to back and back in turn."""
    n_states = terminal.size
    change, made = np.inf, 0
    out[:] = value
    while made < sweeps and not change <= stop:
        change = 0.0
        for k in range(n_states):
            state = k if made % 2 == 0 else n_states - 1 - k
            if terminal[state]:
                new = ending[state]
            else:
                new = best_of(state, offset, successor, probability, reward, n_actions, discount, out)
            change = max(change, abs(new - out[state]))
            out[state] = new
        made += 1
    return made, change


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_policy(
    sweeps, stop, offset, successor, probability, terminal, reward, ending, n_actions, discount, policy, value, out,
    spare,
):  # fmt: skip
    """As ``sweep_jacobi`` with the action of each state fixed: v ← r_π + γ P_π v."""
    n_states = terminal.size
    each = reward.size != n_states
    change, made = np.inf, 0
    out[:] = value
    source, target = out, spare
    while made < sweeps and not change <= stop:
        change = 0.0
        for state in range(n_states):
            if terminal[state]:
                target[state] = ending[state]
            else:
                row = state * n_actions + policy[state]
                gain = discount * look_ahead(row, offset, successor, probability, source)
                target[state] = gain + reward[row if each else state]
            change = max(change, abs(target[state] - source[state]))
        source, target = target, source
        made += 1
    if made % 2:
        out[:] = spare
    return made, change


@njit(cache=True, nogil=True, error_model="numpy")
def greedy_backup(
    margin, offset, successor, probability, terminal, reward, ending, n_actions, discount, value, kept, out, policy
):
    """One backup of every state into ``out``, and the action that gives it into ``policy``, −1 in terminal states.

    Of the actions within ``margin`` of the best: that of ``kept`` if it is one of them (−1: none is kept), else the
    one of lowest index. Returns the lowest and the highest change.
    """
    each = reward.size != terminal.size
    low, high = np.inf, -np.inf
    gains = np.empty(n_actions)
    for state in range(terminal.size):
        policy[state] = -1
        if terminal[state]:
            out[state] = ending[state]
        else:
            top = -np.inf
            for action in range(n_actions):
                row = state * n_actions + action
                gains[action] = -np.inf
                if offset[row] < offset[row + 1]:
                    ahead = discount * look_ahead(row, offset, successor, probability, value)
                    gains[action] = ahead + reward[row if each else state]
                    top = max(top, gains[action])
            out[state] = top
            if kept[state] >= 0 and gains[kept[state]] >= top - margin:
                policy[state] = kept[state]
            else:
                action = 0
                while not gains[action] >= top - margin and action < n_actions - 1:
                    action += 1
                policy[state] = action
        low, high = min(low, out[state] - value[state]), max(high, out[state] - value[state])
    return low, high
