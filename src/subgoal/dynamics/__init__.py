"""Transition functions of continuous states: known ones, and learning one from data."""

from subgoal.dynamics.car import ALL_DRIVE, REAR_DRIVE, Car
from subgoal.dynamics.driver import Driven, drive, path, turns
from subgoal.dynamics.equilibria import Equilibrium, equilibria_of, manoeuvres, steady_state
from subgoal.dynamics.gym import continuous_env
from subgoal.dynamics.learned import learn_dynamics
from subgoal.dynamics.learned_dynamics import GaussianDynamics, HeldOut, LearnedDynamics
from subgoal.dynamics.protocol import Dynamics, check_bounds, checked_dynamics
from subgoal.dynamics.scripts import SCRIPT

__all__ = [
    "ALL_DRIVE",
    "Car",
    "Driven",
    "Dynamics",
    "Equilibrium",
    "GaussianDynamics",
    "HeldOut",
    "LearnedDynamics",
    "REAR_DRIVE",
    "SCRIPT",
    "check_bounds",
    "checked_dynamics",
    "continuous_env",
    "drive",
    "equilibria_of",
    "learn_dynamics",
    "manoeuvres",
    "path",
    "steady_state",
    "turns",
]
