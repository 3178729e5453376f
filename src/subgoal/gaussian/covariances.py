"""A covariance in two parts: what the function does, and the noise that is added to every observation of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from sklearn.gaussian_process.kernels import Kernel, Sum, WhiteKernel

from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError

NOISE = "noise"
"""Name of the noise variance among the hyper-parameters."""


@dataclass(frozen=True)
class NoisyCovariance:
    """K + σ²I of (2.12): the covariance of the function, and the variance of an observation.

    Attributes
    ----------
    signal:
        k(x, x′), a covariance of scikit-learn without noise.
    noise:
        σ².
    noise_bounds:
        Within which σ² is learned; None where it is given.
    """

    signal: Kernel
    noise: float
    noise_bounds: tuple[float, float] | None = None

    @property
    def theta(self) -> Floats:
        """(p,) logarithms of the hyper-parameters that may be learned; that of the noise is last."""
        own = [] if self.noise_bounds is None else [np.log(self.noise)]
        return np.concatenate([self.signal.theta, own])

    @property
    def bounds(self) -> Floats:
        """(p, 2) of ``theta``."""
        own = np.zeros((0, 2)) if self.noise_bounds is None else np.log([self.noise_bounds])
        return np.concatenate([np.reshape(self.signal.bounds, (-1, 2)), own])

    @property
    def names(self) -> tuple[str, ...]:
        """p names, as scikit-learn's, with the number of the dimension where there are several."""
        told: list[str] = []
        for parameter in self.signal.hyperparameters:
            several = [f"{parameter.name}[{k}]" for k in range(parameter.n_elements)]
            told += [] if parameter.fixed else several if parameter.n_elements > 1 else [parameter.name]
        return (*told, *([] if self.noise_bounds is None else [NOISE]))

    def at(self, theta: Floats) -> NoisyCovariance:
        """The same with other hyper-parameters."""
        count = self.signal.n_dims
        noise = self.noise if self.noise_bounds is None else float(np.exp(theta[count]))
        return replace(self, signal=self.signal.clone_with_theta(theta[:count]), noise=noise)

    def matrix(self, points: Floats) -> Floats:
        """(n, n) K(X, X) + σ²I."""
        matrix = np.array(self.signal(points))
        matrix[np.diag_indices_from(matrix)] += self.noise
        return matrix

    def matrix_and_slopes(self, points: Floats) -> tuple[Floats, Floats]:
        """K(X, X) + σ²I and its derivatives (n, n, p) with respect to ``theta``."""
        matrix, slopes = self.signal(points, eval_gradient=True)
        matrix[np.diag_indices_from(matrix)] += self.noise
        if self.noise_bounds is not None:
            slopes = np.dstack([slopes, self.noise * np.eye(len(points))])
        return matrix, slopes


def noisy_covariance(covariance: Any, noise: Any, points: Floats) -> NoisyCovariance:
    """``covariance`` taken apart: a ``WhiteKernel`` added to it is noise to be learned, ``noise`` is noise as given.

    Raises ``InputError`` for anything but a covariance of scikit-learn that fits ``points`` (n, d), for two kinds of
    noise at once, and for noise that is multiplied.
    """
    noise = positive("noise", noise, zero=True)
    if not isinstance(covariance, Kernel):
        raise InputError("covariance", found=type(covariance).__name__, wanted="one of scikit-learn's")
    parts = list(_summands(covariance))
    white = [part for part in parts if isinstance(part, WhiteKernel)]
    signal = [part for part in parts if not isinstance(part, WhiteKernel)]
    if any(isinstance(inner, WhiteKernel) for part in signal for inner in part.get_params().values()):
        raise InputError("covariance", found="a WhiteKernel that is multiplied", wanted="one that is added, or noise=")
    if len(white) > 1 or (white and noise > 0):
        raise InputError("noise", found="noise of two kinds", wanted="one WhiteKernel in the covariance, or noise=")
    if not signal:
        raise InputError("covariance", found="noise alone", wanted="a covariance of the function too")
    whole = signal[0]
    for part in signal[1:]:
        whole = whole + part
    _check_fits(whole, points)
    if not white:
        return NoisyCovariance(whole, noise)
    level = white[0].noise_level
    if white[0].hyperparameter_noise_level.fixed:
        return NoisyCovariance(whole, positive("noise_level", level, zero=True))
    least, most = np.ravel(white[0].noise_level_bounds)
    return NoisyCovariance(whole, positive("noise_level", level), (float(least), float(most)))


def _summands(covariance: Kernel) -> Iterator[Kernel]:
    if isinstance(covariance, Sum):
        yield from _summands(covariance.k1)
        yield from _summands(covariance.k2)
    else:
        yield covariance


def _check_fits(signal: Kernel, points: Floats) -> None:
    """That it gives one number for two points."""
    wanted = f"a covariance of points in {points.shape[1]} dimensions"
    try:
        shape = np.shape(signal(points[:1], points[:1]))
    except (ValueError, TypeError) as problem:
        raise InputError("covariance", found=f"{signal} ({problem})", wanted=wanted) from None
    if shape != (1, 1):
        raise InputError("covariance", found=f"{signal}, which gives {shape}", wanted=wanted)
