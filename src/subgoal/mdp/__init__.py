"""Discrete worlds: tabular decision processes, grid worlds, and planning in them."""

from subgoal.mdp.grids.cells import to_cells
from subgoal.mdp.grids.features import FeatureGroups, feature_groups, manhattan, one_hot
from subgoal.mdp.grids.grid import ROOM_SLIP, THESIS_SLIP, GridWorld
from subgoal.mdp.grids.layouts import random_walls
from subgoal.mdp.grids.maps import TextMap, print_map, read_map, read_maps
from subgoal.mdp.grids.occupancy import Occupancy
from subgoal.mdp.grids.rooms import RoomWorld, room_world
from subgoal.mdp.implicit import ImplicitMDP
from subgoal.mdp.planners.first_passage import plan_subgoals
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
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.policy import greedy_actions, imperfect, uniform_policy
from subgoal.mdp.planners.subgoal_plan import SubgoalPlan
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP

__all__ = [
    "FeatureGroups",
    "GridWorld",
    "ImplicitMDP",
    "Occupancy",
    "Plan",
    "PlanStatus",
    "ROOM_SLIP",
    "RoomWorld",
    "SubgoalPlan",
    "THESIS_SLIP",
    "TabularMDP",
    "TextMap",
    "action_values",
    "arrival_reward",
    "feature_groups",
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
    "simulate",
    "to_cells",
    "uniform_policy",
    "value_iteration",
]
