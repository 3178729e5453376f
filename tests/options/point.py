"""A point that moves in the plane at the velocity it is told, shown going to one corner, then to another."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

import subgoal
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.world import ContinuousWorld, action_grid
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import plan_goals
from subgoal.gaussian.smoothers import GaussianSmoother
from subgoal.options.continuous import ContinuousOption
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats

STEP, SPEED = 0.2, 2.0
CORNERS = np.array([[3.0, 0.0], [3.0, 3.0]])


def glide(states: Floats, actions: Floats, duration: float) -> Floats:
    """Velocity is the action."""
    return np.asarray(states + actions * duration)


def point_world(dynamics: Any = glide, **settings: Any) -> ContinuousWorld:
    """Velocities of ±2 along each of two axes, chosen every 0.2."""
    return ContinuousWorld(dynamics, [-SPEED] * 2, [SPEED] * 2, STEP, **settings)


@cache
def shown() -> Demonstrations:
    """From the origin to (3, 0), a while there, to (3, 3), a while there; somewhat noisy."""
    generator = np.random.default_rng(0)
    at, states, actions = np.zeros(2), [], []
    for corner in CORNERS:
        for _ in range(25):
            wanted = (corner - at) / STEP
            wanted *= min(1.0, 1.5 / max(np.linalg.norm(wanted), 1e-12))
            action = np.clip(wanted + 0.1 * generator.standard_normal(2), -SPEED, SPEED)
            states.append(at)
            actions.append(action)
            at = at + action * STEP
    return Demonstrations(
        np.array(states), np.array(actions), np.array([0, len(states)]), times=STEP * np.arange(len(states)),
        final_states=at[None], truncated=[True], names=("x", "y"),
    )  # fmt: skip


@cache
def learned() -> Posterior:
    """Two subgoals, one after the other."""
    return subgoal.gpsrl(
        shown(), point_world(), metric=Metric.euclidean(2), chains=2, draws=60, warmup=40, thin=1, seed=0
    )


@cache
def goals() -> tuple[int, int]:
    """Candidates that serve most of the pairs, in the order of the corners."""
    used, counts = np.unique(learned().best_assignment, return_counts=True)
    largest = used[np.argsort(-counts)[:2]]
    first = int(largest[np.argmin(learned().candidates.points[largest][:, 1])])
    return first, int(largest[largest != first][0])


def planned(
    goal: Any, dynamics: Any = glide, *, metric: Metric | None = None, support: Any = None, radius: float = 0.3,
    settings: Any = None, **fields: Any,
) -> ContinuousOption:  # fmt: skip
    """An option of any goal, planned on a grid of support states."""
    goal = np.asarray(goal, float)
    metric = metric or Metric.euclidean(goal.size)
    world = ContinuousWorld(dynamics, **settings) if settings else point_world(dynamics)
    base = action_grid([-0.5] * 2, [3.5] * 2, 6) if support is None else np.asarray(support, float)
    values = plan_goals(
        coordinates(metric, base), coordinates(metric, goal[None]), world.ahead_of_tests(base, metric),
        smoother=GaussianSmoother(), width=0.7, discount=world.discount,
    )  # fmt: skip
    return ContinuousOption("a goal", goal, values, world, metric, radius, **fields)
