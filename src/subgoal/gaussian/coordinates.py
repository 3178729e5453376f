"""Coordinates in which the metric is the plain distance, so that a squared exponential of it is a covariance."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.runtime.checks import Floats, real_array
from subgoal.runtime.errors import InputError


def coordinates(metric: Metric, states: Floats) -> Floats:
    """(..., e) the states (..., d), each dimension times its weight, angles laid on a circle.

    A dimension of period p and weight w becomes two, on a circle of circumference p·w: nearby, distances along the
    chord and along the arc agree, and unlike the latter the former gives covariances. Where nothing wraps, e = d and
    distances are those of the metric. Raises ``InputError`` for states of another number of dimensions.
    """
    states = np.asarray(states, float)
    if states.shape[-1:] != (metric.dimension,):
        raise InputError("states", found=f"shape {states.shape}", wanted=f"{metric.dimension} columns, as the metric")
    wraps = np.isfinite(metric.period)
    if not wraps.any():
        return np.asarray(states * metric.weights)
    radius = metric.period[wraps] * metric.weights[wraps] / (2 * np.pi)
    angle = 2 * np.pi * states[..., wraps] / metric.period[wraps]
    flat = states[..., ~wraps] * metric.weights[~wraps]
    return np.concatenate([flat, radius * np.cos(angle), radius * np.sin(angle)], axis=-1)


def spread_metric(states: Floats, *, floor: Floats | None = None, period: Floats | None = None) -> Metric:
    """The metric whose unit in each dimension is the standard deviation of the states (N, d), ``floor`` (d,) at least.

    The floor is a difference that matters: without it a dimension that only carries noise is blown up. Angles have the
    spread about their mean direction. Raises ``InputError`` for a dimension that never changes and has no floor.
    """
    states = real_array("states", states, ndim=2)
    d = states.shape[1]
    plain = Metric.of(d, None, None if period is None else tuple(np.asarray(period, float)))
    least = np.zeros(d) if floor is None else real_array("floor", floor, ndim=1)
    if least.shape != (d,) or not (least >= 0).all():
        raise InputError("floor", found=least, wanted=f"{d} numbers of at least 0, one per dimension")
    spread = np.maximum(np.sqrt(np.mean(plain.difference(_centre(states, plain.period), states) ** 2, axis=0)), least)
    still = ~(spread > 1e-12 * (1 + np.abs(states).max(axis=0)))
    if still.any():
        k = int(np.argmax(still))
        raise InputError(
            "states", where=f"dimension {k}", found=f"{states[0, k]:g} throughout", wanted="a dimension that changes",
            hint="leave it out, or say how large a difference in it matters (floor)",
        )  # fmt: skip
    return Metric(1 / spread, plain.period)


def _centre(states: Floats, period: Floats) -> Floats:
    """(d,) the mean, or the mean direction."""
    centre = states.mean(axis=0)
    for k in np.flatnonzero(np.isfinite(period)):
        turn = np.exp(2j * np.pi * states[:, k] / period[k]).mean()
        centre[k] = np.angle(turn) * period[k] / (2 * np.pi)
    return np.asarray(centre)
