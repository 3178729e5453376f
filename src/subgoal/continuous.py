"""Continuous worlds (thesis chapter 6): dynamics, planning by Gaussian processes, and their likelihood."""

from subgoal.demonstrations.held import held_rows, hold_actions
from subgoal.dynamics.world import ContinuousWorld, action_grid
from subgoal.gaussian.coordinates import spread_metric
from subgoal.gaussian.smoothers import Averager, GaussianSmoother
from subgoal.irl.confidence_sweep import confidence_sweep
from subgoal.irl.expertise import compare_expertise, expertise
from subgoal.irl.second_subgoal import second_subgoal
from subgoal.likelihood.gp_actions import gp_actions

__all__ = [
    "Averager",
    "ContinuousWorld",
    "GaussianSmoother",
    "action_grid",
    "compare_expertise",
    "confidence_sweep",
    "expertise",
    "gp_actions",
    "held_rows",
    "hold_actions",
    "second_subgoal",
    "spread_metric",
]
