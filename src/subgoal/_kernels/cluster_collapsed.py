"""Loops of the sampler ``cluster_collapsed``: tables are reassigned with their candidates summed out.

State: the table of each observation ``label`` (N,) and, drawn after the sweep, the candidate of each table ``dish``
(N,). Slots of ``order[:k]`` are occupied. What is held of each slot is told in ``_kernels.clusters``.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from subgoal._kernels.alg4 import leave, occupy, seat_to_candidate
from subgoal._kernels.clusters import add_row, relative_gain, share_candidates
from subgoal._kernels.collapsed_blocks import move_blocks
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def grown(array, rows):
    """``array`` with at least ``rows`` rows, those added being zero."""
    if array.shape[0] >= rows:
        return array
    larger = np.zeros((max(rows, 2 * array.shape[0]), array.shape[1]), array.dtype)
    larger[: array.shape[0]] = array
    return larger


@njit(cache=True, nogil=True)
def gather(start, tile, label, sums, walls):
    """Add the rows of ``tile`` to the sums of their tables; returns the arrays, which may grow."""
    for r in range(tile.shape[0]):
        slot = label[start + r]
        sums, walls = grown(sums, slot + 1), grown(walls, slot + 1)
        add_row(tile[r], 1, sums[slot], walls[slot])
    return sums, walls


@njit(cache=True, nogil=True)
def share_all(order, k, sums, walls, log_prior, share, support, held):
    """Shares of every occupied slot; ``held`` (slots,) is how many candidates each has."""
    for j in range(k):
        slot = order[j]
        held[slot], _ = share_candidates(sums[slot], walls[slot], log_prior, share[slot], support[slot])


@njit(cache=True, nogil=True)
def reassign(i, row, relative, label, size, order, rank, k, concentration, log_prior, sums, walls, share, support,
             held, spare_sums, spare_walls, spare_share, spare_support, work, generator):  # fmt: skip
    """Draw z_i: table C with weight n_C m(C with i)/m(C), a new one with weight η m({i}). Returns K.

    ``row`` and ``relative`` (G,) are ℓ[i] and L_ig / Σ_g p_g L_ig; the arrays need a free slot in ``order[k]``. An
    observation that stays leaves everything as it was.
    """
    slot = label[i]
    alone = size[slot] == 1
    spare_held = 0
    if not alone:
        spare_sums[:] = sums[slot]
        spare_walls[:] = walls[slot]
        add_row(row, -1, spare_sums, spare_walls)
        spare_held, _ = share_candidates(spare_sums, spare_walls, log_prior, spare_share, spare_support)
    k = leave(slot, size, order, rank, k)
    for j in range(k):
        other = order[j]
        if other == slot:
            work[j] = size[other] * relative_gain(spare_held, spare_share, spare_support, relative)
        else:
            work[j] = size[other] * relative_gain(held[other], share[other], support[other], relative)
    work[k] = concentration
    pick = choose(work, k + 1, generator)
    chosen = order[pick]
    size[chosen] += 1
    label[i] = chosen
    if pick == k:
        k += 1
        if not alone:
            sums[chosen] = 0.0
            walls[chosen] = 0
    if chosen != slot:
        if not alone:
            sums[slot] = spare_sums
            walls[slot] = spare_walls
            share[slot] = spare_share
            support[slot] = spare_support
            held[slot] = spare_held
        add_row(row, 1, sums[chosen], walls[chosen])
        held[chosen], _ = share_candidates(sums[chosen], walls[chosen], log_prior, share[chosen], support[chosen])
    return k


@njit(cache=True, nogil=True)
def reassign_rows(start, tile, relative, label, size, order, rank, k, concentration, log_prior, sums, walls, fresh,
                  fresh_walls, share, support, held, work, generator):  # fmt: skip
    """Reassign start..start+len(tile) and add each row to the fresh sums of its table.

    Returns K and the six arrays that grow with the number of slots.
    """
    g_count = tile.shape[1]
    spare_sums, spare_walls = np.empty(g_count), np.empty(g_count, np.int64)
    spare_share, spare_support = np.empty(g_count), np.empty(g_count, np.int64)
    for r in range(tile.shape[0]):
        i = start + r
        room = order[min(k, order.size - 1)] + 1
        if sums.shape[0] < room:
            sums, walls, fresh = grown(sums, room), grown(walls, room), grown(fresh, room)
            fresh_walls, share, support = grown(fresh_walls, room), grown(share, room), grown(support, room)
        k = reassign(
            i, tile[r], relative[r], label, size, order, rank, k, concentration, log_prior, sums, walls, share,
            support, held, spare_sums, spare_walls, spare_share, spare_support, work, generator,
        )  # fmt: skip
        add_row(tile[r], 1, fresh[label[i]], fresh_walls[label[i]])
    return k, sums, walls, fresh, fresh_walls, share, support


@njit(cache=True, nogil=True)
def draw_dishes(order, k, fresh, fresh_walls, log_prior, label, dish, theta, dishes, spare, work, generator):
    """Every table draws its candidate from p_g·Π L_ig; writes ``dish`` and ``theta``; returns the log likelihood."""
    total = 0.0
    for j in range(k):
        slot = order[j]
        spare[0] = np.where(fresh_walls[slot] > 0, -np.inf, fresh[slot])
        total += move_blocks(1, spare, log_prior, label, theta[:0], dishes, work, generator)
        dish[slot] = dishes[0]
    seat_to_candidate(label, dish, theta)
    return total


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, prior, log_prior, concentration, label, dish, keep, kept, log_likelihood, log_joint,
                 n_active, generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G); writes ``label``, ``dish``, ``kept`` and the traces."""
    n, g_count = table.shape
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    size, order, rank, held = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    theta, work, spare = np.empty(n, np.int32), np.empty(max(n, g_count) + 1), np.empty((1, g_count))
    dishes = np.empty(1, np.int64)
    sums, walls = gather(0, table, label, np.zeros((1, g_count)), np.zeros((1, g_count), np.int64))
    fresh, fresh_walls = np.zeros(sums.shape), np.zeros(walls.shape, np.int64)
    share, support = np.empty(sums.shape), np.empty(walls.shape, np.int64)
    rows = 0
    for s in range(keep.size):
        k = occupy(label, size, order, rank)
        share_all(order, k, sums, walls, log_prior, share, support, held)
        fresh[:] = 0.0
        fresh_walls[:] = 0
        k, sums, walls, fresh, fresh_walls, share, support = reassign_rows(
            0, table, relative, label, size, order, rank, k, concentration, log_prior, sums, walls, fresh, fresh_walls,
            share, support, held, work, generator,
        )  # fmt: skip
        log_likelihood[s] = draw_dishes(
            order, k, fresh, fresh_walls, log_prior, label, dish, theta, dishes, spare, work, generator
        )
        sums, walls, fresh, fresh_walls = fresh, fresh_walls, sums, walls
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
