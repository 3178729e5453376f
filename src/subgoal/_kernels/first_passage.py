"""Loops of first-passage planning: many goals side by side in lanes, states in order of distance, only where it moves.

``value`` (S, L) holds L goals contiguously, so that one read of a transition row serves all of them. The rows are
compressed once for all goals: self-transitions are summed out exactly (v = Σ c·v' with c = γp/(1 − γp_self)) and what
cannot be done is left out. ``value`` and ``dirty`` are written, and what is called room or out.
"""

from __future__ import annotations

import numpy as np
from numba import njit

BLOCK = 1024
"""States that are swept together before going on to those further away."""
RELATIVE = 1e-13
"""Share of a value below which a change of it is rounding."""
REPEATS = 20
"""Sweeps over a block, at most, before going on."""


@njit(cache=True, nogil=True, error_model="numpy")
def compress_rows(offset, successor, probability, n_actions, discount, own):
    """Rows without self-transitions: ``state_edge`` (S+1,), ``row_edge`` (R+1,), ``to``, ``weight`` and ``gain`` (R,).

    Row r of state s is one of ``state_edge[s]:state_edge[s+1]``; its value is Σ weight·value[to], plus gain·reward.
    ``own`` (S,) is what ``successor`` calls each state.
    """
    n_states = own.size
    state_edge = np.zeros(n_states + 1, np.int64)
    row_edge = np.zeros(offset.size, np.int64)
    gain = np.empty(offset.size - 1)
    to = np.empty(successor.size, np.uint32)
    weight = np.empty(successor.size)
    rows, entries = 0, 0
    for s in range(n_states):
        for row in range(s * n_actions, (s + 1) * n_actions):
            if offset[row] == offset[row + 1]:
                continue
            stays = 0.0
            for k in range(offset[row], offset[row + 1]):
                if successor[k] == own[s]:
                    stays += probability[k]
            gain[rows] = 1.0 / (1.0 - discount * stays)
            for k in range(offset[row], offset[row + 1]):
                if successor[k] != own[s] and probability[k] > 0:
                    to[entries] = successor[k]
                    weight[entries] = discount * probability[k] * gain[rows]
                    entries += 1
            rows += 1
            row_edge[rows] = entries
        state_edge[s + 1] = rows
    return state_edge, row_edge[: rows + 1].copy(), to[:entries].copy(), weight[:entries].copy(), gain[:rows].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def find_predecessors(state_edge, row_edge, to):
    """``edge`` (S+1,) and ``before``: the states from which each state can be entered, each once."""
    n_states = state_edge.size - 1
    edge = np.zeros(n_states + 1, np.int64)
    last = np.full(n_states, -1, np.int64)
    for s in range(n_states):
        for k in range(row_edge[state_edge[s]], row_edge[state_edge[s + 1]]):
            if last[to[k]] != s:
                last[to[k]] = s
                edge[to[k] + 1] += 1
    for s in range(n_states):
        edge[s + 1] += edge[s]
    before = np.empty(edge[n_states], np.uint32)
    filled = edge[:-1].copy()
    last[:] = -1
    for s in range(n_states):
        for k in range(row_edge[state_edge[s]], row_edge[state_edge[s + 1]]):
            t = to[k]
            if last[t] != s:
                last[t] = s
                before[filled[t]] = s
                filled[t] += 1
    return edge, before


@njit(cache=True, nogil=True, error_model="numpy")
def distance_order(goals, edge, before):
    """States from which some goal can be reached, the nearest first (fewest transitions), goals at the head."""
    n_states = edge.size - 1
    order = np.empty(n_states, np.int64)
    seen = np.zeros(n_states, np.bool_)
    found = 0
    for g in goals:
        if not seen[g]:
            seen[g] = True
            order[found] = g
            found += 1
    at = 0
    while at < found:
        s = order[at]
        at += 1
        for k in range(edge[s], edge[s + 1]):
            t = before[k]
            if not seen[t]:
                seen[t] = True
                order[found] = t
                found += 1
    return order[:found]


@njit(cache=True, nogil=True, error_model="numpy")
def near_groups(places, edge, before, size, reach):
    """(G,) group of each goal: the first goal left over and up to ``size`` − 1 others that lie near it.

    ``places`` (G,) is where each goal lies, or the first state of its set. Near is what is among the ``reach`` states
    from which the first is entered soonest.
    """
    n_states = edge.size - 1
    first = np.full(n_states, -1, np.int64)
    following = np.full(places.size, -1, np.int64)
    for g in range(places.size - 1, -1, -1):
        following[g] = first[places[g]]
        first[places[g]] = g
    groups = np.full(places.size, -1, np.int64)
    queue = np.empty(n_states, np.int64)
    seen = np.full(n_states, -1, np.int64)
    group = 0
    for start in range(places.size):
        if groups[start] >= 0:
            continue
        queue[0], seen[places[start]] = places[start], start
        at, found, taken = 0, 1, 0
        while at < min(found, reach) and taken < size:
            s = queue[at]
            at += 1
            while first[s] >= 0 and taken < size:
                groups[first[s]] = group
                first[s] = following[first[s]]
                taken += 1
            for k in range(edge[s], edge[s + 1]):
                t = before[k]
                if seen[t] != start:
                    seen[t] = start
                    queue[found] = t
                    found += 1
        group += 1
    return groups


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def best_of_rows(s, state_edge, row_edge, to, weight, value, work, best):
    """Write ``best`` (L,): the largest Σ weight·value[to] over the rows of state ``s``, zero if there are none."""
    lanes = value.shape[1]
    for j in range(lanes):
        best[j] = 0.0
    for r in range(state_edge[s], state_edge[s + 1]):
        a, b = row_edge[r], row_edge[r + 1]
        if a == b:
            continue
        if b - a <= 3:
            second, third = min(a + 1, b - 1), min(a + 2, b - 1)
            c0, v0 = weight[a], value[to[a]]
            c1, v1 = weight[second] if b - a > 1 else 0.0, value[to[second]]
            c2, v2 = weight[third] if b - a > 2 else 0.0, value[to[third]]
            for j in range(lanes):
                sum3 = c0 * v0[j] + c1 * v1[j] + c2 * v2[j]
                best[j] = sum3 if sum3 > best[j] else best[j]
        else:
            for j in range(lanes):
                work[j] = 0.0
            for k in range(a, b):
                c, v = weight[k], value[to[k]]
                for j in range(lanes):
                    work[j] += c * v[j]
            for j in range(lanes):
                best[j] = work[j] if work[j] > best[j] else best[j]


@njit(cache=True, nogil=True, error_model="numpy")
def rewarded(s, j, state_edge, row_edge, to, weight, gain, value):
    """Value of a goal that pays one unit at every visit and is not left for good; one unit where episodes end."""
    best = 1.0 if state_edge[s] == state_edge[s + 1] else -np.inf
    for r in range(state_edge[s], state_edge[s + 1]):
        total = gain[r]
        for k in range(row_edge[r], row_edge[r + 1]):
            total += weight[k] * value[to[k], j]
        best = max(best, total)
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def redo_goals(s, mark, member, pinned, state_edge, row_edge, to, weight, gain, value, best):
    """Put right the lanes of ``best`` for which state ``s`` is a goal: one where pinned, else what it earns."""
    for j in range(best.size):
        if member[mark[s], j]:
            best[j] = 1.0 if pinned else rewarded(s, j, state_edge, row_edge, to, weight, gain, value)


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def take_over(best, old):
    """Write ``best`` into ``old`` (L,); returns Σ|best − old| and Σ best over the lanes."""
    moved, size = 0.0, 0.0
    for j in range(best.size):
        moved += abs(best[j] - old[j])
        size += best[j]
    for j in range(best.size):
        old[j] = best[j]
    return moved, size


@njit(cache=True, nogil=True, error_model="numpy")
def largest_gap(best, old):
    """The largest |best − old| over the lanes."""
    largest = 0.0
    for j in range(best.size):
        gap = abs(best[j] - old[j])
        largest = gap if gap > largest else largest
    return largest


@njit(cache=True, nogil=True, error_model="numpy")
def sweep(
    order, everything, relative, threshold, state_edge, row_edge, to, weight, gain, edge, before, mark, member, pinned,
    value, dirty, work, best,
):  # fmt: skip
    """Back up the dirty states in order (all of them if ``everything``); returns how many and the largest change.

    A state that moves by more than ``threshold`` (summed over the lanes; as a share of its value if ``relative``) makes
    its predecessors dirty; one that comes later in the order is backed up in the same sweep.
    """
    backups, largest = 0, 0.0
    for s in order:
        if not (everything or dirty[s]):
            continue
        dirty[s] = False
        backups += 1
        best_of_rows(s, state_edge, row_edge, to, weight, value, work, best)
        if mark[s] >= 0:
            redo_goals(s, mark, member, pinned, state_edge, row_edge, to, weight, gain, value, best)
        if everything:
            largest = max(largest, largest_gap(best, value[s]))
        moved, size = take_over(best, value[s])
        if moved > threshold * (size if relative else 1.0):
            for k in range(edge[s], edge[s + 1]):
                dirty[before[k]] = True
    return backups, largest


@njit(cache=True, nogil=True, error_model="numpy")
def settle(
    order, target, relative, most_sweeps, state_edge, row_edge, to, weight, gain, edge, before, mark, member, pinned,
    value,
):  # fmt: skip
    """Sweep until a whole pass moves nothing by more than ``target``; returns its largest change, sweeps, backups.

    Between whole passes only dirty states are backed up, a block of them several times while it is in cache: values
    flow outward from the goals, and what is not yet right is not carried further. After each whole pass the threshold
    for what counts as moved falls. If ``relative``, that is a share of the value, so that small values far from the
    goal are settled as well.
    """
    work, best = np.empty(value.shape[1]), np.empty(value.shape[1])
    dirty = np.zeros(value.shape[0], np.bool_)
    threshold, residual, sweeps, total = RELATIVE if relative else target, np.inf, 0, 0
    for s in order:
        if mark[s] >= 0:
            dirty[s] = True
            for k in range(edge[s], edge[s + 1]):
                dirty[before[k]] = True
    while sweeps < most_sweeps:
        done = total
        for begin in range(0, order.size, BLOCK):
            for _ in range(REPEATS):
                backups, _ = sweep(
                    order[begin : begin + BLOCK], False, relative, threshold, state_edge, row_edge, to, weight, gain,
                    edge, before, mark, member, pinned, value, dirty, work, best,
                )  # fmt: skip
                total += backups
                if backups == 0:
                    break
        sweeps += 1
        if total > done:
            continue
        backups, residual = sweep(
            order, True, relative, 0.1 * threshold, state_edge, row_edge, to, weight, gain, edge, before, mark, member,
            pinned, value, dirty, work, best,
        )  # fmt: skip
        sweeps, total, threshold = sweeps + 1, total + backups, 0.1 * threshold
        if residual <= target:
            break
    return residual, sweeps, total


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "reassoc"})
def action_rows(states, offset, successor, probability, n_actions, discount, value, out):
    """Write ``out`` (U, A, L): γ Σ P(s' | s, a)·value[s'] for each of ``states``; −inf for illegal actions."""
    for u in range(states.size):
        for a in range(n_actions):
            row = states[u] * n_actions + a
            mine = out[u, a]
            for j in range(mine.size):
                mine[j] = 0.0 if offset[row] < offset[row + 1] else -np.inf
            for k in range(offset[row], offset[row + 1]):
                c, v = discount * probability[k], value[successor[k]]
                for j in range(mine.size):
                    mine[j] += c * v[j]
