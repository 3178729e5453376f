"""Worlds of a few states for tests of planning and of what is built on it."""

from __future__ import annotations

import numpy as np

from subgoal.mdp.tabular import TabularMDP
from tests.oracles.subgoal_planning import random_world


def world(seed: int, discount: float, **kind) -> tuple[TabularMDP, tuple]:
    """A random world, and its dense arrays for the oracle."""
    table, legal, ends = random_world(seed, **kind)
    return TabularMDP.from_dense(table, discount, available=legal, terminal=ends), (table, legal, ends)


def corridor(n: int, discount: float, *, stay: bool = True) -> TabularMDP:
    """Cells in a row: left, right, and staying if asked for."""
    table = np.zeros((n, 3 if stay else 2, n))
    for s in range(n):
        table[s, 0, max(s - 1, 0)] = table[s, 1, min(s + 1, n - 1)] = 1
        if stay:
            table[s, 2, s] = 1
    return TabularMDP.from_dense(table, discount)
