"""Chinese restaurants whose tables are kept as linked lists."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subgoal._kernels.draws import choose_listed, opens


class Seating(NamedTuple):
    """N customers at the tables of R restaurants; functions that are given one write it.

    Attributes
    ----------
    table_of:
        (N,) table of each customer.
    following, sizes:
        (N,) of each table the next of its restaurant, −1 after the last, and its number of customers.
    first, seated:
        (R,) of each restaurant its first table, −1 where there is none, and its number of customers.
    waited:
        (R,) see ``draws.opens``.
    """

    table_of: NDArray[np.int64]
    following: NDArray[np.int64]
    sizes: NDArray[np.int64]
    first: NDArray[np.int64]
    seated: NDArray[np.int64]
    waited: NDArray[np.float64]


@njit(cache=True, nogil=True)
def seating_for(customers, restaurants):
    """Room for so many; nobody sits."""
    return Seating(
        np.empty(customers, np.int64), np.empty(customers, np.int64), np.empty(customers, np.int64),
        np.full(restaurants, -1, np.int64), np.zeros(restaurants, np.int64), np.zeros(restaurants),
    )  # fmt: skip


@njit(cache=True, nogil=True)
def clear(seating):
    """Everybody leaves."""
    seating.first[:] = -1
    seating.seated[:] = 0


@njit(cache=True, nogil=True)
def seat_rows(start, tile, restaurant, mass, seating, sums, n_tables, generator):
    """Seat start..start+len(tile), each in its restaurant (N,), those before it being there; returns how many tables.

    ``mass`` (R,) is the concentration of each Chinese restaurant process. Each row of ``tile`` is added to that of its
    table in ``sums``, for which there must be room. In one piece, because to hand arrays to a helper for each customer
    takes longer than to seat him.
    """
    table_of, following, sizes, first, seated, waited = seating
    for r in range(tile.shape[0]):
        k = restaurant[start + r]
        before = seated[k]
        table = first[k]
        if opens(waited, k, before, mass[k], generator):
            following[n_tables] = table
            table = n_tables
            first[k] = table
            sizes[table] = 0
            for c in range(tile.shape[1]):
                sums[table, c] = 0.0
            n_tables += 1
        elif following[table] >= 0:
            table = choose_listed(table, following, sizes, before, generator)
        table_of[start + r] = table
        sizes[table] += 1
        seated[k] = before + 1
        row, total = tile[r], sums[table]
        for c in range(tile.shape[1]):
            total[c] += row[c]
    return n_tables
