"""The mixture weights of greatest likelihood over all candidates, with a certificate of how great it can be.

f(w) = Σ_i log Σ_g L_ig w_g is concave (Lindsay 1983): the nonparametric maximum-likelihood estimate has no local
optima. The prior is not used. It is a bound and a start for the other methods, and penalises no number of subgoals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from subgoal.partition.outcome import Outcome
from subgoal.partition.protocol import Table
from subgoal.partition.scaled_table import ScaledTable
from subgoal.partition.screening import proved_idle
from subgoal.partition.simplex_newton import solve_columns
from subgoal.runtime.checks import Bools, Floats, Ints, frozen, positive, whole
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

MOST_ENTERING = 40
"""Candidates that join the support in one round."""
EM_STEPS = 3
NEWTON_STEPS = 6
TIGHTER = 0.1
"""A round solves its columns to this share of the excess that the round began with."""


@dataclass(frozen=True, eq=False)
class ConvexWeights:
    """Weights of greatest likelihood, to a certified gap.

    Attributes
    ----------
    weights:
        (G,) w, summing to one.
    log_likelihood:
        f(w) = Σ_i log(Lw)_i in nats.
    gap:
        Nats that no other weights can exceed f(w) by: N log(max_g D_g / N).
    gradient:
        (G,) D_g = Σ_i L_ig / (Lw)_i; at an optimum at most N, and N on the support.
    fitted:
        (N,) log(Lw)_i, the same for every optimum (to the gap).
    idle:
        (G,) True where it is proved that no optimum gives the candidate weight (``screening``).
    iterations:
        Rounds over the whole table.
    outcome:
        Whether the wanted gap is reached.
    trace:
        (iterations,) certified gap of each round.
    """

    weights: Floats
    log_likelihood: float
    gap: float
    gradient: Floats
    fitted: Floats
    idle: Bools
    iterations: int
    outcome: Outcome
    trace: Floats = field(repr=False)

    @property
    def support(self) -> Ints:
        """Candidates of weight above zero."""
        return np.flatnonzero(self.weights)

    @property
    def upper_bound(self) -> float:
        """No mixture over these candidates has a greater log likelihood."""
        return self.log_likelihood + self.gap


def convex_weights(
    table: Table, *, gap: float = 1e-6, most_iterations: int = 500, progress: Progress | None = None
) -> ConvexWeights:
    """Weights w on the simplex that maximise f(w) = Σ_i log(Lw)_i, to a certified gap.

    After a few steps of expectation-maximisation, rounds of: the gradient D over all candidates, the certificate
    f(w*) − f(w) ≤ N log(max_g D_g / N) (Jensen), the candidates of largest D_g above N joining the support, and
    Newton's method on the support alone (``simplex_newton``), in the manner of constrained Newton methods for
    mixtures (Wang 2007). What expectation-maximisation found stays as one more column until its weight is zero, so
    that f never falls and no observation is ever impossible.

    Parameters
    ----------
    table:
        N × G log densities; −inf means impossible.
    gap:
        Wanted gap in nats per observation.
    most_iterations:
        Rounds at most; the outcome says if they did not suffice, nothing is raised.
    progress:
        Told the rounds and the gap.

    Raises ``InputError`` for an observation that no candidate allows, and for NaN and +inf.
    """
    wanted = positive("gap", gap)
    search = _Search(ScaledTable(table), whole("most_iterations", most_iterations))
    with Interrupt() as interrupt, progress or Silent() as display:
        outcome = search.run(wanted, interrupt, display)
    return search.answer(outcome)


class _Search:
    """What the rounds share: columns of the support, the first of them the mixture of expectation-maximisation."""

    def __init__(self, table: ScaledTable, most: int) -> None:
        self.table, self.most = table, most
        self.n, self.g_count = table.shape
        self.mixed = np.full(self.g_count, 1.0 / self.g_count)
        for _ in range(EM_STEPS):
            self.mixed = self.mixed * table.gradient(table.fitted(self.mixed)) / self.n
            self.mixed /= self.mixed.sum()
        self.fitted = table.fitted(self.mixed)
        self.columns, self.names, self.x = self.fitted[None], np.array([-1]), np.ones(1)
        self.gradient = table.gradient(self.fitted)
        self.trace: list[float] = []

    @property
    def excess(self) -> float:
        """max_g D_g/N − 1, at least 0."""
        return max(float(self.gradient.max()) / self.n - 1, 0.0)

    def run(self, wanted: float, interrupt: Interrupt, display: Progress) -> Outcome:
        """Rounds until the gap per observation is at most ``wanted``."""
        best, without = math.inf, 0
        for done in range(1, self.most + 1):
            gap = math.log1p(self.excess)
            self.trace.append(gap * self.n)
            display.update(done, self.most, f"gap {gap:.1e} nats per observation")
            if gap <= wanted:
                return Outcome.CONVERGED
            if interrupt.requested:
                return Outcome.INTERRUPTED
            best, without = (gap, 0) if gap < 0.999 * best else (best, without + 1)
            if without > 20:
                return Outcome.STALLED
            if done < self.most:
                self._round(wanted)
        return Outcome.OUT_OF_ITERATIONS

    def _round(self, wanted: float) -> None:
        above = np.flatnonzero(self.gradient > self.n * (1 + 0.1 * self.excess))
        above = np.setdiff1d(above, self.names)
        enter = above[np.argsort(-self.gradient[above], kind="stable")[:MOST_ENTERING]]
        columns = np.concatenate([self.columns, self.table.take(enter)])
        start = np.concatenate([self.x, np.zeros(enter.size)])
        tight = max(TIGHTER * self.excess, 0.3 * wanted)
        x, _ = solve_columns(columns, start, excess=tight, most_steps=NEWTON_STEPS)
        keep = x > 0
        self.columns, self.x = columns[keep], x[keep] / x[keep].sum()
        self.names = np.concatenate([self.names, enter])[keep]
        self.fitted = self.x @ self.columns
        self.gradient = self.table.gradient(self.fitted)

    def answer(self, outcome: Outcome) -> ConvexWeights:
        """The frozen record."""
        weights = np.zeros(self.g_count)
        real = self.names >= 0
        weights[self.names[real]] = self.x[real]
        weights += self.mixed * float(self.x[~real].sum())
        gap = self.n * math.log1p(self.excess)
        fitted = np.log(self.fitted) + self.table.peak
        idle = proved_idle(self.gradient, *self.table.spread(self.fitted), self.n, gap)
        return ConvexWeights(
            weights=frozen(weights), log_likelihood=math.fsum(fitted), gap=gap, gradient=frozen(self.gradient),
            fitted=frozen(fitted), idle=frozen(idle), iterations=len(self.trace), outcome=outcome,
            trace=frozen(np.array(self.trace)),
        )  # fmt: skip
