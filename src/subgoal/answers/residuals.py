"""Posterior-predictive residuals: how far actions lie from what their subgoals ask, and what the model expects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
    law = None if likelihood is None else likelihood.source.distance_law(likelihood.confidence)
    if likelihood is None or law is None:
        return None
    shares = posterior.shares
    distance, transform = np.zeros(shares.shape[0]), np.zeros(shares.shape[0])
    weight = np.zeros(shares.shape[0])
    for start, tile in likelihood.tiles():
        block = shares[start : start + len(tile)].tocoo()
        i, g = block.coords
        gap = (-tile[i, g] - law.log_normaliser) / likelihood.confidence
        spoken = ~np.asarray(likelihood.source.arrived(start, start + len(tile)))[i, g]
        for total, values in ((distance, gap), (transform, law.cdf(gap)), (weight, np.ones(gap.size))):
            np.add.at(total, start + i[spoken], (block.data * values)[spoken])
    rows = np.flatnonzero((weight > 0.5) & ~np.asarray(posterior.uninformative))
    edges = np.linspace(0, law.upper, bins + 1)
    return Residuals(
        distance[rows] / weight[rows], transform[rows] / weight[rows], rows, edges, np.diff(law.cdf(edges))
    )
