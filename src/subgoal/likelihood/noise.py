"""Confidence that is learned: one number, or a law over levels from blind chance to near certainty."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from scipy.special import gammaln

from subgoal.likelihood.source import Assigned, Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.learning import Noise
from subgoal.partition.priors import LogNormal, slice_draw
from subgoal.runtime.checks import Floats, Ints, real_array
from subgoal.runtime.errors import InputError

LEVELS = (0.25, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Confidences in units of ``Source.unit``: a direction is all but free at the first, within 2 degrees at the last."""
WIDTH = 0.5
STACK = 2**25
"""Most densities that are kept, so that a mixture of levels is one product."""
SMALLEST, LARGEST = 1e-6, 1e8
WIDE = LogNormal(3.0, 1.5)


class NoiseSpec(Protocol):
    """What of the noise is to be learned, with its prior; bound to a table by ``of``."""

    def of(self, likelihood: LogLikelihood) -> Noise:
        """For one table."""


@dataclass(frozen=True)
class OneConfidence:
    """A single α for all observations, learned; ``law`` is its prior in units of ``Source.unit``."""

    law: LogNormal = WIDE

    def of(self, likelihood: LogLikelihood) -> Noise:
        """For one table."""
        return _One(likelihood, self.law)


@dataclass(frozen=True)
class OwnConfidence:
    """An α for each candidate, learned; they are independent beforehand, with ``law`` in units of ``Source.unit``."""

    law: LogNormal = WIDE

    def of(self, likelihood: LogLikelihood) -> Noise:
        """For one table."""
        return _Own(likelihood, self.law)


@dataclass(frozen=True)
class NoiseLevels:
    """Each action has one of M confidences; their shares are learned, uniform on the simplex beforehand.

    No form of the noise is assumed: some actions may be exact and others all but free, for all subgoals alike.
    ``levels`` are in units of ``Source.unit``.
    """

    levels: tuple[float, ...] = LEVELS

    def __post_init__(self) -> None:
        levels = real_array("noise levels", self.levels, ndim=1)
        if levels.size < 2 or not (np.diff(levels, prepend=0.0) > 0).all():
            raise InputError("noise levels", found=self.levels, wanted="two or more rising numbers above 0")

    def of(self, likelihood: LogLikelihood) -> Noise:
        """For one table."""
        return _Levels(likelihood, np.array(self.levels) * likelihood.source.unit)


@dataclass(frozen=True, eq=False)
class _One:
    likelihood: LogLikelihood
    law: LogNormal
    name: str = "confidence"

    def start(self) -> Floats:
        """The prior's median."""
        return np.array([self.law.start * self.likelihood.source.unit])

    def table(self, values: Floats) -> LogLikelihood:
        """The likelihood at this α."""
        return self.likelihood.at(float(values[0]))

    def draw(self, values: Floats, theta: Ints, generator: np.random.Generator) -> Floats:
        """A slice on log α."""
        told, rows = serving(self.likelihood, theta)
        weight = _weight(self.likelihood)[rows]

        def log_density(alpha: float) -> float:
            return float(told.log_density(alpha)[rows] @ weight) + self.log_density(np.array([alpha]))

        return np.array([draw_positive(log_density, float(values[0]), generator, self.likelihood.source.unit)])

    def summary(self, values: Floats) -> Floats:
        """Mean log α."""
        return np.asarray(np.log(values).mean(axis=-1))

    def log_density(self, values: Floats) -> float:
        """Log prior density of α."""
        unit = self.likelihood.source.unit
        return sum(self.law.log_density(alpha / unit) - math.log(unit) for alpha in values.tolist())


@dataclass(frozen=True, eq=False)
class _Own(_One):
    name: str = "confidence of each candidate"

    def start(self) -> Floats:
        """The prior's median, for all."""
        return np.full(self.likelihood.candidates.n_candidates, self.law.start * self.likelihood.source.unit)

    def table(self, values: Floats) -> LogLikelihood:
        """The likelihood at these α."""
        return self.likelihood.at(values)

    def draw(self, values: Floats, theta: Ints, generator: np.random.Generator) -> Floats:
        """A slice on log α of each candidate in use; the others from the prior."""
        told, rows = serving(self.likelihood, theta)
        unit, serves = self.likelihood.source.unit, np.asarray(theta)[rows]
        fresh = self.law.median * unit * np.exp(self.law.spread * generator.standard_normal(values.size))
        found = np.clip(fresh, SMALLEST * unit, LARGEST * unit)
        for g in np.unique(serves).tolist():
            own = rows[serves == g]
            part, weight = told.some(own), _weight(self.likelihood)[own]

            def log_density(alpha: float, part: Assigned = part, weight: Floats = weight) -> float:
                return float(part.log_density(alpha) @ weight) + self.law.log_density(alpha / unit)

            found[g] = draw_positive(log_density, float(values[g]), generator, unit)
        return found


@dataclass(frozen=True, eq=False)
class _Levels:
    likelihood: LogLikelihood
    confidences: Floats
    name: str = "noise levels"

    def start(self) -> Floats:
        """All alike."""
        return np.full(len(self.confidences), 1 / len(self.confidences))

    def table(self, values: Floats) -> LogLikelihood:
        """The likelihood with these shares."""
        mixed = self.likelihood.at(Levels(self.confidences, values))
        if self._stack is not None:
            densities, peak = self._stack
            n, g_count = peak.size, densities.shape[1] // peak.size
            mixed.hold(np.log(values @ densities).reshape(n, g_count) + peak[:, None])
        return mixed

    @cached_property
    def _stack(self) -> tuple[Floats, Floats] | None:
        """Densities (M, N·G) at each level over the largest of each observation, and its logarithm (N,)."""
        table = self.likelihood
        n, places = table.n_observations, table.candidates.n_candidates
        if len(self.confidences) * n * places > STACK:
            return None
        each = np.stack([table.source.log_density(0, n, level) for level in self.confidences.tolist()])
        peak = each.max(axis=(0, 2))
        return np.exp(each - peak[:, None]).reshape(len(each), -1), peak

    def draw(self, values: Floats, theta: Ints, generator: np.random.Generator) -> Floats:
        """Slices on M unit-rate gammas whose proportions are the shares.

        Their total is free of the data: drawn from its own law, it makes them independent beforehand.
        """
        told, rows = serving(self.likelihood, theta)
        parts = np.stack([told.log_density(level)[rows] for level in self.confidences.tolist()])
        parts = np.exp(parts - parts.max(axis=0, initial=-np.inf))
        weight = _weight(self.likelihood)[rows]
        size = values * generator.standard_gamma(len(values))
        for m in range(len(size)):
            rest, others = size @ parts - size[m] * parts[m], float(size.sum() - size[m])

            def log_density(x: float, part: Floats = parts[m], rest: Floats = rest, others: float = others) -> float:
                fit = float(weight @ np.log(np.maximum(rest, 0) + x * part))
                return fit - float(weight.sum()) * math.log(others + x) - x

            size[m] = draw_positive(log_density, max(float(size[m]), SMALLEST), generator)
        return np.asarray(size / size.sum())

    def summary(self, values: Floats) -> Floats:
        """Mean log confidence under the shares."""
        return np.asarray(values @ np.log(self.confidences))

    def log_density(self, values: Floats) -> float:
        """Log prior density, the same everywhere on the simplex."""
        return float(gammaln(len(values)))


def draw_positive(
    log_density: Callable[[float], float], x: float, generator: np.random.Generator, unit: float = 1.0
) -> float:
    """A slice on log x, for x between 1e-6 and 1e8 units."""
    low, high = math.log(SMALLEST * unit), math.log(LARGEST * unit)

    def in_logs(log_x: float) -> float:
        if not low <= log_x <= high:
            return -math.inf
        return log_density(math.exp(log_x)) + log_x

    return math.exp(slice_draw(in_logs, math.log(x), WIDTH, generator))


def serving(likelihood: LogLikelihood, theta: Ints) -> tuple[Assigned, Ints]:
    """The observations with their candidates, and which of them serve one (not the background)."""
    none = likelihood.candidates.n_candidates
    theta = np.asarray(theta)
    return likelihood.source.assigned(np.where(theta < none, theta, 0)), np.flatnonzero(theta < none)


def _weight(likelihood: LogLikelihood) -> Floats:
    return np.ones(likelihood.n_observations) if likelihood.weight is None else np.asarray(likelihood.weight)
