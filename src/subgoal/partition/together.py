"""Observations that go together (runs of one subgoal, tables of a restaurant) choose their candidate together."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from subgoal._kernels import collapsed_blocks as blocks
from subgoal._kernels import seating as restaurants
from subgoal._kernels.persistence import normalise_runs
from subgoal.partition.protocol import FIRST_TABLES, Chain, Int32s
from subgoal.runtime.checks import Floats, Ints

ENTRIES = 2**24
"""Most entries of the table of sets by candidates; above it sets are moved by their restaurants and not one by one."""
SWEEPS = 4
"""Sweeps over the sets in one over the recording: there are far fewer of them."""
SumsOf = Callable[[Ints, int], Floats]
"""From the set of each observation and the number of sets, the (sets, G) log likelihood of each at each candidate."""


def bytes_needed(n: int, g_count: int) -> float:
    """Of one chain: both tables of the sets."""
    return 16.0 * min(n * g_count, ENTRIES)


def redraw_together(chain: Chain, prior: Floats, set_of: Ints, candidate: Int32s, sums_of: SumsOf) -> Int32s:
    """New candidates of the sets, (sets,): given who goes together, sets are observations of the exchangeable mixture.

    ``set_of`` (N,) is the set of each observation, ``candidate`` (sets,) where each is, ``prior`` (G,) P(g).
    """
    moved = candidate.copy()
    if moved.size * prior.size <= ENTRIES:
        _sweep(chain, prior, sums_of(set_of, moved.size), moved)
    else:
        _move(chain, prior, set_of, moved, sums_of)
    return moved


def _sweep(chain: Chain, prior: Floats, sums: Floats, candidate: Int32s) -> None:
    """Sweeps of ``collapsed_blocks`` over the sets; writes ``candidate``."""
    relative, log_prior = np.empty_like(sums), chain.table.log_prior
    normalise_runs(sums, log_prior, relative)
    trace = np.empty(SWEEPS), np.empty(SWEEPS), np.empty(SWEEPS, np.int64)
    blocks.sweeps_dense(
        sums, relative, np.array([0, candidate.size]), prior, log_prior, chain.concentration, candidate,
        np.empty((FIRST_TABLES, prior.size)), np.zeros(SWEEPS, bool), np.empty((0, candidate.size), np.int32), *trace,
        chain.generator,
    )  # fmt: skip


def _move(chain: Chain, prior: Floats, set_of: Ints, candidate: Int32s, sums_of: SumsOf) -> None:
    """Seat the sets of each candidate by its restaurant; every table draws one candidate; writes ``candidate``."""
    size, g_count = candidate.size, prior.size
    seating, dishes, work = restaurants.seating_for(size, g_count), np.empty(size, np.int64), np.empty(g_count)
    rows = np.empty((size, 0))
    count = restaurants.seat_rows(0, rows, candidate, chain.concentration * prior, seating, rows, 0, chain.generator)
    sums = sums_of(seating.table_of[set_of], count)
    blocks.move_blocks(count, sums, chain.table.log_prior, seating.table_of, candidate, dishes, work, chain.generator)
