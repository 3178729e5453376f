"""Posterior-predictive residuals: how far actions lie from what their subgoals ask, and what the model expects."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal.likelihood.source import DistanceLaw, Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints


@dataclass(frozen=True, eq=False)
class Residuals:
    """Distances ‖a − a_CL‖ and their probability integral transforms under the model.

    Attributes
    ----------
    distance:
        (M,) expected distance of each informative observation over its posterior subgoals, in units of the scale.
    transform:
        (M,) P(distance at most the observed one | O): uniform on (0, 1) if the likelihood is right, low if the
        demonstrator is more precise than the confidence says.
    rows:
        (M,) which observations these are.
    edges, expected:
        (B+1,) bin edges of the distance and (B,) the share of observations that the model expects in each.
    """

    distance: Floats
    transform: Floats
    rows: Ints
    edges: Floats
    expected: Floats


def residuals(posterior: Posterior, *, bins: int = 24) -> Residuals | None:
    """Residuals of the informative observations; None where the likelihood has no distances (a plain table)."""
    likelihood = posterior.likelihood
    law = None if likelihood is None else likelihood.source.distance_law(1.0)
    if likelihood is None or law is None:
        return None
    plain = replace(likelihood, confidence=1.0, weight=None, background=0.0)
    noise = _Noise(likelihood)
    shares = posterior.shares
    distance, transform = np.zeros(shares.shape[0]), np.zeros(shares.shape[0])
    weight = np.zeros(shares.shape[0])
    for start, tile in plain.tiles():
        block = shares[start : start + len(tile)].tocoo()
        i, g = block.coords
        gap = -tile[i, g] - law.log_normaliser
        spoken = ~np.asarray(likelihood.source.arrived(start, start + len(tile)))[i, g]
        below = noise.cdf(gap, g.astype(np.int64))
        for total, values in ((distance, gap), (transform, below), (weight, np.ones(gap.size))):
            np.add.at(total, start + i[spoken], (block.data * values)[spoken])
    rows = np.flatnonzero((weight > 0.5) & ~np.asarray(posterior.uninformative))
    edges = np.linspace(0, noise.upper, bins + 1)
    expected = np.diff(noise.cdf(edges, np.zeros(edges.size, np.int64)))
    return Residuals(distance[rows] / weight[rows], transform[rows] / weight[rows], rows, edges, expected)


class _Noise:
    """Law of the distance for each candidate: of one confidence, of one each, or of levels and their shares."""

    def __init__(self, likelihood: LogLikelihood) -> None:
        noise: Any = likelihood.confidence
        pairs = [(1.0, noise)] if isinstance(noise, float) else []
        if isinstance(noise, Levels):
            pairs = list(zip(noise.shares.tolist(), noise.confidences.tolist(), strict=True))
        elif not pairs:
            pairs = [(1.0, float(np.median(noise)))]
        self.each = None if isinstance(noise, (float, Levels)) else noise
        self.source = likelihood.source
        self.laws = [(share, self._law(alpha)) for share, alpha in pairs]
        self.upper = max(law.upper for _, law in self.laws)

    def _law(self, confidence: float) -> DistanceLaw:
        law = self.source.distance_law(confidence)
        if law is None:
            raise LookupError("a likelihood without distances has no law of them")
        return law

    def cdf(self, distance: Floats, candidate: Ints) -> Floats:
        """P(a distance of at most this) for observations that serve ``candidate``, both (M,)."""
        if self.each is None:
            return np.asarray(sum(share * law.cdf(distance) for share, law in self.laws))
        out = np.empty(distance.size)
        for g in np.unique(candidate).tolist():
            out[candidate == g] = self._law(float(self.each[g])).cdf(distance[candidate == g])
        return out
