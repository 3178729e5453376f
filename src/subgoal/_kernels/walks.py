"""Walks through a tabular world, one draw at a time."""

from __future__ import annotations

from numba import njit

from subgoal._kernels.draws import choose


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
            action = choose(chances[state * n_actions : (state + 1) * n_actions], n_actions, generator)
        states[count] = state
        actions[count] = action
        count += 1
        first, last = offset[state * n_actions + action], offset[state * n_actions + action + 1]
        state = successor[first + choose(probability[first:last], last - first, generator)]
    return count, state
