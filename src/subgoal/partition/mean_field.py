"""Variational Bayes of the finite Dirichlet mixture: weights and assignments made independent of each other."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import betaln, digamma, gammaln

from subgoal._kernels.columns import expected_counts
from subgoal.partition.convex_weights import convex_weights
from subgoal.partition.outcome import Outcome
from subgoal.partition.protocol import Table
from subgoal.partition.row_blocks import over_rows, prior_mass
from subgoal.runtime.checks import Floats, frozen, positive, real_array, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent

SUM_TOLERANCE = 1e-6
LARGE, FEW = 1e3, 1e-3
"""Mass above which, and count below which, log Γ(mass + count) − log Γ(mass) is computed in another form."""


@dataclass(frozen=True, eq=False)
class MeanField:
    """q(w) q(θ) with q(w) = Dirichlet(a) and q(θ_i = g) = r_ig ∝ L_ig exp(E log w_g).

    Attributes
    ----------
    shape:
        (G,) a.
    counts:
        (G,) Σ_i r_ig, how many observations each candidate is expected to explain.
    evidence_bound:
        ELBO in nats with every constant: at most log p(O).
    log_weight:
        (G,) E log w_g = ψ(a_g) − ψ(Σa), from which r follows.
    outcome:
        Whether the last step raised the bound by no more than the tolerance.
    trace:
        (iterations,) the bound; it never falls by more than rounding.
    """

    shape: Floats
    counts: Floats
    evidence_bound: float
    log_weight: Floats
    outcome: Outcome
    trace: Floats = field(repr=False)

    @property
    def weights(self) -> Floats:
        """(G,) mean of q(w)."""
        return np.asarray(self.shape / self.shape.sum())

    @property
    def iterations(self) -> int:
        """Passes over the table."""
        return self.trace.size

    def responsibilities(self, rows: Floats) -> Floats:
        """(B, G) r_ig of some (B, G) rows of the table."""
        share = rows + self.log_weight
        share = np.exp(share - share.max(axis=1, keepdims=True))
        return np.asarray(share / share.sum(axis=1, keepdims=True))


def mean_field(
    table: Table,
    concentration: float,
    *,
    start: Any = None,
    tolerance: float = 1e-9,
    most_iterations: int = 2000,
    progress: Progress | None = None,
) -> MeanField:
    """The nearest q(w) q(θ) to the posterior that is found from a start; a local optimum (Beal 2003).

    Each pass over the table takes r_ig ∝ L_ig exp(ψ(a_g)) and a = ηp + Σ_i r_i; the bound of a is
    Σ_i log Σ_g L_ig exp(E log w_g) − KL(Dirichlet(a) ‖ Dirichlet(ηp)). Where ηp_g is far below one a candidate that
    nothing begins at stays empty: E log w_g is about −1/(ηp_g).

    Parameters
    ----------
    table:
        N × G log densities, held or tiled, and log P(g).
    concentration:
        η above 0.
    start:
        (G,) weights at which a = ηp + N·start begins; None takes those of ``convex_weights``.
    tolerance:
        Stop when the bound rises by no more than this, in nats per observation.
    most_iterations:
        Passes at most; the outcome says if they did not suffice.

    Raises ``InputError`` for an observation that no candidate allows.
    """
    mass = prior_mass(table, concentration)
    most = whole("most_iterations", most_iterations)
    least = positive("tolerance", tolerance, zero=True) * table.n_observations
    weights = convex_weights(table).weights if start is None else _checked_start(start, mass.size)
    counts, trace = table.n_observations * weights, []
    outcome = Outcome.OUT_OF_ITERATIONS
    with Interrupt() as interrupt, progress or Silent() as display:
        for done in range(1, most + 1):
            log_weight = digamma(mass + counts) - digamma(mass.sum() + counts.sum())
            fit, ahead = _pass(table, log_weight)
            trace.append(fit - _divergence(mass, counts))
            display.update(done, most, f"bound {trace[-1]:.6g} nats")
            if done > 1 and trace[-1] - trace[-2] <= least:
                outcome = Outcome.CONVERGED
                break
            if interrupt.requested:
                outcome = Outcome.INTERRUPTED
                break
            if done < most:
                counts = ahead
    return MeanField(
        shape=frozen(mass + counts), counts=frozen(ahead), evidence_bound=trace[-1], log_weight=frozen(log_weight),
        outcome=outcome, trace=frozen(np.array(trace)),
    )  # fmt: skip


def _pass(table: Table, log_weight: Floats) -> tuple[float, Floats]:
    """Σ_i log Σ_g L_ig exp(log_weight_g) and (G,) expected counts."""

    def block(start: int, tile: Floats) -> tuple[float, Floats]:
        counts = np.zeros(log_weight.size)
        fit = expected_counts(tile, log_weight, counts)
        if not np.isfinite(fit):
            raise InputError(
                "table", where=f"observations {start} to {start + len(tile) - 1}", found=f"log density {fit}",
                wanted="observations that at least one candidate allows, and no NaN", hint="drop them",
            )  # fmt: skip
        return fit, counts

    parts = over_rows(table, block)
    return float(sum(part[0] for part in parts)), np.sum([part[1] for part in parts], axis=0)


def _divergence(mass: Floats, counts: Floats) -> float:
    """KL(Dirichlet(ηp + n) ‖ Dirichlet(ηp)) for counts n, which are kept apart so that small ones are not lost."""
    shape, total = mass + counts, mass.sum() + counts.sum()
    rises = _log_rising(np.array([mass.sum()]), np.array([counts.sum()])).sum() - _log_rising(mass, counts).sum()
    return float(rises + (counts * (digamma(shape) - digamma(total))).sum())


def _log_rising(mass: Floats, counts: Floats) -> Floats:
    """log Γ(mass + counts) − log Γ(mass); for a large mass in forms in which nothing large cancels."""
    few = counts < FEW
    some = np.where(few, 1.0, counts)
    apart = np.where(few, counts * digamma(mass + counts / 2), gammaln(some) - betaln(mass, some))
    return np.asarray(np.where(mass > LARGE, apart, gammaln(mass + counts) - gammaln(mass)))


def _checked_start(start: Any, size: int) -> Floats:
    weights = real_array("start", start, ndim=1)
    if weights.shape != (size,) or not weights.min() >= 0 or not abs(weights.sum() - 1) <= SUM_TOLERANCE:
        found = f"{weights.size} numbers from {weights.min(initial=np.inf):g} that sum to {weights.sum():g}"
        raise InputError("start", found=found, wanted=f"{size} weights of at least 0 that sum to 1")
    return weights
