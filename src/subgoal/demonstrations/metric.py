"""Distance between places: per-dimension weights and angles that wrap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from subgoal.runtime.checks import Floats, frozen, real_array
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False)
class Metric:
    """Weighted Euclidean distance with periodic dimensions.

    Attributes
    ----------
    weights:
        (d,) multipliers of each dimension before the norm is taken (1/units to make mixed units comparable;
        for an angle, a length per radian). All above zero.
    period:
        (d,) length after which a dimension wraps (2π for radians), infinity where it does not.
    """

    weights: Floats
    period: Floats

    def __post_init__(self) -> None:
        weights = real_array("weights", self.weights, ndim=1)
        period = real_array("period", self.period, ndim=1, finite=False)
        if weights.shape != period.shape:
            raise InputError("period", found=f"shape {period.shape}", wanted=f"shape {weights.shape}, as weights")
        for what, values in (("weights", weights), ("period", period)):
            bad = ~(values > 0)
            if bad.any():
                k = int(np.argmax(bad))
                raise InputError(what, where=f"dimension {k}", found=values[k], wanted="a number above 0")
        object.__setattr__(self, "weights", weights)
        object.__setattr__(self, "period", period)

    @classmethod
    def euclidean(cls, dimension: int) -> Metric:
        """The plain distance in ``dimension`` dimensions."""
        return cls(np.ones(dimension), np.full(dimension, np.inf))

    @classmethod
    def of(
        cls, dimension: int, weights: Sequence[float] | None = None, period: Sequence[float] | None = None
    ) -> Metric:
        """Weights and periods given or left plain; shapes checked against ``dimension``."""
        for what, values in (("weights", weights), ("period", period)):
            if values is not None and np.size(values) != dimension:
                raise InputError(what, found=f"{np.size(values)} numbers", wanted=f"{dimension}, one per dimension")
        return cls(
            np.ones(dimension) if weights is None else np.asarray(weights, float),
            np.full(dimension, np.inf) if period is None else np.asarray(period, float),
        )

    @property
    def dimension(self) -> int:
        """Number of dimensions d."""
        return int(self.weights.size)

    def difference(self, origin: Floats, target: Floats) -> Floats:
        """Weighted shortest difference ``target − origin``, broadcast over leading axes, shape (..., d)."""
        raw = np.asarray(target, float) - np.asarray(origin, float)
        wraps = np.isfinite(self.period)
        if wraps.any():
            p = self.period[wraps]
            raw = np.array(raw)
            raw[..., wraps] -= p * np.round(raw[..., wraps] / p)
        return frozen(raw * self.weights)

    def distance(self, origin: Floats, target: Floats) -> Floats:
        """Length of ``difference``, shape (...)."""
        return np.asarray(np.linalg.norm(self.difference(origin, target), axis=-1))
