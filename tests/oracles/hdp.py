"""Hierarchical Dirichlet laws over few candidates, by enumeration of all tables. No package code.

An observation is drawn in a row: in a hidden Markov model the candidate before it, or ``FIRST``; with groups, the
group. The law of a row is Dirichlet(free·β + sticky at the row's own candidate), β ~ Dirichlet(γp).
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Hashable, Iterator, Sequence
from typing import Any

import numpy as np

from tests.oracles.partitions import urn_probability

FIRST = "first"
Tables = dict[tuple[Hashable, int], tuple[int, int]]


def walk_rows(theta: Sequence[int], starts: Sequence[int]) -> tuple[Hashable, ...]:
    """The row of each step of paths that begin at ``starts``."""
    return tuple(FIRST if i in starts else theta[i - 1] for i in range(len(theta)))


def group_rows(group: Sequence[int]) -> tuple[Hashable, ...]:
    """The row of each observation of a group; never the number of a candidate."""
    return tuple(("group", k) for k in group)


def stirling(n: int, m: int) -> int:
    """Unsigned, of the first kind: seatings of n customers at m tables, each weighed by Π (size − 1)!."""
    if n == m:
        return 1
    if m < 1 or m > n:
        return 0
    return stirling(n - 1, m - 1) + (n - 1) * stirling(n - 1, m)


def rising(x: Any, n: int) -> Any:
    """x (x + 1) … (x + n − 1)."""
    value = 1.0
    for k in range(n):
        value = value * (x + k)
    return value


def row_mass(row: Hashable, free: Any, sticky: Any) -> Any:
    """Sum of a row's Dirichlet parameters: only rows of candidates are sticky."""
    return free + (sticky if isinstance(row, int) else 0.0)


def chain_rule(rows: Sequence[Hashable], theta: Sequence[int], free: Any, sticky: Any, weights: Sequence[float]) -> Any:
    """p(θ | β), observation after observation, each row's weights integrated out."""
    value: Any = 1.0
    for i, (row, g) in enumerate(zip(rows, theta, strict=True)):
        before = [theta[k] for k in range(i) if rows[k] == row]
        own = sticky if row == g else 0.0
        value = value * (before.count(g) + free * weights[g] + own) / (len(before) + row_mass(row, free, sticky))
    return value


def seatings(
    rows: Sequence[Hashable], theta: Sequence[int], free: Any, sticky: Any
) -> Iterator[tuple[Tables, Counter[int], Any]]:
    """All (tables and sticky tables of each cell, tables per candidate drawn from β, probability over Π β)."""
    cells = Counter(zip(rows, theta, strict=True))
    below = math.prod(rising(row_mass(row, free, sticky), n) for row, n in Counter(rows).items())
    options = [
        [(m, w) for m in range(1, n + 1) for w in range(m + 1 if cell[0] == cell[1] else 1)]
        for cell, n in cells.items()
    ]
    for chosen in itertools.product(*options):
        weight: Any = 1.0
        shared: Counter[int] = Counter()
        for (cell, n), (m, w) in zip(cells.items(), chosen, strict=True):
            weight = weight * stirling(n, m) * math.comb(m, w) * free ** (m - w) * (sticky**w if w else 1.0)
            shared[cell[1]] += m - w
        yield dict(zip(cells, chosen, strict=True)), shared, weight / below


def drawn_from_shared(shared: Counter[int], gamma: float, prior: Sequence[float]) -> float:
    """E[Π β^m] under β ~ Dirichlet(γp): the urn."""
    return urn_probability([g for g, m in shared.items() for _ in range(m)], gamma, prior)


def probability(
    rows: Sequence[Hashable], theta: Sequence[int], free: Any, sticky: Any, gamma: float, prior: Sequence[float]
) -> Any:
    """p(θ), β and all rows integrated out; ``free`` and ``sticky`` may be arrays of the same shape."""
    return sum(
        weight * drawn_from_shared(shared, gamma, prior) for _, shared, weight in seatings(rows, theta, free, sticky)
    )


def seat(
    rows: Sequence[Hashable],
    theta: Sequence[int],
    free: float,
    sticky: float,
    weights: np.ndarray,
    generator: np.random.Generator,
) -> np.ndarray:
    """(G,) a draw of how many tables of each candidate were drawn from β."""
    shared = np.zeros(weights.size, np.int64)
    for i, (row, g) in enumerate(zip(rows, theta, strict=True)):
        before = sum(rows[k] == row and theta[k] == g for k in range(i))
        own = sticky if row == g else 0.0
        base = free * weights[g]
        if generator.random() * (before + base + own) >= before and generator.random() * (base + own) < base:
            shared[g] += 1
    return shared
