"""From subgoals to flight: waypoints, a smooth path through them, a simulated quadrotor, and how well it followed."""

from subgoal.flight.files import read_waypoints, write_waypoints
from subgoal.flight.fly import fly
from subgoal.flight.output import write_flight
from subgoal.flight.record import Flight, FlightStatus
from subgoal.flight.smooth import SmoothPath, smooth
from subgoal.flight.tracking import Tracking, tracking
from subgoal.flight.waypoints import Waypoints, waypoints

__all__ = [
    "Flight", "FlightStatus", "SmoothPath", "Tracking", "Waypoints", "fly", "read_waypoints", "smooth", "tracking",
    "waypoints", "write_flight", "write_waypoints",
]  # fmt: skip
