"""From values at support states to values anywhere: a Gaussian process's mean, or an average that cannot amplify.

Everything here is written against the array API standard: NumPy by default, and the same code on the arrays of a GPU
library.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from array_api_compat import array_namespace

from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError

Array = Any
"""An array of any library that follows the array API standard."""


Smoothed = Callable[[Array, Array | None], Array]
"""From states (q, e), and their variance or None, to values (q, G)."""


class Smoother(Protocol):
    """A linear map from values at support states to values at other states."""

    @property
    def contracts(self) -> bool:
        """Whether no value is ever larger in size than the largest one it is made of."""

    def weights(self, support: Array, at: Array, variance: Array | None = None) -> Array:
        """(q, n) weights W for support states (n, e) and states (q, e), in coordinates of the metric.

        With ``variance`` (q, e) the states are Gaussian with that diagonal covariance, and W gives expectations.
        """

    def through(self, support: Array, values: Array) -> Smoothed:
        """The function W·values of states (q, e) and their variance, for values (n, G) at the support states."""


@dataclass(frozen=True)
class GaussianSmoother:
    """Mean of a Gaussian process with squared exponential covariance, W = K(Y, X)(K(X, X) + σ²I)⁻¹ (thesis 2.12).

    Attributes
    ----------
    length:
        λ, in units of the metric. Longer is smoother, with a larger gain.
    noise:
        σ², as a share of the covariance's own variance: below 0.1 the gain of W grows and planning may not converge.
    most_gain:
        Rows of W whose absolute weights sum to more are scaled down to it. At 1 planning is a contraction and its error
        is bounded, at the price of a bias; infinity leaves W as it is, and convergence is watched, not proved.
    """

    length: float = 1.5
    noise: float = 0.1
    most_gain: float = math.inf

    def __post_init__(self) -> None:
        positive("length", self.length)
        positive("noise", self.noise, zero=True)
        if not self.most_gain > 0:
            raise InputError("most_gain", found=self.most_gain, wanted="a number above 0, or infinity")

    @property
    def contracts(self) -> bool:
        """Whether the gain is held at 1 or below."""
        return self.most_gain <= 1

    def weights(self, support: Array, at: Array, variance: Array | None = None) -> Array:
        """See ``Smoother``. Raises ``InputError`` where the support states are too close to each other to tell apart.

        For two equal support states and no noise there is no such Gaussian process.
        """
        xp = array_namespace(support, at)
        outer = squared_exponential(at, support, self.length, variance)
        weights = xp.linalg.solve(self._covariance(support), outer.T).T
        if self.most_gain == math.inf:
            return weights
        size = xp.sum(xp.abs(weights), axis=1, keepdims=True)
        one = xp.ones_like(size)
        return weights * xp.where(size > self.most_gain, self.most_gain / xp.where(size > 0, size, one), one)

    def through(self, support: Array, values: Array) -> Smoothed:
        """See ``Smoother``: without a limit of the gain, K(Y, X) times what is solved for once."""
        if self.most_gain != math.inf:
            return lambda at, variance: self.weights(support, at, variance) @ values
        solved = array_namespace(support, values).linalg.solve(self._covariance(support), values)
        return lambda at, variance: squared_exponential(at, support, self.length, variance) @ solved

    def _covariance(self, support: Array) -> Array:
        """K(X, X) + σ²I, well enough conditioned to be solved with."""
        xp = array_namespace(support)
        noise = self.noise * xp.eye(support.shape[0], dtype=support.dtype, device=support.device)
        inner = squared_exponential(support, support, self.length) + noise
        condition = _condition(xp, inner)
        if not condition * xp.finfo(support.dtype).eps < 1e-3:
            raise InputError(
                "support states", found=f"a covariance matrix of condition {condition:.1e}",
                wanted="states that can be told apart", hint="a larger noise, a shorter length, or a larger radius",
            )  # fmt: skip
        return inner


@dataclass(frozen=True)
class Averager:
    """Normalised covariances k / max(Σk, floor): weights of at least 0 that sum to at most 1 (Gordon 1995).

    Planning with it is a contraction: it converges, and the residual bounds the error.

    Attributes
    ----------
    length:
        Of the squared exponential, in units of the metric.
    floor:
        Farther from the support than this much covariance, values fall towards zero.
    """

    length: float = 0.7
    floor: float = 0.2

    def __post_init__(self) -> None:
        positive("length", self.length)
        positive("floor", self.floor)

    @property
    def contracts(self) -> bool:
        """It does."""
        return True

    def weights(self, support: Array, at: Array, variance: Array | None = None) -> Array:
        """See ``Smoother``."""
        xp = array_namespace(support, at)
        near = squared_exponential(at, support, self.length, variance)
        total = xp.sum(near, axis=1, keepdims=True)
        return near / xp.where(total > self.floor, total, xp.full_like(total, self.floor))

    def through(self, support: Array, values: Array) -> Smoothed:
        """See ``Smoother``."""
        return lambda at, variance: self.weights(support, at, variance) @ values


def squared_exponential(at: Array, centres: Array, length: float, variance: Array | None = None) -> Array:
    """(q, n) values exp(−‖x − c‖²/(2λ²)) (thesis 2.14), or their expectations where x is Gaussian.

    ``at`` (q, e), ``centres`` (n, e). For x ~ N(μ, diag(v)), ``variance`` (q, e), it is Π_j (1 + v_j/λ²)^−½
    exp(−(μ_j − c_j)²/(2(λ² + v_j))).
    """
    xp = array_namespace(at, centres)
    middle = xp.mean(centres, axis=0)
    at, centres = at - middle, centres - middle
    if variance is None:
        square = xp.sum(at**2, axis=1)[:, None] + xp.sum(centres**2, axis=1)[None, :] - 2 * (at @ centres.T)
        return xp.exp(xp.clip(square, min=0.0) * (-0.5 / length**2))
    scale = 1 / (length**2 + variance)
    square = xp.sum(scale * at**2, axis=1)[:, None] + scale @ (centres**2).T - 2 * ((scale * at) @ centres.T)
    shrink = -0.5 * xp.sum(xp.log1p(variance / length**2), axis=1)
    return xp.exp(shrink[:, None] - 0.5 * xp.clip(square, min=0.0))


def _condition(xp: Any, matrix: Array) -> float:
    """Largest over smallest eigenvalue of a symmetric matrix; infinity where rounding makes it singular."""
    values = xp.linalg.eigvalsh(matrix)
    least, most = float(xp.min(values)), float(xp.max(values))
    return most / least if least > 0 else math.inf
