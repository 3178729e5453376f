"""Upper bounds on log p(θ, O) over all assignments."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.special import gammaln

from subgoal._kernels.local_search import best_groups
from subgoal.partition.convex_weights import ConvexWeights
from subgoal.partition.protocol import Table
from subgoal.partition.row_blocks import over_rows
from subgoal.partition.scaled_table import HELD_ENTRIES
from subgoal.runtime.checks import Floats
from subgoal.runtime.executor import run_all, worker_count
from subgoal.runtime.interrupt import Interrupt

ENTRIES_IN_ALL = 2**30
"""Entries of the table that the Lagrangian bound goes through at most, over all its steps."""
LEAST_STEPS = 4
PATIENCE = 5


def upper_bound(
    table: Table, mass: Floats, convex: ConvexWeights, found: float, steps: int, interrupt: Interrupt
) -> float:
    """A number that no log p(θ, O) exceeds: the least of three.

    * With w ~ Dirichlet(ηp), p(θ, O) = E Π_i w_θi L_iθi ≤ max_w Π_i (Lw)_i: the convex optimum and its gap.
    * Σ_i max_g ℓ_ig + max_n log p(n), which is at a corner n = N e_g, as log Γ is convex.
    * Lagrange: let each candidate choose its own set of observations and pay v_i for every one. For any v,
      log p(θ, O) ≤ c + Σ_i v_i + Σ_g max(0, max_M Σ_{i∈M} (ℓ_ig − v_i) + φ_g(|M|)), c = log Γ(η) − log Γ(N + η). For
      each size the best set is that of the largest ℓ_ig − v_i. Subgradient steps of Polyak's length lower it, from
      v_i = log(Lw)_i − c/N at the convex optimum. Used where the turned table can be held.

    Parameters
    ----------
    mass:
        (G,) ηp.
    found:
        The best log p(θ, O) found so far, at which the steps aim.
    steps:
        Subgradient steps at most; fewer for a large table.
    """
    n, eta = table.n_observations, float(mass.sum())
    constant = float(gammaln(eta) - gammaln(n + eta))
    corner = constant + float((gammaln(n + mass) - gammaln(mass)).max())
    peak = np.concatenate(over_rows(table, lambda _, tile: tile.max(axis=1)))
    bounds = [convex.upper_bound, float(peak.sum()) + corner]
    if n * mass.size <= HELD_ENTRIES:
        most = min(steps, max(LEAST_STEPS, ENTRIES_IN_ALL // (n * mass.size)))
        bounds.append(_lagrangian(table, mass, convex.fitted - constant / n, constant, found, most, interrupt))
    rounding = 1e-13 * n * (1 + float(np.abs(peak).max()) + np.log(n + eta))
    return float(min(bounds) + rounding)


def _lagrangian(
    table: Table, mass: Floats, price: Floats, constant: float, found: float, steps: int, interrupt: Interrupt
) -> float:
    columns = np.concatenate([part.T for part in over_rows(table, lambda _, tile: tile)], axis=1)
    columns = np.ascontiguousarray(columns)
    edges = np.linspace(0, mass.size, min(mass.size, 4 * worker_count(None)) + 1).astype(int).tolist()
    workers = None if columns.size > ENTRIES_IN_ALL // 2**12 else 1

    def part(first: int, stop: int) -> tuple[float, Floats]:
        used = np.zeros(price.size)
        return best_groups(columns, price, mass, first, stop, used), used

    best, kept, share, without = np.inf, price, 1.0, 0
    for _ in range(steps):
        parts = run_all(part, list(pairwise(edges)), workers=workers)
        value = constant + float(price.sum()) + sum(each[0] for each in parts)
        if value < best:
            best, kept, without = value, price, 0
        else:
            without += 1
        slope = 1.0 - np.sum([each[1] for each in parts], axis=0)
        if not slope.any() or best <= found or interrupt.requested:
            break
        if without >= PATIENCE:
            price, share, without = kept, share / 2, 0
        price = price - share * (value - found) / float(slope @ slope) * slope
    return best
