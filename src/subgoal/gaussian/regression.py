"""Gaussian-process regression (thesis 2.5): mean, variance and weights from one factorisation, for many functions."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from sklearn.gaussian_process.kernels import Kernel

from subgoal.gaussian.covariances import noisy_covariance
from subgoal.gaussian.evidence import Ascent, Fitted, ascend, evidence_slope, log_evidence
from subgoal.gaussian.factor import Factor, RegressionWarning, Status, factorise
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array, whole
from subgoal.runtime.errors import InputError

MOST_JITTER = 1e-6
AGREE = 1e-12
"""Values at one point agree within this share of the largest value."""


class Regression(Protocol):
    """What every Gaussian process here can say of the functions behind its observations."""

    @property
    def log_evidence(self) -> Any:
        """Log evidence, or a lower bound of it, of each function."""

    def mean(self, at: Any) -> Floats:
        """(m,) or (m, G) posterior mean at places (m, d)."""

    def variance(self, at: Any) -> Floats:
        """(m,) posterior variance of the function."""

    def weights(self, at: Any) -> Floats:
        """(m, n) by which the posterior mean is made of the observed values."""


@dataclass(frozen=True, eq=False, repr=False)
class GaussianProcess:
    """A Gaussian process given n observations of one or G functions.

    Attributes
    ----------
    points, values:
        (n, d) where, and (n,) or (n, G) what was observed.
    covariance:
        k with its hyper-parameters, one set for all functions, without noise.
    noise:
        σ², the variance of an observation.
    prior_mean:
        Constant that the function is expected to have far from the points; a number, or (G,).
    factor:
        Cholesky factor of K + σ²I over the u distinct points.
    log_evidence:
        (2.15) with its constant, in nats: a number, or (G,). Where points were merged, that of the distinct ones.
    fitted:
        Where the hyper-parameters come from.
    unidentified:
        Names of hyper-parameters that the points do not tell.
    """

    points: Floats
    values: Floats
    covariance: Kernel
    noise: float
    prior_mean: Any
    factor: Factor
    log_evidence: Any
    fitted: Fitted
    unidentified: tuple[str, ...]
    _basis: Floats = field(repr=False)
    _solved: Floats = field(repr=False)
    _row: Ints = field(repr=False)

    def __repr__(self) -> str:
        n, d = self.points.shape
        told = f"{n} observations in {d} dimensions, {self.covariance}, noise {self.noise:.3g}"
        return f"GaussianProcess({told}: {self.status.name}, {self.fitted.name})"

    @property
    def jitter(self) -> float:
        """Variance that had to be added beside the noise; 0 but for status JITTERED."""
        return self.factor.jitter

    @property
    def condition(self) -> float:
        """Estimated condition number of what was factorised."""
        return self.factor.condition

    @property
    def merged(self) -> int:
        """Observations that repeat another one and were merged with it; only without noise."""
        return len(self.points) - len(self._basis)

    @property
    def status(self) -> Status:
        """What the numbers are worth."""
        return Status.MERGED if self.merged and self.factor.status is Status.EXACT else self.factor.status

    @property
    def pooled_log_evidence(self) -> float:
        """Sum over the functions, which is what the hyper-parameters are learned by."""
        return float(np.sum(self.log_evidence))

    def mean(self, at: Any) -> Floats:
        """(m,) or (m, G) posterior mean (2.12) at places (m, d)."""
        mean = self._to(at) @ self._solved + self.prior_mean
        return np.asarray(mean[:, 0] if self.values.ndim == 1 else mean)

    def variance(self, at: Any) -> Floats:
        """(m,) posterior variance (2.13) of the function, noise left out; less than 0 by rounding is given as 0."""
        places = check_places(at, self.points)
        known = (self.factor.half_solve(self.covariance(self._basis, places)) ** 2).sum(axis=0)
        return np.asarray(np.maximum(self.covariance.diag(places) - known, 0.0))

    def weights(self, at: Any) -> Floats:
        """(m, n) K(at, X)(K + σ²I)⁻¹: the mean is m + W(y − m). Observations that were merged have equal shares."""
        of_distinct = self.factor.solve(self._to(at).T)
        share = np.bincount(self._row)[self._row]
        return np.asarray((of_distinct[self._row] / share[:, None]).T)

    def _to(self, at: Any) -> Floats:
        return np.asarray(self.covariance(check_places(at, self.points), self._basis))


def fit(
    points: Any,
    values: Any,
    covariance: Kernel,
    *,
    noise: float = 0.0,
    mean: Any = 0.0,
    optimise: bool = True,
    most_iterations: int = 100,
    restarts: int = 0,
    seed: int = 0,
    most_jitter: float = MOST_JITTER,
) -> GaussianProcess:
    """Condition a Gaussian process on observations, and learn its hyper-parameters by the evidence.

    Parameters
    ----------
    points, values:
        (n, d) places and (n,) values of one function, or (n, G) of several. These share their hyper-parameters, which
        have the greatest evidence summed over the functions, and one factorisation.
    covariance:
        Of ``sklearn.gaussian_process.kernels``; (2.14) is ``ConstantKernel(ν²) * RBF(λ)``. A ``WhiteKernel`` added to
        it is noise that is learned. Bounds and "fixed" are obeyed.
    noise:
        σ² ≥ 0, as given.
    mean:
        Prior mean, a number or (G,).
    optimise:
        False leaves the hyper-parameters as they are.
    most_iterations, restarts, seed:
        Of the search (``ascend``). It is local: a start with length scales far too long can end where they are so short
        that no two points know of each other, and is then called UNIDENTIFIED. Start short, or with restarts.
    most_jitter:
        Where K + σ²I is singular in floating point a variance is added, at most this share of the mean variance, and
        told by status, ``jitter`` and a ``RegressionWarning``. 0 never adds any.

    Raises
    ------
    InputError
        Wrong shapes, NaN, infinity, no observations, or, without noise, different values at one point.
    SingularError
        The covariance stays singular.
    """
    x, y = observations(points, values)
    columns = y[:, None] if y.ndim == 1 else y
    centre = prior_mean(mean, y)
    model = noisy_covariance(covariance, noise, x)
    basis, row = x, np.arange(len(x))
    if model.noise == 0:
        basis, row, columns = _merged(x, columns)
    residual = columns - centre
    ascent = Ascent(model)
    if optimise:
        ascent = ascend(
            lambda tried: evidence_slope(tried, basis, residual), model, basis, seed=seed,
            most_iterations=whole("most_iterations", most_iterations), restarts=whole("restarts", restarts, least=0),
        )  # fmt: skip
    model = ascent.model
    factor = factorise(model.matrix(basis), positive("most_jitter", most_jitter, zero=True))
    evidence = log_evidence(factor, residual)
    process = GaussianProcess(
        points=x, values=y, covariance=model.signal, noise=model.noise, prior_mean=centre, factor=factor,
        log_evidence=float(evidence[0]) if y.ndim == 1 else frozen(evidence), fitted=ascent.fitted,
        unidentified=ascent.unidentified,
        _basis=frozen(basis), _solved=frozen(factor.solve(residual)), _row=frozen(row),
    )  # fmt: skip
    warn(process.status, process.fitted, process.jitter, process.unidentified)
    return process


def observations(points: Any, values: Any) -> tuple[Floats, Floats]:
    """Points (n, d) and values (n,) or (n, G), checked."""
    x, y = real_array("points", points, ndim=2), real_array("values", values, ndim=(1, 2))
    if not x.size or not y.size:
        raise InputError("points and values", found=f"shapes {x.shape} and {y.shape}", wanted="at least one of each")
    if len(x) != len(y):
        raise InputError("values", found=f"{len(y)} rows", wanted=f"{len(x)}, one per point")
    return x, y


def prior_mean(mean: Any, values: Floats) -> Any:
    """A number, or (G,) numbers for values (n, G)."""
    centre = real_array("mean", mean, ndim=(0, 1))
    if centre.ndim and centre.shape != values.shape[1:]:
        raise InputError("mean", found=f"shape {centre.shape}", wanted=f"a number, or shape {values.shape[1:]}")
    return centre if centre.ndim else float(centre)


def check_places(at: Any, points: Floats) -> Floats:
    """``at`` as (m, d)."""
    places = real_array("at", at, ndim=2)
    if places.shape[1] != points.shape[1]:
        raise InputError("at", found=f"{places.shape[1]} columns", wanted=f"{points.shape[1]}, as the points")
    return places


def warn(status: Status, fitted: Fitted, jitter: float, names: tuple[str, ...]) -> None:
    """What should not be overlooked."""
    if status in (Status.JITTERED, Status.ILL_CONDITIONED):
        added = f" Added: {jitter:.3g}." if jitter else ""
        warnings.warn(f"{status.value}.{added}", RegressionWarning, stacklevel=3)
    if fitted is Fitted.UNIDENTIFIED:
        warnings.warn(f"{fitted.value} ({', '.join(names)}).", RegressionWarning, stacklevel=3)


def _merged(points: Floats, columns: Floats) -> tuple[Floats, Ints, Floats]:
    """Distinct points (u, d), the one of each observation (n,), and their values (u, G)."""
    distinct, first, row = np.unique(points, axis=0, return_index=True, return_inverse=True)
    if len(distinct) == len(points):
        return points, np.arange(len(points)), columns
    row = row.reshape(-1)
    off = np.abs(columns - columns[first][row]).max(axis=1)
    if not off.max() <= AGREE * np.abs(columns).max():
        k = int(np.argmax(off))
        raise InputError(
            "values", where=f"rows {first[row[k]]} and {k}", found=f"values {off[k]:.3g} apart at one point",
            wanted="one value at each point, as there is no noise", hint="noise=, or a WhiteKernel",
        )  # fmt: skip
    return distinct, row, np.asarray(columns[first])
