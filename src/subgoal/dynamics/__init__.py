"""Transition functions of continuous states: known ones, and learning one from data."""

from subgoal.dynamics.car import ALL_DRIVE, REAR_DRIVE, Car
from subgoal.dynamics.equilibria import Equilibrium, equilibria_of, manoeuvres, steady_state
from subgoal.dynamics.protocol import Dynamics, check_bounds, checked_dynamics

__all__ = [
    "ALL_DRIVE",
    "Car",
    "Dynamics",
    "Equilibrium",
    "REAR_DRIVE",
    "check_bounds",
    "checked_dynamics",
    "equilibria_of",
    "manoeuvres",
    "steady_state",
]
