"""Gaussian-process regression through a few inducing points, for many observations (Titsias 2009).

The mean and the weights are those of a process whose covariance is what the inducing points carry of it (projected
process, DTC); the variance keeps the rest of the prior, and may still be less than that of the whole process at some
places. Hyper-parameters are learned by the variational bound (VFE). The evidence of FITC is no such bound: it can
exceed that of the whole process (Bauer, van der Wilk and Rasmussen 2016).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from sklearn.gaussian_process.kernels import Kernel

from subgoal.gaussian.covariances import noisy_covariance
from subgoal.gaussian.evidence import Ascent, Fitted, ascend
from subgoal.gaussian.evidence_bound import Carried, bound_slope, carried
from subgoal.gaussian.factor import Status
from subgoal.gaussian.regression import MOST_JITTER, check_places, observations, prior_mean, warn
from subgoal.runtime.checks import Floats, frozen, positive, real_array, whole
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class SparseGaussianProcess:
    """A Gaussian process given n observations through m inducing points; answers as ``GaussianProcess`` does.

    Attributes
    ----------
    points, values, covariance, noise, prior_mean, fitted, unidentified:
        As in ``GaussianProcess``.
    inducing:
        (m, d).
    log_evidence:
        Lower bound of (2.15), in nats: a number, or (G,).
    """

    points: Floats
    values: Floats
    covariance: Kernel
    noise: float
    prior_mean: Any
    inducing: Floats
    log_evidence: Any
    fitted: Fitted
    unidentified: tuple[str, ...]
    _carried: Carried = field(repr=False)
    _solved: Floats = field(repr=False)

    def __repr__(self) -> str:
        told = f"{len(self.points)} observations through {len(self.inducing)} points, {self.covariance}"
        return f"SparseGaussianProcess({told}, noise {self.noise:.3g}: {self.status.name}, {self.fitted.name})"

    @property
    def jitter(self) -> float:
        """Variance that had to be added to that of the inducing points; 0 but for status JITTERED."""
        return self._carried.own.jitter

    @property
    def condition(self) -> float:
        """Estimated condition number of the worse of the two matrices that were factorised."""
        return max(self._carried.own.condition, self._carried.inner.condition)

    @property
    def status(self) -> Status:
        """What the numbers are worth, beside what the inducing points cannot carry."""
        own, inner = self._carried.own.status, self._carried.inner.status
        return own if own is not Status.EXACT else inner

    @property
    def pooled_log_evidence(self) -> float:
        """Bound summed over the functions, which is what the hyper-parameters are learned by."""
        return float(np.sum(self.log_evidence))

    def mean(self, at: Any) -> Floats:
        """(m,) or (m, G) posterior mean at places (m, d)."""
        mean = self.covariance(check_places(at, self.points), self.inducing) @ self._solved + self.prior_mean
        return np.asarray(mean[:, 0] if self.values.ndim == 1 else mean)

    def variance(self, at: Any) -> Floats:
        """(m,) posterior variance of the function, noise left out; less than 0 by rounding is given as 0."""
        places = check_places(at, self.points)
        half = self._carried.own.half_solve(self.covariance(self.inducing, places))
        known = (half**2).sum(axis=0) - (self._carried.inner.half_solve(half) ** 2).sum(axis=0)
        return np.asarray(np.maximum(self.covariance.diag(places) - known, 0.0))

    def weights(self, at: Any) -> Floats:
        """(m, n) Q(at, X)(Q + σ²I)⁻¹: the mean is m + W(y − m)."""
        half = self._carried.own.half_solve(self.covariance(self.inducing, check_places(at, self.points)))
        return np.asarray(self._carried.inner.solve(half).T @ self._carried.crossed / np.sqrt(self.noise))


def fit_sparse(
    points: Any,
    values: Any,
    covariance: Kernel,
    inducing: Any,
    *,
    noise: float = 0.0,
    mean: Any = 0.0,
    optimise: bool = True,
    most_iterations: int = 100,
    restarts: int = 0,
    seed: int = 0,
    most_jitter: float = MOST_JITTER,
) -> SparseGaussianProcess:
    """Condition a Gaussian process on many observations in O(n·m²).

    Parameters
    ----------
    inducing:
        (m, d) distinct places, such as ``farthest_points(points, m)`` or ``k_means_centres(points, m)``. With those of
        the observations themselves, all is as in ``fit``.
    points, values, covariance, noise, mean, optimise, most_iterations, restarts, seed, most_jitter:
        As in ``fit``. Noise, given or learned, must be above 0. ``most_jitter`` is a share of the variance of the
        inducing points.

    Raises
    ------
    InputError
        As ``fit``; no noise; inducing points of another dimension, none, or one of them twice.
    SingularError
        The covariance of the inducing points stays singular.
    """
    x, y = observations(points, values)
    centre, model = prior_mean(mean, y), noisy_covariance(covariance, noise, x)
    places, most_jitter = _inducing(inducing, x), positive("most_jitter", most_jitter, zero=True)
    if not model.noise > 0:
        raise InputError("noise", found=0, wanted="a number above 0, or a WhiteKernel", hint="fit, without it")
    residual = (y[:, None] if y.ndim == 1 else y) - centre
    ascent = Ascent(model)
    if optimise:
        ascent = ascend(
            lambda tried: bound_slope(tried, x, residual, places, most_jitter), model, places, seed=seed,
            most_iterations=whole("most_iterations", most_iterations), restarts=whole("restarts", restarts, least=0),
        )  # fmt: skip
    model = ascent.model
    held = carried(model, x, places, most_jitter)
    bound = held.bound(residual)
    solved = held.inner.solve(held.crossed @ residual) / np.sqrt(model.noise)
    process = SparseGaussianProcess(
        points=x, values=y, covariance=model.signal, noise=model.noise, prior_mean=centre, inducing=places,
        log_evidence=float(bound[0]) if y.ndim == 1 else frozen(bound), fitted=ascent.fitted,
        unidentified=ascent.unidentified, _carried=held, _solved=frozen(held.own.other_half_solve(solved)),
    )  # fmt: skip
    warn(process.status, process.fitted, process.jitter, process.unidentified)
    return process


def _inducing(inducing: Any, points: Floats) -> Floats:
    places = real_array("inducing", inducing, ndim=2)
    if places.shape[1] != points.shape[1] or not len(places):
        raise InputError("inducing", found=f"shape {places.shape}", wanted=f"(m, {points.shape[1]}), m at least 1")
    _, first = np.unique(places, axis=0, return_index=True)
    if len(first) < len(places):
        again = int(np.setdiff1d(np.arange(len(places)), first)[0])
        raise InputError("inducing", where=f"row {again}", found="a place given before", wanted="distinct places")
    return places
