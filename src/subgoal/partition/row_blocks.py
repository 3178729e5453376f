"""Work on the rows of a table, block by block, in threads; the sums do not depend on how many."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from subgoal.partition.protocol import Table
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError
from subgoal.runtime.executor import run_all

GROUP = 2**20
"""Entries that one job goes through, about."""
LEAST_MASS = 1e-290


def over_rows(table: Table, work: Callable[[int, Floats], Any]) -> list[Any]:
    """``work(first row, (B, G) rows)`` for consecutive blocks, in order."""
    n, g_count = table.n_observations, table.n_candidates
    blocks = max(1, min(n, n * g_count // GROUP))
    edges = np.linspace(0, n, blocks + 1).astype(int).tolist()
    dense = table.dense

    def one(start: int, stop: int) -> Any:
        return work(start, table.rows(start, stop) if dense is None else dense[start:stop])

    return run_all(one, list(pairwise(edges)), workers=None if blocks > 1 else 1)


def prior_mass(table: Table, concentration: float) -> Floats:
    """(G,) ηp. Raises ``InputError`` for a concentration so small that some ηp_g vanishes."""
    eta = positive("concentration", concentration)
    mass = np.asarray(eta * np.exp(table.log_prior))
    if not mass.min() > LEAST_MASS:
        raise InputError("concentration", found=eta, wanted=f"a mass ηp of at least {LEAST_MASS:g} for each candidate")
    return mass
