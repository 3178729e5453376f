"""What a likelihood table is made from: anything that gives complete log densities for a block of observations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from subgoal.runtime.checks import Floats, Ints


@dataclass(frozen=True, eq=False)
class Levels:
    """A law of noise: an action is of confidence ``confidences[m]`` with probability ``shares[m]``, both (M,)."""

    confidences: Floats
    shares: Floats


Confidence = float | Floats
"""α of all candidates, or one for each, (G,)."""


class Assigned(Protocol):
    """Observations with one candidate each, at any confidence."""

    def some(self, rows: Ints) -> Assigned:
        """Those of some observations."""

    def log_density(self, confidence: Confidence) -> Floats:
        """(N,) log p(a_i | s_i, θ_i), at one α or one for each observation."""

    def score(self, confidence: Confidence) -> Floats:
        """(N, k) derivative of the log density by the action that the candidate asks for; zero where it asks none."""


@dataclass(frozen=True)
class DistanceLaw:
    """Law of the distance r = ‖a − a_CL‖ (in units of the scale) under log density −αr − log Z.

    ``upper`` is where a picture of it may end.
    """

    log_normaliser: float
    cdf: Callable[[Floats], Floats]
    upper: float


class Source(Protocol):
    """Where the numbers come from: anything that can give complete log densities for a block of observations."""

    @property
    def kind(self) -> str:
        """A word for provenance, e.g. "directions"."""

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) observations whose row is the same for every candidate."""

    @property
    def unit(self) -> float:
        """Confidence at which the best and the worst action typically differ by about a nat."""

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """(stop − start, G) values of log p(a_i | s_i, g)."""

    def log_flat(self, start: int, stop: int) -> Floats:
        """(stop − start,) log density of actions that serve no candidate."""

    def assigned(self, theta: Ints) -> Assigned:
        """The observations, each with candidate ``theta`` (N,)."""

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> Floats | None:
        """(stop − start,) values of log Σ_g p_g L_ig without holding the rows; None if there is no shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """(stop − start, G) True where the observation is at the candidate."""

    def distance_law(self, confidence: float) -> DistanceLaw | None:
        """How ‖a − a_CL‖ is distributed if the model is right; None if there is no such distance."""
