"""Loops of the sampler ``Grouped``: observations given the counts of their group, and their tables.

Arrays named as written are state.
"""

from __future__ import annotations

from numba import njit

from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def redraw_rows(start, relative, group, weights, mass, theta, counts, work, generator):
    """Draw θ_i ∝ (n_kg without i + mass·β_g)·L_ig, k the group of i, for the rows of ``relative`` (B, G).

    ``weights`` (G,) is β; the group's own weights are integrated out. Writes ``theta`` (N,) and ``counts`` (K, G).
    """
    for r in range(relative.shape[0]):
        i = start + r
        row = counts[group[i]]
        row[theta[i]] -= 1
        for g in range(weights.size):
            work[g] = (row[g] + mass * weights[g]) * relative[r, g]
        theta[i] = choose(work, weights.size, generator)
        row[theta[i]] += 1


@njit(cache=True, nogil=True)
def count_in_groups(theta, group, counts):
    """Write ``counts`` (K, G): observations of each group at each candidate."""
    counts[:] = 0
    for i in range(theta.size):
        counts[group[i], theta[i]] += 1


@njit(cache=True, nogil=True)
def dishes_of(theta, table_of, dish):
    """Write ``dish`` (T,): the candidate of each table."""
    for i in range(theta.size):
        dish[table_of[i]] = theta[i]


@njit(cache=True, nogil=True)
def add_rows(start, tile, table_of, sums):
    """Add the rows of ``tile`` (B, G) to those of their table in ``sums`` (T, G)."""
    for r in range(tile.shape[0]):
        row = sums[table_of[start + r]]
        for g in range(tile.shape[1]):
            row[g] += tile[r, g]
