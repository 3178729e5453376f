"""Transition functions of continuous states: known ones, and learning one from data."""

from subgoal.dynamics.car import ALL_DRIVE, REAR_DRIVE, Car
from subgoal.dynamics.protocol import Dynamics, check_bounds, checked_dynamics

__all__ = ["ALL_DRIVE", "Car", "Dynamics", "REAR_DRIVE", "check_bounds", "checked_dynamics"]
