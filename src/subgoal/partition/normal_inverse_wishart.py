"""Gaussian clusters of unknown mean and covariance: the conjugate normal-inverse-Wishart prior, in closed form.

Model: Σ ~ IW(S₀, ν₀), μ | Σ ~ N(m₀, Σ/κ₀), x | μ, Σ ~ N(μ, Σ) in d dimensions. Formulas: Murphy 2007,
"Conjugate Bayesian analysis of the Gaussian distribution", section 9. All densities keep their constants.

A cluster is known by its summed statistics (n, Σ y, Σ y yᵀ) with y = x − m₀, one row of 1 + d + d² numbers, and its
parameters by one row (μ, Σ) of d + d² numbers, so that many clusters are handled at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import gammaln, multigammaln

from subgoal.runtime.checks import Floats, frozen, positive, real_array
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False)
class NormalInverseWishart:
    """A prior, or posterior, over the mean and covariance of one Gaussian cluster.

    Attributes
    ----------
    mean:
        (d,) m₀, in the units of the points.
    strength:
        κ₀ above 0: how many points the mean is worth.
    scale:
        (d, d) S₀, symmetric and positive definite, in squared units; E[Σ] = S₀/(ν₀ − d − 1).
    degrees:
        ν₀ above d − 1: how many points the scale is worth.
    """

    mean: Floats
    strength: float
    scale: Floats
    degrees: float

    def __post_init__(self) -> None:
        mean = real_array("mean", self.mean, ndim=1)
        scale = _covariance("scale", self.scale, mean.size)
        degrees = positive("degrees", self.degrees)
        if mean.size == 0:
            raise InputError("mean", found="no entries", wanted="at least one dimension")
        if not degrees > mean.size - 1:
            raise InputError("degrees", found=degrees, wanted=f"more than {mean.size - 1}, one less than d")
        object.__setattr__(self, "mean", frozen(mean.copy()))
        object.__setattr__(self, "strength", positive("strength", self.strength))
        object.__setattr__(self, "scale", frozen(scale.copy()))
        object.__setattr__(self, "degrees", degrees)

    @classmethod
    def from_data(cls, points: Any, *, strength: float = 0.05) -> NormalInverseWishart:
        """A vague prior in the units of the data: m₀ their mean, S₀ the identity once each column has sd 1, ν₀ = d + 3.

        ``points`` is (n, d) with n at least 2; a column without spread is refused.
        """
        x = real_array("points", points, ndim=2)
        spread = x.std(axis=0) if x.shape[0] > 1 else np.zeros(x.shape[1])
        if not (spread > 0).all():
            column = int(np.argmax(~(spread > 0)))
            raise InputError("points", where=f"column {column}", found="no spread", wanted="at least two values")
        return cls(mean=x.mean(axis=0), strength=strength, scale=np.diag(spread**2), degrees=x.shape[1] + 3.0)

    @property
    def dimension(self) -> int:
        """d."""
        return int(self.mean.size)

    def posterior(self, points: Any) -> NormalInverseWishart:
        """The law of (μ, Σ) once ``points`` (n, d) have been seen; n may be 0."""
        strength, shift, scale, degrees = self._update(self.statistics(points).sum(axis=0)[None])
        return NormalInverseWishart(self.mean + shift[0], float(strength[0]), scale[0], float(degrees[0]))

    def log_marginal(self, points: Any) -> float:
        """Log density of ``points`` (n, d) as one cluster, (μ, Σ) integrated out."""
        return float(self.log_marginal_of(self.statistics(points).sum(axis=0)[None])[0])

    def log_density(self, mean: Any, covariance: Any) -> float:
        """Log density of the parameters μ (d,) and Σ (d, d)."""
        mu, sigma = real_array("mean", mean, ndim=1), _covariance("covariance", covariance, self.dimension)
        if mu.size != self.dimension:
            raise InputError("mean", found=f"{mu.size} entries", wanted=f"{self.dimension}")
        d, nu = self.dimension, self.degrees
        inverse, log_det = np.linalg.inv(sigma), _log_det(sigma)
        spread = 0.5 * (nu * _log_det(self.scale) - (nu + d + 1) * log_det - np.trace(self.scale @ inverse))
        spread -= 0.5 * nu * d * np.log(2.0) + multigammaln(0.5 * nu, d)
        off = mu - self.mean
        place = d * np.log(self.strength / (2 * np.pi)) - log_det - self.strength * (off @ inverse @ off)
        return float(spread + 0.5 * place)

    def draw(self, generator: np.random.Generator) -> tuple[Floats, Floats]:
        """One mean (d,) and covariance (d, d)."""
        row = self.draw_given(np.zeros((1, 1 + self.dimension + self.dimension**2)), generator)[0]
        return row[: self.dimension], row[self.dimension :].reshape(self.dimension, self.dimension)

    def statistics(self, points: Any) -> Floats:
        """(n, 1 + d + d²) statistics of single points (n, d); those of a cluster are the sum over its points."""
        x = real_array("points", points, ndim=2)
        if x.shape[1] != self.dimension:
            raise InputError("points", found=f"{x.shape[1]} columns", wanted=f"{self.dimension}, as in the prior")
        y = x - self.mean
        square = (y[:, :, None] * y[:, None, :]).reshape(len(y), self.dimension**2)
        return np.hstack([np.ones((len(y), 1)), y, square])

    def log_marginal_of(self, totals: Floats) -> Floats:
        """(K,) log marginal of each of K clusters, from their summed statistics (K, 1 + d + d²)."""
        d, count = self.dimension, totals[:, 0]
        strength, _, scale, degrees = self._update(totals)
        shapes = 0.5 * (degrees[:, None] - np.arange(d))
        shapes0 = 0.5 * (self.degrees - np.arange(d))
        gain: Floats = (gammaln(shapes) - gammaln(shapes0)).sum(axis=1)
        gain -= 0.5 * count * d * np.log(np.pi)
        gain += 0.5 * (self.degrees * _log_det(self.scale) - degrees * _log_det(scale))
        gain += 0.5 * d * np.log(self.strength / strength)
        return gain

    def draw_given(self, totals: Floats, generator: np.random.Generator) -> Floats:
        """(K, d + d²) parameters of K clusters given their summed statistics; a row of zeros draws from the prior.

        Σ⁻¹ = L⁻ᵀ A Aᵀ L⁻¹, L Lᵀ = S and A Aᵀ ~ Wishart(I, ν) by Bartlett's triangle (Smith and Hocking 1972).
        """
        d, clusters = self.dimension, len(totals)
        strength, shift, scale, degrees = self._update(totals)
        triangle = np.tril(generator.standard_normal((clusters, d, d)), -1)
        triangle[:, np.arange(d), np.arange(d)] = np.sqrt(generator.chisquare(degrees[:, None] - np.arange(d)))
        root = np.linalg.cholesky(scale) @ np.linalg.inv(triangle).transpose(0, 2, 1)
        step = (root @ generator.standard_normal((clusters, d, 1)))[:, :, 0] / np.sqrt(strength)[:, None]
        covariance = root @ root.transpose(0, 2, 1)
        return np.hstack([self.mean + shift + step, covariance.reshape(clusters, d * d)])

    def log_likelihood(self, points: Floats, parameters: Floats) -> Floats:
        """(n, K) log N(x_i | μ_k, Σ_k) of ``points`` (n, d) under rows of ``parameters`` (K, d + d²)."""
        d = self.dimension
        mean, covariance = parameters[:, :d], parameters[:, d:].reshape(-1, d, d)
        whiten = np.linalg.inv(np.linalg.cholesky(covariance))
        white = np.einsum("kab,nkb->nka", whiten, points[:, None, :] - mean)
        log_volume = np.log(np.diagonal(whiten, axis1=1, axis2=2)).sum(axis=1)
        density: Floats = log_volume - 0.5 * (d * np.log(2 * np.pi) + (white**2).sum(axis=2))
        return density

    def _update(self, totals: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Strength (K,), shift of the mean (K, d), scale (K, d, d) and degrees (K,) after K summed statistics."""
        d, count = self.dimension, totals[:, 0]
        strength = self.strength + count
        shift = totals[:, 1 : 1 + d] / strength[:, None]
        outer = shift[:, :, None] * shift[:, None, :]
        scale = self.scale + totals[:, 1 + d :].reshape(-1, d, d) - strength[:, None, None] * outer
        return strength, shift, scale, self.degrees + count


def _log_det(matrices: Floats) -> Floats:
    sign, log_det = np.linalg.slogdet(matrices)
    if not (sign > 0).all():
        raise InputError(
            "points", found="values so far from the prior mean that a scale matrix lost its digits",
            wanted="points within about 1e7 prior standard deviations", hint="NormalInverseWishart.from_data(points)",
        )  # fmt: skip
    return np.asarray(log_det)


def _covariance(what: str, value: Any, dimension: int) -> Floats:
    """``value`` as a symmetric positive definite (d, d) matrix."""
    matrix = real_array(what, value, ndim=2)
    if matrix.shape != (dimension, dimension):
        raise InputError(what, found=f"shape {matrix.shape}", wanted=f"({dimension}, {dimension})")
    if not np.abs(matrix - matrix.T).max(initial=0.0) <= 1e-12 * np.abs(matrix).max(initial=0.0):
        raise InputError(what, found="a matrix that is not symmetric", wanted="a symmetric matrix")
    least = float(np.linalg.eigvalsh(matrix)[0]) if dimension else 1.0
    if not least > 0:
        raise InputError(what, found=f"a least eigenvalue of {least:.3g}", wanted="a positive definite matrix")
    return matrix
