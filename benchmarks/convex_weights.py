"""Convex weights of 100,000 directions over 1,000 places, against a conic solver and expectation-maximisation.

``python -m benchmarks.convex_weights`` prints one table. Walkers head for six places with some noise; the candidates
are random places of the plane, or a ring around it, on which neighbours are near-duplicates. Every solver must reach
a certified gap of 1e-6 nats an observation, checked by the same certificate. The conic solver (Clarabel, exponential
cone, through cvxpy) is told a tolerance that reaches it and is given the mean log likelihood less the sum of the
weights, which has the same optimum: with the sum constrained to one it gives up from 2,000 × 200 on. Only time inside
it counts. Expectation-maximisation goes through the held, scaled table by BLAS, twice a step, and is stopped after
``LONGEST`` seconds: then its ratio is a lower bound.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

from benchmarks.common import Row, peak_megabytes, seconds, walkers
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.table import LogLikelihood
from subgoal.optima import Outcome, convex_weights
from subgoal.partition.scaled_table import ScaledTable
from subgoal.runtime.checks import Floats

GAP, LONGEST = 1e-6, 60.0
LARGE, SMALL = (100_000, 1_000), (20_000, 300)


def ring(count: int) -> Floats:
    """(count, 2) places around the plane of the walkers."""
    angle = 2 * np.pi * np.arange(count) / count
    return 50 + 60 * np.column_stack([np.cos(angle), np.sin(angle)])


def plane(count: int) -> Floats:
    """(count, 2) random places where the walkers are."""
    return np.random.default_rng(1).uniform(0, 100, size=(count, 2))


def table(n: int, points: Floats) -> LogLikelihood:
    """Directions of walkers against the way to each place."""
    return action_comparison(
        Demonstrations.from_arrays(*walkers(n)), Candidates(points, radius=2.0), confidence=5.0
    )  # fmt: skip


def gap_of(scaled: ScaledTable, weights: Floats) -> float:
    """log(max_g D_g / N) of some weights, made to sum to one."""
    weights = np.maximum(weights, 0.0) / np.maximum(weights, 0.0).sum()
    return float(np.log(scaled.gradient(scaled.fitted(weights)).max() / scaled.shape[0]))


def ours(likelihood: LogLikelihood, repeats: int) -> float:
    """Seconds, table to weights."""

    def solve() -> None:
        if convex_weights(likelihood, gap=GAP).outcome is not Outcome.CONVERGED:
            raise RuntimeError("the gap was not reached")

    return seconds(solve, repeats=repeats)


def by_em(likelihood: LogLikelihood) -> tuple[float, float]:
    """Seconds of plain expectation-maximisation from equal weights, and the gap it came to."""
    begin, scaled = time.perf_counter(), ScaledTable(likelihood)
    n, g_count = scaled.shape
    weights, gap = np.full(g_count, 1 / g_count), np.inf
    while gap > GAP and time.perf_counter() - begin < LONGEST:
        gradient = scaled.gradient(scaled.fitted(weights))
        gap = float(np.log(gradient.max() / n))
        if gap > GAP:
            weights = weights * gradient / n
    return time.perf_counter() - begin, gap


def by_clarabel(likelihood: LogLikelihood) -> tuple[float, float]:
    """Seconds inside Clarabel, and the gap of its weights."""
    from importlib import import_module

    cp: Any = import_module("cvxpy")

    scaled = ScaledTable(likelihood)
    if scaled.columns is None:
        raise RuntimeError("too large for the comparison")
    w = cp.Variable(scaled.shape[1], nonneg=True)
    problem = cp.Problem(cp.Maximize(cp.sum(cp.log(scaled.columns.T @ w)) / scaled.shape[0] - cp.sum(w)))
    problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-8, tol_gap_rel=1e-8, tol_feas=1e-8)
    return float(problem.solver_stats.solve_time), gap_of(scaled, np.asarray(w.value))


def main() -> int:
    """Each row as it is done; 1 if a target is missed."""
    rows = []

    def show(row: Row) -> None:
        rows.append(row)
        print(row, flush=True)

    for name, places in (("plane", plane), ("ring", ring)):
        small = table(SMALL[0], places(SMALL[1]))
        mine = ours(small, 3)
        label = f"{name}, {SMALL[0]:,} × {SMALL[1]:,}"
        for peer, solve in (("Clarabel", by_clarabel), ("plain EM", by_em)):
            took, gap = solve(small)
            show(Row(f"{label}, {peer} {took:.1f} s to gap {gap:.1e}", f"{mine:.3f} s", "≥ 20×", took >= 20 * mine,
                     peer if gap <= GAP else f"{peer} (gap not reached)", took / mine))  # fmt: skip
    for name, places in (("plane", plane), ("ring", ring)):
        large = table(LARGE[0], places(LARGE[1]))
        mine, memory = ours(large, 1), peak_megabytes()
        took, gap = by_em(large)
        show(Row(f"{name}, {LARGE[0]:,} × {LARGE[1]:,} ({memory:,.0f} MB), EM {took:.0f} s to gap {gap:.1e}",
                 f"{mine:.2f} s", "< 20 s", mine < 20, "plain EM" if gap <= GAP else "plain EM, at least",
                 took / mine))  # fmt: skip
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
