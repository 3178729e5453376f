"""Gaussian processes: sparse against dense, and the evidence of many functions against scikit-learn's.

``python -m benchmarks.gaussian`` prints one table. Noisy observations of two smooth functions of the plane; inducing
points are the farthest points. Error is the root mean square at 2,000 other places against the functions themselves,
beside that of the dense form. The evidence and its gradient are asked for 100 functions at once, as learning the
hyper-parameters of many values needs them.
"""

from __future__ import annotations

import sys

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from benchmarks.common import Row, seconds
from subgoal.gaussian.covariances import noisy_covariance
from subgoal.gaussian.evidence import evidence_slope
from subgoal.gaussian.evidence_bound import bound_slope
from subgoal.gaussian.inducing import farthest_points
from subgoal.gaussian.regression import Regression, fit
from subgoal.gaussian.sparse import fit_sparse
from subgoal.runtime.checks import Floats

OBSERVATIONS, INDUCING, FUNCTIONS, SMALLER = 4_000, (50, 100, 200), 100, 500
NOISE = 0.01
COVARIANCE = ConstantKernel(1.0) * RBF([1.0, 1.0])


def places(count: int, seed: int) -> Floats:
    """(count, 2)."""
    return np.random.default_rng(seed).uniform(0, 10, size=(count, 2))


def truth(at: Floats) -> Floats:
    """(count, 2)."""
    return np.column_stack([np.sin(at[:, 0]) + np.cos(0.7 * at[:, 1]), np.sin(0.5 * at.sum(axis=1))])


def error(process: Regression, at: Floats) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean((process.mean(at) - truth(at)) ** 2)))


def sparse_against_dense() -> list[Row]:
    """Seconds to condition, and seconds for the evidence (or its bound) with gradient, which learning repeats."""
    x, at = places(OBSERVATIONS, 0), places(2_000, 1)
    y = truth(x) + np.sqrt(NOISE) * np.random.default_rng(2).standard_normal((OBSERVATIONS, 2))
    dense = fit(x, y, COVARIANCE, noise=NOISE, optimise=False)
    whole = seconds(lambda: fit(x, y, COVARIANCE, noise=NOISE, optimise=False), repeats=2, warm=False)
    model = noisy_covariance(COVARIANCE + WhiteKernel(NOISE), 0.0, x)
    slope = seconds(lambda: evidence_slope(model, x, y), repeats=1, warm=False)
    exact, rows = error(dense, at), []
    for m in INDUCING:
        z = farthest_points(x, m)
        sparse = fit_sparse(x, y, COVARIANCE, z, noise=NOISE, optimise=False)
        off, label = error(sparse, at), f"n = {OBSERVATIONS:,}, {m} inducing points"
        took = seconds(lambda z=z: fit_sparse(x, y, COVARIANCE, z, noise=NOISE, optimise=False))  # type: ignore[misc]
        below = dense.pooled_log_evidence - sparse.pooled_log_evidence
        told = f"{label}: error {off:.4f} ({exact:.4f}), {below:.1g} nats below"
        rows.append(Row(told, f"{took:.3f} s", "≥ 5 ×", whole >= 5 * took, "dense", whole / took))
        took = seconds(lambda z=z: bound_slope(model, x, y, z, 1e-6))  # type: ignore[misc]
        rows.append(
            Row(f"{label}: a step of learning", f"{took:.3f} s", "≥ 5 ×", slope >= 5 * took, "dense", slope / took)
        )
    return rows


def evidence_against_scikit_learn() -> Row:
    """Evidence and gradient for many functions of few points."""
    x = places(SMALLER, 0)
    y = np.random.default_rng(3).standard_normal((SMALLER, FUNCTIONS))
    covariance = COVARIANCE + WhiteKernel(NOISE)
    model = noisy_covariance(covariance, 0.0, x)
    peer = GaussianProcessRegressor(covariance, alpha=0.0, optimizer=None).fit(x, y)
    took = seconds(lambda: evidence_slope(model, x, y))
    theirs = seconds(lambda: peer.log_marginal_likelihood(covariance.theta, eval_gradient=True), repeats=1, warm=False)
    apart = abs(evidence_slope(model, x, y)[0] / peer.log_marginal_likelihood(covariance.theta) - 1)
    label = f"evidence and slope, {FUNCTIONS} functions of {SMALLER} points, {apart:.0e} apart"
    return Row(label, f"{took:.3f} s", "≥ 2 ×", theirs >= 2 * took, "scikit-learn", theirs / took)


def main() -> int:
    """1 if a target is missed."""
    rows = [*sparse_against_dense(), evidence_against_scikit_learn()]
    for row in rows:
        print(row, flush=True)
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
