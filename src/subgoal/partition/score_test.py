"""Is one subgoal enough? The score test of one atom against any second one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal._kernels.columns import column_ratios, column_sums
from subgoal.partition.protocol import Table
from subgoal.partition.row_blocks import over_rows
from subgoal.runtime.checks import Floats, frozen
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False)
class ScoreTest:
    """The best single candidate, and how fast the likelihood rises from it towards each other one.

    Attributes
    ----------
    best:
        The candidate of largest Σ_i ℓ_ig (the first of equal ones); None if each is impossible for some observation.
    log_likelihood:
        Σ_i ℓ_i,best in nats; −inf if there is none.
    log_ratio:
        (G,) log(D_g / N), D_g = Σ_i L_ig / L_i,best: +inf everywhere if there is no best one.
    """

    best: int | None
    log_likelihood: float
    log_ratio: Floats

    @property
    def derivative(self) -> Floats:
        """(G,) slope at zero of f((1 − t)e_best + t e_g)/N in t: D_g/N − 1; +inf where that overflows."""
        with np.errstate(over="ignore"):
            return np.expm1(self.log_ratio)

    @property
    def statistic(self) -> float:
        """The largest derivative."""
        return float(self.derivative.max())

    @property
    def one_suffices(self) -> bool:
        """Whether no mixture is likelier than the best single candidate.

        f is concave, so that one atom is the maximum over all mixtures if and only if no derivative is above zero.
        Rounding of the sums is allowed for.
        """
        return bool(self.log_ratio.max() <= 1e-12)


def score_test(table: Table) -> ScoreTest:
    """The score test of K = 1: whether the likeliest single candidate is the likeliest mixture.

    No prior enters. Raises ``InputError`` for a table with NaN or +inf.
    """
    n, g_count = table.n_observations, table.n_candidates

    def sums(_: int, tile: Floats) -> Floats:
        out = np.zeros(g_count)
        column_sums(tile, out)
        return out

    total = np.sum(over_rows(table, sums), axis=0)
    if np.isnan(total).any() or np.isposinf(total).any():
        raise InputError("table", found="NaN or +inf", wanted="log densities below +inf")
    best = int(np.argmax(total))
    if np.isneginf(total[best]):
        return ScoreTest(None, -np.inf, frozen(np.full(g_count, np.inf)))

    def ratios(_: int, tile: Floats) -> Floats:
        peak, mass = np.full(g_count, -np.inf), np.zeros(g_count)
        column_ratios(tile, best, peak, mass)
        with np.errstate(divide="ignore"):
            return np.asarray(peak + np.log(mass))

    log_ratio = np.logaddexp.reduce(over_rows(table, ratios), axis=0) - np.log(n)
    return ScoreTest(best, float(total[best]), frozen(log_ratio))
