"""Split-merge proposals on a partition into tables, candidates summed out (Jain & Neal 2004). Arrays are written.

Two observations are drawn. Those at their tables are parted between the two in a launch state that does not hang on
the present one; from it one restricted Gibbs scan proposes the split, or gives the probability with which it would
have proposed the present one. Side 0 is that of the first observation, side 1 that of the second.
"""

from __future__ import annotations

from math import exp, lgamma, log

import numpy as np
from numba import njit

from subgoal._kernels.clusters import add_row, relative_gain, share_candidates
from subgoal._kernels.collapsed_blocks import largest_first, move_blocks, redraw_rows, with_room
from subgoal._kernels.counts import log_assignment_prior, recount
from subgoal._kernels.draws import choose
from subgoal._kernels.seating import clear, seat_rows, seating_for


@njit(cache=True, nogil=True)
def others_at(table_of, first, second, others):
    """Write ``others``: who sits at the tables of ``first`` and ``second`` but for these two; returns how many."""
    count = 0
    for i in range(table_of.size):
        if (table_of[i] == table_of[first] or table_of[i] == table_of[second]) and i != first and i != second:
            others[count] = i
            count += 1
    return count


@njit(cache=True, nogil=True)
def enter(row, side, sign, log_prior, sizes, sums, walls, share, support, held, log_mass):
    """Bring a row to a side (``sign`` 1) or take it away (−1), and renew what is held of the side."""
    sizes[side] += sign
    add_row(row, sign, sums[side], walls[side])
    held[side], log_mass[side] = share_candidates(sums[side], walls[side], log_prior, share[side], support[side])


@njit(cache=True, nogil=True)
def begin_sides(table, first, second, log_prior, sizes, sums, walls, share, support, held, log_mass):
    """Each of the two observations on a side of its own."""
    sums[:] = 0.0
    walls[:] = 0
    sizes[:] = 0
    enter(table[first], 0, 1, log_prior, sizes, sums, walls, share, support, held, log_mass)
    enter(table[second], 1, 1, log_prior, sizes, sums, walls, share, support, held, log_mass)


@njit(cache=True, nogil=True)
def weigh_sides(relative, sizes, share, support, held, work):
    """Write the weights n_C·m(C with i)/m(C) of both sides for an observation that is on neither; returns their sum."""
    for side in range(2):
        work[side] = sizes[side] * relative_gain(held[side], share[side], support[side], relative)
    return work[0] + work[1]


@njit(cache=True, nogil=True)
def launch(table, relative, others, count, log_prior, side_of, sizes, sums, walls, share, support, held, log_mass, work,
           generator):  # fmt: skip
    """Part the others one after the other, given those before; whether every one of them had a possible side."""
    for c in range(count):
        i = others[c]
        if not weigh_sides(relative[i], sizes, share, support, held, work) > 0.0:
            return False
        side_of[c] = choose(work, 2, generator)
        enter(table[i], side_of[c], 1, log_prior, sizes, sums, walls, share, support, held, log_mass)
    return True


@njit(cache=True, nogil=True)
def restricted_scan(table, relative, others, count, log_prior, side_of, wanted, forced, sizes, sums, walls, share,
                    support, held, log_mass, work, generator):  # fmt: skip
    """Redraw the side of each of the others given all the rest; returns the log probability of what came out.

    With ``forced`` they are brought to the sides ``wanted`` instead of drawn.
    """
    log_probability = 0.0
    for c in range(count):
        i, old = others[c], side_of[c]
        enter(table[i], old, -1, log_prior, sizes, sums, walls, share, support, held, log_mass)
        total = weigh_sides(relative[i], sizes, share, support, held, work)
        new = wanted[c] if forced else choose(work, 2, generator)
        if not work[new] > 0.0:
            return -np.inf
        log_probability += log(work[new] / total)
        enter(table[i], new, 1, log_prior, sizes, sums, walls, share, support, held, log_mass)
        side_of[c] = new
    return log_probability


@njit(cache=True, nogil=True)
def log_mass_of_sums(sums, log_prior):
    """log Σ_g p_g e^{sums_g} of one table, −inf among the sums allowed."""
    peak = -np.inf
    for g in range(sums.size):
        peak = max(peak, sums[g] + log_prior[g])
    if peak == -np.inf:
        return -np.inf
    total = 0.0
    for g in range(sums.size):
        total += exp(sums[g] + log_prior[g] - peak)
    return peak + log(total)


@njit(cache=True, nogil=True)
def accept(log_ratio, work, generator):
    """Whether a proposal is taken, with probability min(1, e^log_ratio)."""
    work[0] = exp(min(log_ratio, 0.0))
    work[1] = 1.0 - work[0]
    return choose(work, 2, generator) == 0


@njit(cache=True, nogil=True)
def draw_pair(n, work, generator):
    """Two different observations, every ordered pair equally likely."""
    work[:n] = 1.0
    first = choose(work, n, generator)
    work[first] = 0.0
    return first, choose(work, n, generator)


@njit(cache=True, nogil=True)
def write_split(table, others, count, side_of, first, second, n_tables, table_of, sums):
    """Seat the second observation and its side at a new table; the sums of both tables are added up anew."""
    a = table_of[first]
    table_of[second] = n_tables
    sums[a] = table[first]
    sums[n_tables] = table[second]
    for c in range(count):
        i = others[c]
        to = n_tables if side_of[c] == 1 else a
        table_of[i] = to
        for g in range(table.shape[1]):
            sums[to, g] += table[i, g]


@njit(cache=True, nogil=True)
def write_merge(a, b, n_tables, table_of, sums):
    """Seat all of two tables at the lower-numbered one and give the last table the number that is free."""
    low, high, last = min(a, b), max(a, b), n_tables - 1
    for g in range(sums.shape[1]):
        sums[low, g] += sums[high, g]
        sums[high, g] = sums[last, g]
    for i in range(table_of.size):
        if table_of[i] == high:
            table_of[i] = low
        elif table_of[i] == last:
            table_of[i] = high


@njit(cache=True, nogil=True)
def propose(table, relative, log_prior, concentration, table_of, n_tables, sums, others, side_of, wanted, work,
            generator):  # fmt: skip
    """One split or merge, Metropolis-Hastings on p(z | O); returns the number of tables and the sums, which may grow.

    The ratio of p(z | O) after and before a split into A and B is η·Γ(n_A)Γ(n_B)/Γ(n_A + n_B)·m(A)m(B)/m(A with B).
    """
    g_count = table.shape[1]
    sizes, held, log_mass = np.zeros(2, np.int64), np.zeros(2, np.int64), np.zeros(2)
    side_sums, walls = np.zeros((2, g_count)), np.zeros((2, g_count), np.int64)
    share, support = np.empty((2, g_count)), np.empty((2, g_count), np.int64)
    first, second = draw_pair(table_of.size, work, generator)
    a, b = table_of[first], table_of[second]
    count = others_at(table_of, first, second, others)
    for c in range(count):
        wanted[c] = 0 if table_of[others[c]] == a else 1
    begin_sides(table, first, second, log_prior, sizes, side_sums, walls, share, support, held, log_mass)
    if not launch(
        table, relative, others, count, log_prior, side_of, sizes, side_sums, walls, share, support, held, log_mass,
        work, generator,
    ):  # fmt: skip
        return n_tables, sums
    log_proposal = restricted_scan(
        table, relative, others, count, log_prior, side_of, wanted, a != b, sizes, side_sums, walls, share, support,
        held, log_mass, work, generator,
    )  # fmt: skip
    if log_proposal == -np.inf:
        return n_tables, sums
    together = log_mass_of_sums(sums[a] if a == b else sums[a] + sums[b], log_prior)
    log_split = log(concentration) + lgamma(sizes[0]) + lgamma(sizes[1]) - lgamma(sizes[0] + sizes[1])
    log_split += log_mass[0] + log_mass[1] - together - log_proposal
    if a == b and accept(log_split, work, generator):
        sums = with_room(sums, n_tables + 1)
        write_split(table, others, count, side_of, first, second, n_tables, table_of, sums)
        n_tables += 1
    elif a != b and together > -np.inf and accept(-log_split, work, generator):
        write_merge(a, b, n_tables, table_of, sums)
        n_tables -= 1
    return n_tables, sums


@njit(cache=True, nogil=True)
def sweeps_dense(table, relative, edges, prior, log_prior, concentration, proposals, theta, sums, keep, kept,
                 log_likelihood, log_joint, n_active, generator):  # fmt: skip
    """``len(keep)`` sweeps over a dense table (N, G) in blocks of rows; writes ``theta``, ``kept`` and the traces."""
    n, g_count = table.shape
    counts, active, place = np.zeros(g_count, np.int64), np.empty(g_count, np.int64), np.empty(g_count, np.int64)
    seating, dishes = seating_for(n, g_count), np.empty(n, np.int64)
    others, side_of, wanted = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    held, work = np.empty(g_count), np.empty(max(n, g_count) + 2)
    mass = concentration * prior
    rows = 0
    for s in range(keep.size):
        k = recount(theta, counts, active, place)
        largest_first(counts, active, place, held, k)
        clear(seating)
        n_tables = 0
        for e in range(edges.size - 1):
            start, stop = edges[e], edges[e + 1]
            k = redraw_rows(
                start, relative[start:stop], theta, active, place, held, k, concentration, prior, work, generator
            )
            sums = with_room(sums, n_tables + stop - start)
            n_tables = seat_rows(start, table[start:stop], theta, mass, seating, sums, n_tables, generator)
        for _ in range(proposals if n > 1 else 0):
            n_tables, sums = propose(
                table, relative, log_prior, concentration, seating.table_of, n_tables, sums, others, side_of, wanted,
                work, generator,
            )  # fmt: skip
        log_likelihood[s] = move_blocks(n_tables, sums, log_prior, seating.table_of, theta, dishes, work, generator)
        n_active[s] = recount(theta, counts, active, place)
        log_joint[s] = log_likelihood[s] + log_assignment_prior(counts, prior, concentration)
        if keep[s]:
            kept[rows] = theta
            rows += 1
