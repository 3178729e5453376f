"""The variational lower bound of the evidence (Titsias 2009) and its gradient, in O(n·m²) for m inducing points.

With Q = K_XZ K_ZZ⁻¹ K_ZX it is log N(y | m, Q + σ²I) − tr(K_XX − Q)/(2σ²): the evidence where Z are the points, and
less than the evidence elsewhere, so that it can be raised without any danger of fitting too much.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.gaussian.covariances import NoisyCovariance
from subgoal.gaussian.factor import Factor, SingularError, factorise
from subgoal.runtime.checks import Floats


@dataclass(frozen=True, eq=False)
class Carried:
    """What the inducing points Z (m, d) carry of the observations at X (n, d).

    Attributes
    ----------
    crossed:
        (m, n) L⁻¹ K_ZX/σ, with K_ZZ = L Lᵀ.
    own:
        Factor of K_ZZ.
    inner:
        Factor of I + A Aᵀ with A = ``crossed``.
    lost:
        tr(K_XX − Q)/σ².
    noise:
        σ².
    """

    crossed: Floats
    own: Factor
    inner: Factor
    lost: float
    noise: float

    @property
    def projection(self) -> Floats:
        """(m, n) P = K_ZZ⁻¹ K_ZX."""
        return np.asarray(self.own.other_half_solve(self.crossed) * np.sqrt(self.noise))

    @property
    def excess(self) -> Floats:
        """(m, n) P (I/σ² − (Q + σ²I)⁻¹)."""
        less = self.crossed - self.inner.solve(self.crossed)
        return np.asarray(self.own.other_half_solve(less) / np.sqrt(self.noise))

    @property
    def trace(self) -> float:
        """σ² tr (Q + σ²I)⁻¹."""
        m, n = self.crossed.shape
        return float(n - m + np.trace(self.inner.solve(np.eye(m))))

    def solve(self, right: Floats) -> Floats:
        """(n, G) (Q + σ²I)⁻¹ B for B (n, G)."""
        return np.asarray((right - self.crossed.T @ self.inner.solve(self.crossed @ right)) / self.noise)

    def bound(self, residual: Floats) -> Floats:
        """(G,) lower bound of the log evidence of each column of ``residual`` (n, G)."""
        n = len(residual)
        half = self.inner.half_solve(self.crossed @ residual)
        quadratic = ((residual**2).sum(axis=0) - (half**2).sum(axis=0)) / self.noise
        volume = self.inner.log_determinant + n * np.log(2 * np.pi * self.noise)
        return np.asarray(-0.5 * (quadratic + volume + self.lost))


def carried(model: NoisyCovariance, points: Floats, inducing: Floats, most_jitter: float) -> Carried:
    """The two factorisations. Raises ``SingularError`` where K_ZZ is singular and the jitter does not suffice."""
    own = factorise(np.array(model.signal(inducing)), most_jitter)
    crossed = own.half_solve(model.signal(inducing, points)) / np.sqrt(model.noise)
    inner = factorise(np.eye(len(inducing)) + crossed @ crossed.T, 0.0)
    lost = float(model.signal.diag(points).sum() / model.noise - (crossed**2).sum())
    return Carried(crossed, own, inner, lost, model.noise)


def bound_slope(
    model: NoisyCovariance, points: Floats, residual: Floats, inducing: Floats, most_jitter: float
) -> tuple[float, Floats]:
    """The bound summed over the columns of ``residual`` (n, G), and its gradient (p,) in ``model.theta``.

    With α = (Q + σ²I)⁻¹ r and T = ½αα^T + ½G(I/σ² − (Q + σ²I)⁻¹), the derivative by Q, the parts are
    2 tr(P T ∂K_XZ) − tr(P T Pᵀ ∂K_ZZ) − G tr(∂K_XX)/(2σ²), and for log σ²
    ½σ²αᵀα − ½Gσ² tr (Q + σ²I)⁻¹ + G tr(K_XX − Q)/(2σ²).

    Derivatives of K_ZX come in blocks of as many points as there are inducing ones, so that no more than O(m²p) of them
    are held. Minus infinity where K_ZZ is singular. Jitter, where there is any, counts as constant.
    """
    try:
        held = carried(model, points, inducing, most_jitter)
    except SingularError:
        return -np.inf, np.zeros(model.theta.size)
    count, m = residual.shape[1], len(inducing)
    solved, projection = held.solve(residual), held.projection
    by_crossed = 0.5 * (projection @ solved) @ solved.T + 0.5 * count * held.excess
    _, own_slopes = model.signal(inducing, eval_gradient=True)
    slope = -np.einsum("ij,ijp->p", by_crossed @ projection.T, own_slopes)
    for start in range(0, len(points), m):
        block = slice(start, start + m)
        _, slopes = model.signal(np.vstack([inducing, points[block]]), eval_gradient=True)
        slope += 2 * np.einsum("ij,ijp->p", by_crossed[:, block], slopes[:m, m:])
        slope -= 0.5 * count / model.noise * np.einsum("iip->p", slopes[m:, m:])
    if model.noise_bounds is not None:
        by_noise = (solved**2).sum() * model.noise - count * (held.trace - held.lost)
        slope = np.append(slope, 0.5 * by_noise)
    return float(held.bound(residual).sum()), slope
