"""The convex weights and the best assignment by other means. Imports nothing from the package."""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.special import gammaln, logsumexp


def mixture_log_likelihood(log_table: np.ndarray, weights: np.ndarray) -> float:
    """Σ_i log Σ_g w_g L_ig."""
    with np.errstate(divide="ignore"):
        return float(logsumexp(log_table + np.log(weights), axis=1).sum())


def conic_optimum(log_table: np.ndarray) -> np.ndarray:
    """(G,) weights by an interior-point method on the exponential cone (Clarabel through cvxpy)."""
    import cvxpy as cp

    scaled = np.exp(log_table - log_table.max(axis=1, keepdims=True))
    w = cp.Variable(log_table.shape[1], nonneg=True)
    cp.Problem(cp.Maximize(cp.sum(cp.log(scaled @ w))), [cp.sum(w) == 1]).solve(
        solver=cp.CLARABEL, tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10
    )
    weights = np.maximum(w.value, 0.0)
    return weights / weights.sum()


def expectation_maximisation(log_table: np.ndarray, steps: int) -> np.ndarray:
    """(G,) weights after many plain steps from equal ones."""
    scaled = np.exp(log_table - log_table.max(axis=1, keepdims=True))
    weights = np.full(log_table.shape[1], 1 / log_table.shape[1])
    for _ in range(steps):
        share = scaled * weights
        weights = (share / share.sum(axis=1, keepdims=True)).mean(axis=0)
    return weights


def log_dirichlet_multinomial(theta: tuple[int, ...], mass: np.ndarray) -> float:
    """log p(θ) with weights Dirichlet(mass), from the gamma functions."""
    counts = np.bincount(theta, minlength=mass.size)
    total = gammaln(mass.sum()) - gammaln(mass.sum() + len(theta))
    return float(total + (gammaln(counts + mass) - gammaln(mass)).sum())


def every_assignment(log_table: np.ndarray, mass: np.ndarray) -> dict[tuple[int, ...], float]:
    """log p(θ, O) of all G^N assignments."""
    n, g_count = log_table.shape
    return {
        theta: log_dirichlet_multinomial(theta, mass) + math.fsum(log_table[i, g] for i, g in enumerate(theta))
        for theta in itertools.product(range(g_count), repeat=n)
    }


def log_evidence(log_table: np.ndarray, mass: np.ndarray) -> float:
    """log p(O), summed over all assignments."""
    return float(logsumexp(list(every_assignment(log_table, mass).values())))
