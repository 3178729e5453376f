"""Closed-loop controllers for action comparison (thesis 5.1.2): vectorised functions (state, goal) -> action.

Any callable of yours serves: it gets states (..., d) and goals (..., d) that broadcast and returns actions (..., k).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.runtime.checks import Floats, positive

Controller = Callable[[Floats, Floats], Floats]


def straight_to_goal(metric: Metric) -> Controller:
    """Controller (5.2): the way to the goal, angles the shorter way round; only its direction matters."""

    def controller(state: Floats, goal: Floats) -> Floats:
        return np.asarray(metric.difference(state, goal) / metric.weights)

    return controller


def proportional(gain: float, speed_limit: float, metric: Metric) -> Controller:
    """Velocity ``gain`` (1/time) times the way to the goal, never faster than ``speed_limit`` (weighted units/time)."""
    gain, speed_limit = positive("gain", gain), positive("speed_limit", speed_limit)

    def controller(state: Floats, goal: Floats) -> Floats:
        way = gain * np.asarray(metric.difference(state, goal))
        speed = np.linalg.norm(way, axis=-1, keepdims=True)
        return np.asarray(way * np.minimum(1.0, speed_limit / np.maximum(speed, speed_limit)) / metric.weights)

    return controller
