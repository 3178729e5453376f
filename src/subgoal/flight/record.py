"""A flight: what the vehicle did, and whether it came to every waypoint."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from subgoal.flight.placement import Placement
from subgoal.flight.route import Route
from subgoal.flight.smooth import SmoothPath
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Bools, Floats, frozen

SHORT = 0.05
"""Metres between waypoints below which a vehicle, followed to a few millimetres, tells them apart badly."""
LOUD = 1 / 3
"""Of the tolerance, what noise of the positions makes a vehicle miss."""


class FlightStatus(Enum):
    """How a flight ended; values are messages, to which ``Flight.told`` adds what to try."""

    FLOWN = "flown: every waypoint was reached"
    DID_NOT_ARRIVE = "did not arrive at every waypoint"
    DIVERGED = "diverged: the vehicle lost its path, so the flight was ended"
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
        Metres and radians within which a place is reached; at the sides of a loop ``route.tilt_tolerance`` is more.
    status:
        FLOWN if all places were reached.
    noise:
        Metres by which the controller was told wrong positions (RMS).
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
    noise: float
    vehicle: str
    seconds: float

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, each.name, frozen(value))

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
        return np.asarray((self.misses <= self.tolerance) & (self.tilts <= self.route.tilt_tolerance))

    @property
    def told(self) -> str:
        """How the flight ended, within what, and what to try."""
        least, ended = self.route.least_leg, str(self.status.value)
        if self.status is FlightStatus.STOPPED:
            return ended
        if self.status is FlightStatus.FLOWN:
            near = f" within {self.tolerance:.3g} m"
            if 2 * self.tolerance > least:
                near += f", which says little: the nearest two are {least:.2g} m apart; try a smaller tolerance"
            return ended + near
        if self.noise > LOUD * self.tolerance:
            return f"{ended}: try less noise than {self.noise:.3g} m"
        if least < SHORT:
            return f"{ended}: the nearest two are {least:.2g} m apart; try a larger scale"
        if self.status is FlightStatus.DID_NOT_ARRIVE and (self.misses <= self.tolerance).all():
            return f"{ended} with its tilt: try a larger tilt_tolerance (--tilt-tolerance)"
        larger = ", or a larger tolerance" if self.status is FlightStatus.DID_NOT_ARRIVE else ""
        return f"{ended}: try a lower speed{larger}"

    @property
    def shown(self) -> Floats:
        """(n, k) positions in the coordinates and units of the demonstration."""
        return self.placement.from_world(self.positions)

    @property
    def angles(self) -> NDArray[np.float64]:
        """(n,) continuous tilt in a vertical plane, else heading, radians."""
        return self.placement.angles(self.quaternions)
