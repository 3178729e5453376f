"""The convex weights of a few columns: Newton's method whose quadratic steps keep weights at or above zero."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from subgoal._kernels.convex import curvature
from subgoal.runtime.checks import Bools, Floats
from subgoal.runtime.executor import run_all

NEARNESS = 1e-11
"""Pull towards the last weights, relative to the largest curvature: makes equal columns solvable, moves no optimum."""
SMALLEST_STEP = 1e-9
LEAST_RISE = 1e-4
ROUNDING = 2e-15
"""What an observation's log may be off by where two fits are compared."""
WORK, MOST_JOBS = 2**26, 16
"""Products in one job of the curvature, and jobs at most."""


def solve_columns(columns: Floats, weights: Floats, *, excess: float, most_steps: int) -> tuple[Floats, Floats]:
    """Raise f(x) = Σ_i log(xC)_i over the simplex, from x > 0 somewhere in every row.

    With the multiplier N of Σx = 1 the problem is max Σ_i log(xC)_i − N Σx over x ≥ 0. Its quadratic model at x, with
    A = C/(xC), H = AAᵀ and D = A1, is ½yᵀHy − (2D − N)ᵀy, solved by ``nonnegative_quadratic``; then backtracking.

    Parameters
    ----------
    columns:
        (s, N) C.
    weights:
        (s,) x to begin from, summing to one.
    excess:
        Stop when max_g D_g/N − 1 is at most this.
    most_steps:
        Newton steps at most.

    Returns
    -------
    (s,) weights and (N,) fitted values.
    """
    n = columns.shape[1]
    x = weights / weights.sum()
    fitted = x @ columns
    for _ in range(most_steps):
        hessian, slope = _curvature(columns, fitted)
        if slope.max() / n - 1 <= excess:
            break
        target = nonnegative_quadratic(hessian, 2 * slope - n, x)
        step = _rising_step(fitted, target @ columns, float(target.sum()) - 1, float((target - x) @ (slope - n)))
        if step == 0:
            break
        x = x + step * (target - x) if step < 1 else target
        x = x / x.sum()
        fitted = x @ columns
    return x, fitted


def _curvature(columns: Floats, fitted: Floats) -> tuple[Floats, Floats]:
    """(s, s) AAᵀ and (s,) A1 of A = C/r. Not by threaded BLAS, which can wait for seconds on a busy machine."""
    (size, n), inverse = columns.shape, 1.0 / fitted
    jobs = max(1, min(MOST_JOBS, size * size * n // WORK))

    def part(first: int, stop: int) -> tuple[Floats, Floats]:
        out, slope = np.zeros((size, size)), np.zeros(size)
        curvature(columns, inverse, first, stop, out, slope)
        return out, slope

    edges = np.linspace(0, n, jobs + 1).astype(int).tolist()
    parts = run_all(part, list(pairwise(edges)), workers=None if jobs > 1 else 1)
    return np.sum([each[0] for each in parts], axis=0), np.sum([each[1] for each in parts], axis=0)


def _rising_step(fitted: Floats, ahead: Floats, more: float, promised: float) -> float:
    """The first of 1, ½, ¼... that raises Σ log r − N Σx by a share of what its slope promises; 0 if none does.

    Close to the optimum the rise is below its own rounding while the gradient still improves: that much is allowed.
    """
    if not promised > 0:
        return 0.0
    change, step = (ahead - fitted) / fitted, 1.0
    while step >= SMALLEST_STEP:
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = float(np.log1p(step * change).sum()) - fitted.size * step * more
        if rise >= LEAST_RISE * step * promised - ROUNDING * fitted.size:
            return step
        step /= 2
    return 0.0


def nonnegative_quadratic(curvature: Floats, linear: Floats, start: Floats) -> Floats:
    """(s,) x ≥ 0 that minimises ½xᵀHx − qᵀx + ½ε‖x − start‖²: primal active-set method from ``start`` ≥ 0.

    Like Lawson and Hanson's (1974) method for least squares, but begun at a given point. What is returned is never
    worse than ``start``, also where rounding ends the search early.
    """
    size, top = linear.size, float(np.diag(curvature).max())
    h = curvature + np.eye(size) * (NEARNESS * top)
    q = linear + NEARNESS * top * start
    x, free = start.copy(), start > 0
    for _ in range(4 * size + 10):
        x, free = _solve_free(h, q, x, free)
        push = np.where(free, -np.inf, q - h @ x)
        enter = int(np.argmax(push))
        if not push[enter] > 1e-12 * max(1.0, float(np.abs(q).max())):
            break
        free[enter] = True
    return x


def _solve_free(h: Floats, q: Floats, x: Floats, free: Bools) -> tuple[Floats, Bools]:
    """Minimise over the free coordinates, fixing at zero those that would fall below it."""
    free = free.copy()
    while free.any():
        wanted = np.zeros(x.size)
        try:
            wanted[free] = cho_solve(cho_factor(h[np.ix_(free, free)]), q[free])
        except LinAlgError:
            return x, free
        falls = free & (wanted <= 0)
        if not falls.any():
            return wanted, free
        part = x[falls] / (x[falls] - wanted[falls])
        reach = float(part.min())
        x = np.where(free, np.maximum(x + reach * (wanted - x), 0.0), 0.0)
        out = falls & (x <= 1e-300)
        out[np.flatnonzero(falls)[np.argmin(part)]] = True
        x[out], free[out] = 0.0, False
    return x, free
