"""Planning for goals in a continuous world, with actions that are refined between the test actions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.refinement import climb
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import Ahead, GoalValues, in_main_memory, plan_goals, rewards
from subgoal.gaussian.smoothers import Smoother
from subgoal.gaussian.value_iteration import Further
from subgoal.runtime.checks import Floats, whole
from subgoal.runtime.progress import Progress


def plan_world(
    world: ContinuousWorld,
    metric: Metric,
    support: Floats,
    goals: Floats,
    *,
    smoother: Smoother,
    width: float,
    refinements: int = 0,
    tolerance: float,
    most_sweeps: int,
    place: Callable[[Floats], Any] = np.asarray,
    progress: Progress | None = None,
) -> GoalValues:
    """Values of goals (G, d) at support states (n, d) of a world, in main memory.

    With ``refinements`` the best action of each support state for each goal is refined so many times among its
    neighbours at half the spacing, and planning goes on with it beside the test actions. Other arguments as in
    ``plan_goals`` and ``gp_actions``.
    """
    ahead = world.ahead_of_tests(support, metric)
    where = place(coordinates(metric, support)), place(coordinates(metric, goals)), ahead.on(place)
    how: dict[str, Any] = {
        "smoother": smoother, "width": width, "discount": world.discount, "tolerance": tolerance,
        "most_sweeps": most_sweeps, "progress": progress,
    }  # fmt: skip
    plan = plan_goals(*where, **how)
    if not whole("refinements", refinements, least=0):
        return in_main_memory(plan)
    found = in_main_memory(plan)
    actions = np.stack([_refined(found, g, world, metric, support, refinements) for g in range(len(goals))], axis=1)
    n, count = actions.shape[:2]
    after = world.ahead(np.repeat(support, count, axis=0), actions.reshape(n * count, -1), metric)
    further = Further(*(place(each) for each in _own(found, after, n, count)))
    return in_main_memory(plan_goals(*where, **how, start=plan.values, further=further))


def _refined(plan: GoalValues, g: int, world: ContinuousWorld, metric: Metric, support: Floats, rounds: int) -> Floats:
    """(n, k) the refined action of each support state for one goal."""
    one = plan.only([g])

    def worth_of(tried: Floats) -> Floats:
        n, m, k = tried.shape
        return np.asarray(
            one.action_values(world.ahead(np.repeat(support, m, axis=0), tried.reshape(-1, k), metric))
        ).reshape(n, m)

    return climb(world, world.test_actions[np.asarray(plan.best)[:, g]][:, None], worth_of, rounds)[0]


def _own(plan: GoalValues, after: Ahead, n: int, count: int) -> tuple[Floats, Floats]:
    """(n, G) rewards and (n, G, n) weights of an action for each support state and goal."""
    weights = np.asarray(plan.smoother.weights(plan.support, after.points[-1], after.variance))
    reward = np.empty((n, count))
    for g in range(count):
        rows = slice(g, None, count)
        reward[:, g] = (1 - plan.discount) * np.asarray(rewards(after.some(rows), plan.goals[g : g + 1], plan.width))[
            :, 0
        ]
    return reward, weights.reshape(n, count, n)
