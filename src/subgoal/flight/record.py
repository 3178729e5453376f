"""A flight: what the vehicle did, and whether it came to every waypoint."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from subgoal.flight.placement import Placement
from subgoal.flight.route import Route
from subgoal.flight.smooth import SmoothPath
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Bools, Floats


class FlightStatus(Enum):
    """How a flight ended; values are messages."""

    FLOWN = "flown: every waypoint was reached"
    DID_NOT_ARRIVE = "did not arrive at every waypoint: fly slower, or with a larger tolerance"
    DIVERGED = "diverged: the vehicle lost its path, so the flight was ended: fly slower"
    STOPPED = "stopped before the end"


@dataclass(frozen=True, eq=False, repr=False)
class Flight:
    """What a vehicle did.

    Attributes
    ----------
    times:
        (n,) seconds.
    positions, velocities, commanded:
        (n, 3) metres and m/s of the world; ``commanded`` is where the path was.
    quaternions:
        (n, 4) attitudes (x, y, z, w), from the body to the world.
    rotor_speeds, thrust:
        (n, 4) rad/s and (n,) newtons.
    waypoints, path:
        What was flown.
    misses:
        (K,) metres from each place of ``path.route``, at the nearest in half a leg about the time it was due; infinity
        where the flight ended before.
    tilts:
        (K,) radians between the thrust and what a tilted place wants, at that moment; 0 at places that are level.
    tolerance, tilt_tolerance:
        Metres and radians within which a place is reached.
    status:
        FLOWN if all places were reached.
    vehicle, seconds:
        Its name, and the time the simulation took.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    quaternions: Floats
    commanded: Floats
    rotor_speeds: Floats
    thrust: Floats
    waypoints: Waypoints
    path: SmoothPath
    misses: Floats
    tilts: Floats
    tolerance: float
    tilt_tolerance: float
    status: FlightStatus
    vehicle: str
    seconds: float

    def __repr__(self) -> str:
        return f"Flight({self.duration:.1f} s of {self.vehicle}, {self.status.name})"

    @property
    def duration(self) -> float:
        """Seconds flown."""
        return float(self.times[-1])

    @property
    def placement(self) -> Placement:
        """Where the demonstration lies in the world."""
        return self.path.placement

    @property
    def route(self) -> Route:
        """The places flown to."""
        return self.path.route

    @property
    def reached(self) -> Bools:
        """(K,) which places of the route were reached."""
        return np.asarray((self.misses <= self.tolerance) & (self.tilts <= self.tilt_tolerance))

    @property
    def shown(self) -> Floats:
        """(n, k) positions in the coordinates and units of the demonstration."""
        return self.placement.from_world(self.positions)

    @property
    def angles(self) -> NDArray[np.float64]:
        """(n,) continuous tilt in a vertical plane, else heading, radians."""
        return self.placement.angles(self.quaternions)
