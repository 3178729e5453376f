"""Discrete worlds: tabular decision processes, grid worlds, and planning in them."""

from subgoal.mdp.grids.cells import to_cells
from subgoal.mdp.grids.features import FeatureGroups, feature_groups, manhattan, one_hot
from subgoal.mdp.grids.grid import ROOM_SLIP, THESIS_SLIP, GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.grids.layouts import random_walls
from subgoal.mdp.grids.maps import TextMap, print_map, read_map, read_maps
from subgoal.mdp.grids.occupancy import Occupancy
from subgoal.mdp.grids.rooms import RoomWorld, room_world
from subgoal.mdp.implicit import ImplicitMDP
from subgoal.mdp.local_world import LocalWorld, NumberedWorld, TableWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.horizon import discount_for, flat_distance
from subgoal.mdp.planners.iteration import (
    Plan,
    action_values,
    arrival_reward,
    linear_program,
    modified_policy_iteration,
    policy_evaluation,
    policy_iteration,
    value_iteration,
)
from subgoal.mdp.planners.outcome import PlanningWarning, PlanStatus
from subgoal.mdp.planners.policy import greedy_actions, imperfect, uniform_policy
from subgoal.mdp.planners.rtdp import rtdp_subgoals
from subgoal.mdp.planners.rtdp_literal import rtdp_literal
from subgoal.mdp.planners.rtdp_reward import rtdp_reward
from subgoal.mdp.planners.subgoal_plan import SubgoalPlan
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP

__all__ = [
    "FeatureGroups",
    "GridWorld",
    "ImplicitGrid",
    "ImplicitMDP",
    "LocalWorld",
    "NumberedWorld",
    "Occupancy",
    "Plan",
    "PlanStatus",
    "PlanningWarning",
    "ROOM_SLIP",
    "RoomWorld",
    "SubgoalPlan",
    "THESIS_SLIP",
    "TableWorld",
    "TabularMDP",
    "TextMap",
    "action_values",
    "arrival_reward",
    "discount_for",
    "feature_groups",
    "flat_distance",
    "greedy_actions",
    "imperfect",
    "linear_program",
    "manhattan",
    "modified_policy_iteration",
    "one_hot",
    "plan_subgoals",
    "policy_evaluation",
    "policy_iteration",
    "print_map",
    "random_walls",
    "read_map",
    "read_maps",
    "room_world",
    "rtdp_literal",
    "rtdp_reward",
    "rtdp_subgoals",
    "simulate",
    "to_cells",
    "uniform_policy",
    "value_iteration",
]
