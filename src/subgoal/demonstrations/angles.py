"""Dimensions that wrap: made continuous for interpolation and velocities, then put back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.checks import Floats


def unwrapped(recording: Recording, period: Sequence[float]) -> Recording:
    """The recording with every jump of more than half a period undone, within each trajectory.

    ``period`` (d,) as in ``Metric``: 2π for radians, infinity for a dimension that does not wrap.
    """
    lengths = Metric.of(recording.positions.shape[1], period=period).period
    positions = np.array(recording.positions)
    for k in np.flatnonzero(np.isfinite(lengths)):
        for a, b in pairwise(recording.offset.tolist()):
            positions[a:b, k] = np.unwrap(positions[a:b, k], period=lengths[k])
    return replace(recording, positions=positions)


def wrapped(demonstrations: Demonstrations, period: Sequence[float], recorded: Floats) -> Demonstrations:
    """States and final states put back into one period: from 0 if nothing ``recorded`` was below, else around 0."""
    lengths = Metric.of(recorded.shape[1], period=period).period
    states, final = np.array(demonstrations.states), np.array(demonstrations.final_states)
    for k in np.flatnonzero(np.isfinite(lengths)):
        low = 0.0 if recorded[:, k].min() >= 0 else -lengths[k] / 2
        for places in (states, final):
            places[:, k] -= lengths[k] * np.floor((places[:, k] - low) / lengths[k])
    return replace(demonstrations, states=states, final_states=final)
