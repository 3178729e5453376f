"""A seat in a Chinese restaurant whose tables are kept as a linked list."""

from __future__ import annotations

from numba import njit

from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def choose_table(first, following, sizes, mass, work, slots, generator):
    """One of the tables from ``first`` (−1: none) through ``following``, by its size, or −1 for a new one, by ``mass``.

    Writes ``work`` and ``slots``, which need room for all of them and one more.
    """
    if first < 0:
        return -1
    count = 0
    table = first
    while table >= 0:
        work[count] = sizes[table]
        slots[count] = table
        count += 1
        table = following[table]
    work[count] = mass
    pick = choose(work, count + 1, generator)
    return slots[pick] if pick < count else -1
