"""Which planner plans for the actions of a likelihood: the exact one for small worlds, an envelope for large ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.local_world import LocalWorld, local_world
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.rtdp import rtdp_subgoals
from subgoal.mdp.planners.subgoal_plan import SubgoalPlan
from subgoal.mdp.tabular import TabularMDP

Planner = Callable[..., SubgoalPlan]
"""``planner(world, goals, *, states, convention, tolerance, workers, progress)``, as ``plan_subgoals``."""
SMALL_GRID = 50_000
"""Cells up to which a grid is planned for exactly and as a whole."""


def world_and_planner(world: Any, planner: Planner | None) -> tuple[TabularMDP | LocalWorld, Planner]:
    """The world as the planner wants it, and the planner: the one given, or the one that suits its size."""
    if isinstance(world, GridWorld):
        if planner is None:
            planner = plan_subgoals if world.n_states <= SMALL_GRID else rtdp_subgoals
        return (world.mdp if plans_exactly(planner) else world), planner
    if isinstance(world, TabularMDP):
        return world, planner or plan_subgoals
    return local_world(world), planner or rtdp_subgoals


def plans_exactly(planner: Planner) -> bool:
    """Whether it is ``plan_subgoals``, with settings or without."""
    return (planner.func if isinstance(planner, partial) else planner) is plan_subgoals
