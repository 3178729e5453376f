"""The evidence (thesis 2.15), its gradient, and hyper-parameters at which it is greatest."""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, cho_solve, cholesky
from scipy.optimize import Bounds, minimize

from subgoal.gaussian.covariances import NoisyCovariance
from subgoal.gaussian.factor import Factor, SingularError
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

WALL = 1e20
"""Stands for minus infinity nats in the search, which needs finite numbers."""
NO_SLOPE = 1e-14
"""A derivative of this share of the covariance is none."""
DEPENDENT = 1e-12
"""Least eigenvalue of the derivatives' correlations below which some of them move the evidence together."""
ON_BOUND = 1e-6

Objective = Callable[[NoisyCovariance], tuple[float, Floats]]
"""Pooled evidence in nats and its gradient (p,)."""


class Fitted(enum.Enum):
    """Where the hyper-parameters come from; the value says it in words."""

    GIVEN = "as given"
    CONVERGED = "the evidence is greatest here, as far as a local search can tell"
    AT_BOUND = "the evidence is greatest on a bound of a hyper-parameter. Try: wider bounds, or the value as given"
    OUT_OF_ITERATIONS = "NOT CONVERGED: the iterations ran out. Try: a larger most_iterations"
    STALLED = "NOT CONVERGED: no step raises the evidence any more in these numbers. Try: noise, or another start"
    UNIDENTIFIED = "UNIDENTIFIED: these points do not tell some hyper-parameters. Try: to set them, or more points"


@dataclass(frozen=True, eq=False)
class Ascent:
    """Where a search for the greatest evidence ended; ``unidentified`` names what the points do not tell."""

    model: NoisyCovariance
    fitted: Fitted = Fitted.GIVEN
    unidentified: tuple[str, ...] = ()


def log_evidence(factor: Factor, residual: Floats) -> Floats:
    """(G,) log density of each column of ``residual`` (n, G), y − m, with every constant (2.15)."""
    white = factor.half_solve(residual)
    return np.asarray(-0.5 * ((white**2).sum(axis=0) + factor.log_determinant + len(residual) * np.log(2 * np.pi)))


def evidence_slope(model: NoisyCovariance, points: Floats, residual: Floats) -> tuple[float, Floats]:
    """Evidence summed over the columns of ``residual`` (n, G), and its gradient (p,) in ``model.theta``.

    ∂/∂θ = ½ Σ_ij (αα^T − G(K + σ²I)⁻¹)_ij ∂K_ij/∂θ with α = (K + σ²I)⁻¹(y − m) (Rasmussen and Williams 2006, 5.9),
    at the cost of one factorisation whatever G is. Minus infinity where there is no factor.
    """
    n, count = residual.shape
    matrix, slopes = model.matrix_and_slopes(points)
    try:
        lower = cholesky(matrix, lower=True)
    except (LinAlgError, ValueError):
        return -np.inf, np.zeros(model.theta.size)
    solved = cho_solve((lower, True), residual, check_finite=False)
    inner = solved @ solved.T - count * cho_solve((lower, True), np.eye(n), check_finite=False)
    log_volume = np.log(np.diagonal(lower)).sum() + 0.5 * n * np.log(2 * np.pi)
    return float(-0.5 * (residual * solved).sum() - count * log_volume), 0.5 * np.einsum("ij,ijp->p", inner, slopes)


def ascend(
    objective: Objective, model: NoisyCovariance, points: Floats, *, most_iterations: int, restarts: int, seed: int
) -> Ascent:
    """The best of a search from ``model`` and ``restarts`` searches from random points within the bounds.

    Quasi-Newton steps (L-BFGS-B) in the logarithms of the hyper-parameters. Some the points (n, d) may not tell (E30 of
    the errata: one point, and any length scale): the covariance of the points does not change with one at all, which
    then keeps the value it was given, or it changes in the same way with several.

    Raises ``SingularError`` where no start has any evidence.
    """
    start, bounds = model.theta, model.bounds
    if not start.size:
        return Ascent(model)
    low, high = bounds.T
    drawn = stream(seed).uniform(low, high, size=(restarts, start.size))

    def downhill(theta: Floats) -> tuple[float, Floats]:
        value, slope = objective(model.at(theta))
        return (WALL, np.zeros_like(slope)) if value == -np.inf else (-value, -slope)

    within: Any = Bounds(low, high)
    found = [
        minimize(downhill, x, jac=True, method="L-BFGS-B", bounds=within, options={"maxiter": most_iterations})
        for x in (np.clip(start, low, high), *drawn)
    ]
    best = min(found, key=lambda result: float(result.fun))
    if not best.fun < WALL:
        raise SingularError(
            "The evidence cannot be raised: at the hyper-parameters given the covariance is singular. Try: noise, "
            "a shorter length scale to begin with, or optimise=False."
        )
    silent, together = _blind(model.at(best.x), points)
    theta = np.where(silent & _blind(model, points)[0], start, best.x)
    blind = tuple(name for name, told in zip(model.names, silent | together, strict=True) if told)
    if blind:
        return Ascent(model.at(theta), Fitted.UNIDENTIFIED, blind)
    if not best.success:
        return Ascent(model.at(theta), Fitted.OUT_OF_ITERATIONS if best.nit >= most_iterations else Fitted.STALLED)
    on_bound = (np.abs(theta[:, None] - bounds) < ON_BOUND).any()
    return Ascent(model.at(theta), Fitted.AT_BOUND if on_bound else Fitted.CONVERGED)


def _blind(model: NoisyCovariance, points: Floats) -> tuple[np.ndarray, np.ndarray]:
    """(p,) hyper-parameters without any effect at the points, and those whose effects cannot be told apart."""
    matrix, slopes = model.matrix_and_slopes(points)
    slopes = slopes.reshape(-1, model.theta.size)
    size = np.linalg.norm(slopes, axis=0)
    silent = size <= NO_SLOPE * np.linalg.norm(matrix)
    together = np.zeros(size.size, bool)
    heard = np.flatnonzero(~silent)
    if heard.size > 1:
        unit = slopes[:, heard] / size[heard]
        values, vectors = np.linalg.eigh(unit.T @ unit)
        together[heard] = (np.abs(vectors[:, values < DEPENDENT]) > 1e-3).any(axis=1)
    return silent, together
