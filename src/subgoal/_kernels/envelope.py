"""Loops of planning inside an envelope: which states are in it, their rows in order, and where a policy leaves it.

States of the world are any 64-bit numbers; inside they have places 0, 1, 2 … in the order in which they were met.
"""

from __future__ import annotations

import numpy as np
from numba import njit

EMPTY = -1
"""Place of a slot of the hash table that nothing is in."""


@njit(cache=True, nogil=True, error_model="numpy")
def slot_of(state, mask):
    """Where to look first for ``state`` in a hash table of ``mask`` + 1 slots (multiplicative hashing)."""
    mixed = np.uint64(state) * np.uint64(0x9E3779B97F4A7C15)
    mixed ^= mixed >> np.uint64(32)
    return np.int64(mixed & np.uint64(mask))


@njit(cache=True, nogil=True, error_model="numpy")
def places_of(states, key, place, out):
    """Write ``out`` (M,): the place of each of ``states``, −1 for those that were not met."""
    mask = key.size - 1
    for k in range(states.size):
        at = slot_of(states[k], mask)
        while place[at] != EMPTY and key[at] != states[k]:
            at = (at + 1) & mask
        out[k] = place[at]


@njit(cache=True, nogil=True, error_model="numpy")
def meet(states, begin, key, place, count, known, out):
    """As ``places_of`` from ``states[begin]`` on, giving the next place to states not met before.

    Stops when the hash table is half full or ``known`` (room,) is full; returns how many are known then, and where it
    stopped. Writes ``key``, ``place`` and ``known``.
    """
    mask = key.size - 1
    most = min(known.size, key.size // 2)
    for k in range(begin, states.size):
        at = slot_of(states[k], mask)
        while place[at] != EMPTY and key[at] != states[k]:
            at = (at + 1) & mask
        if place[at] == EMPTY:
            if count == most:
                return count, k
            key[at], place[at] = states[k], count
            known[count] = states[k]
            count += 1
        out[k] = place[at]
    return count, states.size


@njit(cache=True, nogil=True, error_model="numpy")
def rows_in_order(first, number, row_edge, to, weight, gain):
    """Rows of all states by place: ``state_edge`` (S+1,), ``row_edge`` (R+1,), ``to``, ``weight``, ``gain`` (R,).

    State s has the ``number[s]`` compressed rows from ``first[s]`` on, as they were appended.
    """
    n_states = first.size
    state_edge = np.zeros(n_states + 1, np.int64)
    entries = 0
    for s in range(n_states):
        state_edge[s + 1] = state_edge[s] + number[s]
        entries += row_edge[first[s] + number[s]] - row_edge[first[s]]
    rows = state_edge[n_states]
    edge_out, gain_out = np.zeros(rows + 1, np.int64), np.empty(rows)
    to_out, weight_out = np.empty(entries, np.uint32), np.empty(entries)
    row, entry = 0, 0
    for s in range(n_states):
        for r in range(first[s], first[s] + number[s]):
            for k in range(row_edge[r], row_edge[r + 1]):
                to_out[entry], weight_out[entry] = to[k], weight[k]
                entry += 1
            gain_out[row] = gain[r]
            row += 1
            edge_out[row] = entry
    return state_edge, edge_out, to_out, weight_out, gain_out


@njit(cache=True, nogil=True, error_model="numpy")
def sweep_order(near, inside):
    """States to back up: those of ``near`` that are ``inside``, in that order, and then the others that are."""
    order = np.empty(inside.sum(), np.int64)
    listed = np.zeros(inside.size, np.bool_)
    count = 0
    for s in near:
        if inside[s]:
            order[count] = s
            listed[s] = True
            count += 1
    for s in range(inside.size):
        if inside[s] and not listed[s]:
            order[count] = s
            count += 1
    return order


@njit(cache=True, nogil=True, error_model="numpy")
def best_row(s, lane, state_edge, row_edge, to, weight, gain, reward, value):
    """Largest gain·R(s) + Σ weight·value[to, lane] over the rows of state ``s``, and which row has it, −1 if none."""
    best, chosen = -np.inf, -1
    for r in range(state_edge[s], state_edge[s + 1]):
        total = gain[r] * reward[s]
        for k in range(row_edge[r], row_edge[r + 1]):
            total += weight[k] * value[to[k], lane]
        if total > best:
            best, chosen = total, r
    return best, chosen


@njit(cache=True, nogil=True, error_model="numpy")
def settle_reward(order, target, most_sweeps, state_edge, row_edge, to, weight, gain, reward, value):
    """Back up ``value`` (S, L) in ``order`` and back in turn until no value moves by more than ``target``.

    Where episodes are over, a value is the reward. Returns the number of sweeps.
    """
    for sweep in range(most_sweeps):
        largest = 0.0
        for k in range(order.size):
            s = order[order.size - 1 - k] if sweep % 2 else order[k]
            for lane in range(value.shape[1]):
                best, chosen = best_row(s, lane, state_edge, row_edge, to, weight, gain, reward, value)
                if chosen < 0:
                    best = reward[s]
                largest = max(largest, abs(best - value[s, lane]))
                value[s, lane] = best
        if largest <= target:
            return sweep + 1
    return most_sweeps


@njit(cache=True, nogil=True, error_model="numpy")
def leaving(
    order, roots, lane, stops, least, most_sweeps, state_edge, row_edge, to, weight, gain, reward, inside, value,
    outside, excess,
):  # fmt: skip
    """Add to ``excess`` (S,) what greedy behaviour from the ``roots`` expects of states outside, discounted.

    One unit of mass starts at each root and follows the rows that are best under ``value[:, lane]``, losing γ a step,
    until it reaches one of ``stops`` (S,) or leaves the envelope at a state that is not ``inside``, where mass times
    ``outside`` (S,) is added. Mass below ``least`` is let go. States are gone through in the reverse of ``order`` and
    then in it, in turn.
    """
    mass = np.zeros(inside.size)
    chosen = np.full(inside.size, -2, np.int64)
    for r in roots:
        mass[r] += 1.0
    for sweep in range(most_sweeps):
        moved = False
        for k in range(order.size):
            s = order[k] if sweep % 2 else order[order.size - 1 - k]
            here = mass[s]
            if here <= least:
                continue
            mass[s] = 0.0
            if stops[s]:
                continue
            if chosen[s] == -2:
                _, chosen[s] = best_row(s, lane, state_edge, row_edge, to, weight, gain, reward, value)
            if chosen[s] < 0:
                continue
            moved = True
            for e in range(row_edge[chosen[s]], row_edge[chosen[s] + 1]):
                t = to[e]
                if inside[t]:
                    mass[t] += here * weight[e]
                else:
                    excess[t] += here * weight[e] * outside[t]
        if not moved:
            break
