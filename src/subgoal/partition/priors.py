"""Priors of the few numbers that can be learned, and the one move that draws such a number."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError

SMALLEST_LOG = -600.0
"""Logarithms of weights stop here: smaller ones cannot be told from zero in the arithmetic of the samplers."""
MOST_STEPS = 64


@dataclass(frozen=True)
class Gamma:
    """Density ∝ x^{shape − 1} e^{−rate·x} of a positive number, of mean shape / rate."""

    shape: float = 1.0
    rate: float = 1.0

    def __post_init__(self) -> None:
        positive("Gamma shape", self.shape)
        positive("Gamma rate", self.rate)

    @property
    def start(self) -> float:
        """Where a chain begins: the mean."""
        return self.shape / self.rate

    def log_density(self, x: float) -> float:
        """Complete log density."""
        norm = self.shape * math.log(self.rate) - math.lgamma(self.shape)
        return norm + (self.shape - 1) * math.log(x) - self.rate * x


@dataclass(frozen=True)
class LogNormal:
    """log x is normal: ``median`` of x, and ``spread``, the standard deviation of log x."""

    median: float = 1.0
    spread: float = 1.0

    def __post_init__(self) -> None:
        positive("LogNormal median", self.median)
        positive("LogNormal spread", self.spread)

    @property
    def start(self) -> float:
        """Where a chain begins: the median."""
        return self.median

    def log_density(self, x: float) -> float:
        """Complete log density of x (not of its logarithm)."""
        score = (math.log(x) - math.log(self.median)) / self.spread
        return -0.5 * score * score - math.log(self.spread * math.sqrt(2 * math.pi)) - math.log(x)


@dataclass(frozen=True)
class Beta:
    """Density ∝ x^{a − 1}(1 − x)^{b − 1} of a probability; uniform by default."""

    a: float = 1.0
    b: float = 1.0

    def __post_init__(self) -> None:
        positive("Beta a", self.a)
        positive("Beta b", self.b)

    @property
    def start(self) -> float:
        """Where a chain begins: the mean."""
        return self.a / (self.a + self.b)

    def log_density(self, x: float) -> float:
        """Complete log density."""
        norm = math.lgamma(self.a + self.b) - math.lgamma(self.a) - math.lgamma(self.b)
        return norm + (self.a - 1) * math.log(x) + (self.b - 1) * math.log1p(-x)


def concentration_of(value: float | Gamma) -> float | Gamma:
    """A checked concentration: a number above zero, or its prior."""
    if isinstance(value, Gamma):
        return value
    return positive("concentration", value)


def probability_of(what: str, value: float | Beta) -> float | Beta:
    """A checked probability below one, or its prior."""
    if isinstance(value, Beta):
        return value
    number = positive(what, value, zero=True)
    if number >= 1:
        raise InputError(what, found=number, wanted="a probability below 1, or a Beta prior")
    return number


def log_weights(shape: Floats, generator: np.random.Generator) -> Floats:
    """(G,) logarithm of a draw from Dirichlet(shape), exact for shapes far below one, cut at e^−600.

    Gamma(a) is Gamma(a + 1)·U^{1/a}, in logarithms.
    """
    value = np.log(generator.standard_gamma(shape + 1)) + np.log1p(-generator.random(shape.size)) / shape
    value -= value.max()
    value -= np.log(np.exp(value).sum())
    return np.asarray(np.maximum(value, SMALLEST_LOG))


def slice_draw(log_density: Callable[[float], float], x: float, width: float, generator: np.random.Generator) -> float:
    """One update of a real number that leaves its law invariant (Neal 2003: stepping out, then shrinking).

    ``log_density`` may lack its constant; ``width`` is the guessed size of the slice.
    """
    level = log_density(x) - generator.standard_exponential()
    low = x - width * generator.random()
    high = low + width
    left = int(MOST_STEPS * generator.random())
    for _ in range(left):
        if log_density(low) <= level:
            break
        low -= width
    for _ in range(MOST_STEPS - 1 - left):
        if log_density(high) <= level:
            break
        high += width
    while True:
        proposal = low + (high - low) * generator.random()
        if log_density(proposal) > level:
            return proposal
        if proposal == x:
            return x
        low, high = (proposal, high) if proposal < x else (low, proposal)
