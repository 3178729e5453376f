"""Walks through a tabular world, one draw at a time."""

from __future__ import annotations

from numba import njit


@njit(cache=True, nogil=True)
def drawn(weights, first, last, generator):
    """Index from ``first`` to ``last`` − 1 with probability proportional to its weight; never one of weight zero."""
    total = 0.0
    for k in range(first, last):
        total += weights[k]
    target = generator.random() * total
    chosen = first
    for k in range(first, last):
        if weights[k] > 0.0:
            target -= weights[k]
            chosen = k
            if target < 0.0:
                break
    return chosen


@njit(cache=True, nogil=True)
def walk(state, fixed, chances, n_actions, offset, successor, probability, terminal, generator, states, actions):
    """Write a walk from ``state`` into ``states`` and ``actions`` (room for n steps); returns (steps, state after).

    The walk ends on entering a terminal state or when the room is full. ``fixed`` (S,) is the action of each state;
    where ``chances`` (S·A,) has entries, the action is drawn from it instead.
    """
    count = 0
    while count < states.size and not terminal[state]:
        action = fixed[state]
        if chances.size:
            action = drawn(chances, state * n_actions, (state + 1) * n_actions, generator) - state * n_actions
        states[count] = state
        actions[count] = action
        count += 1
        row = state * n_actions + action
        state = successor[drawn(probability, offset[row], offset[row + 1], generator)]
    return count, state
