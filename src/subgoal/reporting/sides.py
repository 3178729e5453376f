"""The box of a three-dimensional scene: equal scales where one unit holds for all axes, else each fills its side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats

MARGIN = 0.05
"""Of the extent, left free on either side."""
LEAST_SIDE = 0.05
"""Of the longest side with the same unit; one that is shorter is widened to it."""
LONGEST_SIDE, DIAGONAL = 1.4, 3**0.5
"""Of the box, in the unit of Plotly's camera: all of it is within its view."""


@dataclass(frozen=True, eq=False)
class Sides:
    """What each of three axes shows: from ``low`` (3,) to ``high`` (3,), on a side as long as ``ratio`` (3,) says.

    ``equal`` is whether all have one scale.
    """

    low: Floats
    high: Floats
    ratio: Floats
    equal: bool


def sides_of(posterior: Posterior, points: Floats) -> Sides:
    """The box around ``points`` (M, 3), in the first three dimensions; rows with NaN are no points."""
    alike = _alike(posterior)
    low, high = np.nanmin(points, axis=0), np.nanmax(points, axis=0)
    extent = high - low
    longest = np.where(alike, extent[alike].max(initial=0.0), extent)
    longest[~(longest > 0)] = 1.0
    side = np.maximum(extent * (1 + 2 * MARGIN), LEAST_SIDE * longest)
    ratio = np.where(alike, side / np.where(alike, side, 0.0).max(), 1.0)
    ratio *= min(DIAGONAL / float(np.linalg.norm(ratio)), LONGEST_SIDE / float(ratio.max()))
    middle = low + extent / 2
    return Sides(middle - side / 2, middle + side / 2, ratio, bool(alike.all()))


def _alike(posterior: Posterior) -> Bools:
    """(3,) which dimensions have the unit of lengths: the one that is told, else that of the first in the metric."""
    metric = posterior.candidates.metric
    weights, straight = metric.weights[:3], np.isinf(metric.period[:3])
    same = np.full(3, True) if posterior.demonstrations.units else weights == weights[np.argmax(straight)]
    return np.asarray(straight & same)
