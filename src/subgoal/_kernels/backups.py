"""Bellman backups over a sparse transition table; row s·A + a is entries offset[row] to offset[row + 1].

A row without entries is an action that is not available. ``reward`` is (S,) or (S·A,); in terminal states, which have
no rows, ``ending`` (S,) is the value. No reward is ever written to, and no value but ``out`` and ``spare``.
"""

from __future__ import annotations

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def look_ahead(first, last, successor, probability, value):
    """Σ P(s' | s, a) v(s') over entries ``first`` to ``last`` − 1; inlined, as a call costs more than the sum."""
    total = 0.0
    for k in range(first, last):
        total += probability[k] * value[np.uint32(successor[k])]
    return total


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def best_of(state, each, offset, successor, probability, reward, n_actions, discount, value):
    """max_a r + γ Σ P v in a state that has actions; ``each`` if every action has a reward of its own."""
    top = -np.inf
    first = offset[state * n_actions]
    for row in range(state * n_actions, (state + 1) * n_actions):
        last = offset[row + 1]
        if first < last:
            gain = discount * look_ahead(first, last, successor, probability, value)
            if each:
                gain += reward[row]
            top = gain if gain > top else top
        first = last
    return top if each else top + reward[state]


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_jacobi(
    sweeps, stop, offset, successor, probability, terminal, reward, ending, n_actions, discount, value, out, spare
):
    """Up to ``sweeps`` of v ← max_a r + γ P v from ``value`` into ``out``, until none changes a value by over ``stop``.

    Returns (sweeps made, largest change of the last).
    """
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
                target[state] = best_of(
                    state, each, offset, successor, probability, reward, n_actions, discount, source
                )
            step = abs(target[state] - source[state])
            change = step if step > change else change
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
    each = reward.size != n_states
    change, made = np.inf, 0
    out[:] = value
    while made < sweeps and not change <= stop:
        change = 0.0
        for k in range(n_states):
            state = k if made % 2 == 0 else n_states - 1 - k
            if terminal[state]:
                new = ending[state]
            else:
                new = best_of(state, each, offset, successor, probability, reward, n_actions, discount, out)
            step = abs(new - out[state])
            change = step if step > change else change
            out[state] = new
        made += 1
    return made, change


@njit(cache=True, nogil=True, error_model="numpy")
def policy_rows(policy, offset, successor, probability, terminal, reward, ending, n_actions, discount):
    """The rows of one action per state, side by side: (first (S + 1,), to, weight = γ P, gain (S,)).

    Terminal states have no entries; their gain is what they are worth.
    """
    n_states = terminal.size
    each = reward.size != n_states
    first = np.zeros(n_states + 1, np.int64)
    gain = np.empty(n_states)
    for state in range(n_states):
        first[state + 1] = first[state]
        gain[state] = ending[state]
        if not terminal[state]:
            row = state * n_actions + policy[state]
            first[state + 1] += offset[row + 1] - offset[row]
            gain[state] = reward[row if each else state]
    to = np.empty(first[n_states], np.uint32)
    weight = np.empty(first[n_states])
    for state in range(n_states):
        if not terminal[state]:
            shift = offset[state * n_actions + policy[state]] - first[state]
            for k in range(first[state], first[state + 1]):
                to[k] = successor[k + shift]
                weight[k] = discount * probability[k + shift]
    return first, to, weight, gain


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_policy(sweeps, stop, first, to, weight, gain, value, out, spare):
    """As ``sweep_jacobi`` for one policy, v ← r_π + γ P_π v, its rows being those of ``policy_rows``."""
    change, made = np.inf, 0
    out[:] = value
    source, target = out, spare
    while made < sweeps and not change <= stop:
        change = 0.0
        for state in range(gain.size):
            new = gain[state]
            for k in range(first[state], first[state + 1]):
                new += weight[k] * source[to[k]]
            target[state] = new
            step = abs(new - source[state])
            change = step if step > change else change
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
                    ahead = discount * look_ahead(offset[row], offset[row + 1], successor, probability, value)
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
