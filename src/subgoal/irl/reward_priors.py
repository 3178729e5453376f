"""Priors of the reward of a state, or of the weight of a feature: what Bayesian IRL starts from (thesis 3.1, 3.8).

Each has ``log_density(values)``, complete and −inf outside the support, and ``start``, where a chain begins: the mode,
and of several the one nearest zero. Every parameter that is a reward is in the units of the reward.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import betaln, erf, softmax, xlog1py, xlogy

from subgoal.runtime.checks import Floats, positive, real_array
from subgoal.runtime.errors import InputError

PRINTED_STEEPNESS = 0.001
"""Of (3.8), per squared unit of reward."""
SCALED_STEEPNESS = 10.0
"""Per squared R_max: 0.001 for rewards of magnitude 100, with which the three peaks can be told apart."""
WEIGHTS = (0.4, 0.4, 1.0)
"""Of the peaks at the smallest, the largest and zero reward in (3.8)."""
SCAN = 2_001


@dataclass(frozen=True)
class Gaussian:
    """Normal around zero. ``deviation``: its standard deviation."""

    deviation: float

    def __post_init__(self) -> None:
        positive("Gaussian deviation", self.deviation)

    @property
    def start(self) -> float:
        """Zero."""
        return 0.0

    def log_density(self, values: Any) -> Floats:
        """Log density of each value."""
        score = _rewards(values) / self.deviation
        return np.asarray(-0.5 * score**2 - math.log(self.deviation * math.sqrt(2 * math.pi)))


@dataclass(frozen=True)
class Laplace:
    """Density ∝ exp(−|R|/scale): most states have no reward. ``scale``: the mean of |R|."""

    scale: float

    def __post_init__(self) -> None:
        positive("Laplace scale", self.scale)

    @property
    def start(self) -> float:
        """Zero."""
        return 0.0

    def log_density(self, values: Any) -> Floats:
        """Log density of each value."""
        return np.asarray(-np.abs(_rewards(values)) / self.scale - math.log(2 * self.scale))


@dataclass(frozen=True)
class Uniform:
    """The same density from ``low`` to ``high``, both included."""

    low: float
    high: float

    def __post_init__(self) -> None:
        _check_range("Uniform", self.low, self.high)

    @property
    def start(self) -> float:
        """The value nearest zero."""
        return min(max(0.0, self.low), self.high)

    def log_density(self, values: Any) -> Floats:
        """Log density of each value."""
        rewards = _rewards(values)
        inside = (rewards >= self.low) & (rewards <= self.high)
        return np.where(inside, -math.log(self.high - self.low), -np.inf)


@dataclass(frozen=True)
class Beta:
    """Density ∝ x^{a − 1}(1 − x)^{b − 1} of x = (R − low)/(high − low).

    Ramachandran & Amir (2007) let a = b = 1/2 where most rewards are near an end. Where the density goes to infinity,
    at an end with an exponent below zero, that end does not belong to the support.
    """

    a: float
    b: float
    low: float
    high: float

    def __post_init__(self) -> None:
        positive("Beta a", self.a)
        positive("Beta b", self.b)
        _check_range("Beta", self.low, self.high)

    @property
    def start(self) -> float:
        """The mode; the value nearest zero where all are as probable; the mean where the density is not bounded."""
        if self.a == self.b == 1:
            return min(max(0.0, self.low), self.high)
        bounded = self.a >= 1 and self.b >= 1
        part = (self.a - 1) / (self.a + self.b - 2) if bounded else self.a / (self.a + self.b)
        return self.low + part * (self.high - self.low)

    def log_density(self, values: Any) -> Floats:
        """Log density of each value."""
        rewards, span = _rewards(values), self.high - self.low
        inside = (rewards >= self.low) & (rewards <= self.high)
        part = np.where(inside, (rewards - self.low) / span, 0.5)
        told = xlogy(self.a - 1, part) + xlog1py(self.b - 1, -part) - betaln(self.a, self.b) - math.log(span)
        return np.where(inside & (told < np.inf), told, -np.inf)


@dataclass(frozen=True)
class ThreePeaks:
    """Thesis (3.8): most rewards are zero, others the smallest or the largest.

    Density ∝ w₋ exp(−κ(R − low)²) + w₊ exp(−κ(R − high)²) + w₀ exp(−κR²).

    Attributes
    ----------
    low, high:
        R_min and R_max, in units of reward; zero lies between them.
    steepness:
        κ, per squared unit of reward: the standard deviation of a peak is 1/√(2κ). As printed, 0.001: a deviation of
        22.4, beside which rewards of 0.01 all have the same density. ``scaled`` has it in units of R_max.
    weights:
        (w₋, w₊, w₀).
    bounded:
        Whether the support ends at ``low`` and ``high``; as printed it does not.
    """

    low: float
    high: float
    steepness: float = PRINTED_STEEPNESS
    weights: tuple[float, float, float] = WEIGHTS
    bounded: bool = False

    def __post_init__(self) -> None:
        _check_range("ThreePeaks", self.low, self.high)
        if not self.low <= 0 <= self.high:
            found = f"{self.low} to {self.high}"
            raise InputError("ThreePeaks low and high", found=found, wanted="zero between them")
        positive("ThreePeaks steepness", self.steepness)
        weights = real_array("ThreePeaks weights", self.weights, ndim=1)
        if not (weights.size == 3 and (weights > 0).all()):
            raise InputError("ThreePeaks weights", found=self.weights, wanted="three numbers above 0")

    @classmethod
    def scaled(
        cls, magnitude: float = 1.0, *, steepness: float = SCALED_STEEPNESS, bounded: bool = False
    ) -> ThreePeaks:
        """Peaks at zero and at ±``magnitude``, with ``steepness`` per squared ``magnitude``."""
        size = positive("magnitude", magnitude)
        return cls(-size, size, positive("steepness", steepness) / size**2, bounded=bounded)

    @property
    def start(self) -> float:
        """The mode nearest zero: of the modes, which all lie between ``low`` and ``high``."""
        beyond = (self.high - self.low) / SCAN
        grid = np.union1d(np.linspace(self.low - beyond, self.high + beyond, SCAN), [0.0])
        slope = self._uphill(grid)
        tops = np.flatnonzero((slope[:-1] > 0) & (slope[1:] <= 0))
        modes = [brentq(lambda x: float(self._uphill(np.array([x]))[0]), grid[i], grid[i + 1]) for i in tops]
        return float(min(modes, key=abs))

    def log_density(self, values: Any) -> Floats:
        """Log density of each value."""
        rewards = _rewards(values)
        height = np.logaddexp.reduce(self._log_peaks(rewards), axis=-1) - math.log(self._mass())
        if self.bounded:
            height = np.where((rewards >= self.low) & (rewards <= self.high), height, -np.inf)
        return np.asarray(height)

    @property
    def _centres(self) -> Floats:
        return np.array([self.low, self.high, 0.0])

    def _log_peaks(self, rewards: Floats) -> Floats:
        return np.asarray(np.log(self.weights) - self.steepness * (rewards[..., None] - self._centres) ** 2)

    def _uphill(self, rewards: Floats) -> Floats:
        """Slope of the log density over 2κ: the mean of the centres, weighted as the peaks are there, less R."""
        return np.asarray(softmax(self._log_peaks(rewards), axis=-1) @ self._centres - rewards)

    def _mass(self) -> float:
        """Integral of the sum of the peaks over the support."""
        root = math.sqrt(self.steepness)
        inside = np.ones(3)
        if self.bounded:
            inside = (erf(root * (self.high - self._centres)) + erf(root * (self._centres - self.low))) / 2
        return math.sqrt(math.pi) / root * float(np.dot(self.weights, inside))


def _check_range(name: str, low: float, high: float) -> None:
    ends = real_array(f"{name} low and high", [low, high], ndim=1)
    if not ends[0] < ends[1]:
        raise InputError(f"{name} low and high", found=f"{low} and {high}", wanted="the smaller one, then the larger")


def _rewards(values: Any) -> Floats:
    rewards = real_array("reward", values, ndim=(0, 1, 2, 3), finite=False)
    if np.isnan(rewards).any():
        index = tuple(int(k) for k in np.argwhere(np.isnan(rewards))[0])
        raise InputError("reward", where=f"index {index}", found="nan", wanted="a number")
    return rewards
