"""A smooth path through waypoints: minimum snap (Mellinger and Kumar 2011), by ``minsnap_trajectories``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from subgoal.flight.loops import manoeuvre
from subgoal.flight.placement import Placement, place
from subgoal.flight.polynomials import Limits, Pieces, held, joined
from subgoal.flight.route import Route, route_of
from subgoal.flight.vehicle import FASTEST, GRAVITY, Vehicle, vehicle_named
from subgoal.flight.waypoints import Waypoints
from subgoal.flight.ways import way
from subgoal.runtime.checks import Floats, positive, real_array, whole
from subgoal.runtime.errors import InputError

SMOOTHINGS = ("stop", "through")
MOST_SECONDS = 600.0
MOST_ORDERS = 8
SWING = 0.1
"""Of the moment there is when hovering, what a path without tilts may ask for."""


@dataclass(frozen=True, eq=False, repr=False)
class SmoothPath:
    """Where a vehicle is to be at each time, in metres of the world.

    Attributes
    ----------
    route, placement:
        The places it goes to, and where the demonstration lies in the world.
    pieces:
        Polynomials of degree 7.
    arrivals:
        (K,) seconds at which it comes to each place of the route.
    overshoot:
        Largest distance from the straight lines between neighbouring places (loops left out), in metres.
    """

    route: Route
    placement: Placement
    pieces: Pieces
    arrivals: Floats
    overshoot: float

    def __repr__(self) -> str:
        return f"SmoothPath({len(self.arrivals)} places in {self.duration:.1f} s)"

    @property
    def duration(self) -> float:
        """Seconds."""
        return self.pieces.duration

    def at(self, times: Any, orders: int = 1) -> Floats:
        """(orders, n, 3) positions, velocities, accelerations and so on at ``times`` (n,), held at both ends."""
        clock = real_array("times", times, ndim=(0, 1))
        if whole("orders", orders) > MOST_ORDERS:
            raise InputError("orders", found=orders, wanted=f"at most {MOST_ORDERS}")
        return self.pieces.at(clock, orders)

    def headings(self, times: Floats) -> Floats:
        """(n,) yaw in radians: turned evenly between places, or that of the plane."""
        if self.placement.upright:
            return np.full(len(times), self.placement.heading)
        leaves = self.arrivals + self.route.dwell
        knots = np.stack([self.arrivals, leaves], axis=1).ravel()
        return np.interp(times, knots, np.repeat(self.route.angles, 2))


def smooth(
    waypoints: Waypoints,
    *,
    plane: str | None = None,
    height: float = 1.0,
    scale: float | None = None,
    speed: float = 1.0,
    acceleration: float = 3.0,
    smoothing: str = "stop",
    overshoot: float = 0.1,
    rounds: int = 1,
    vehicle: str = "hummingbird",
    tilt_tolerance: float = 0.3,
    constraints: Mapping[int, Mapping[str, Any]] | None = None,
    most_seconds: float = MOST_SECONDS,
) -> SmoothPath:
    """The path of minimum snap through the waypoints, no faster than ``speed`` and ``acceleration``.

    Parameters
    ----------
    plane:
        Two axes of the world, such as "yz", for two positions; by default their names if these are axes, else "xy".
    height:
        Metres above the origin, of a flight in a horizontal plane. Upright ones are flown where they were shown.
    scale:
        Metres per unit; by default from the unit of the waypoints.
    speed, acceleration:
        Limits in m/s and m/s². A tilted waypoint needs what it needs: there the slowest loop is flown that turns over.
    smoothing:
        "stop": rest at each waypoint, on straight lines between. "through": rest only where it dwells, and at the ends.
        A path of minimum snap swings out at corners; where it comes to lie farther than ``overshoot`` metres from the
        straight lines, points on these are added, and if that does not help it rests at the ends of the line.
    rounds:
        Of waypoints that are cyclic.
    tilt_tolerance:
        Radians within which a tilt is had where a way leans most, and a vehicle level. At the sides of a loop 1.2
        will do.
    constraints:
        For waypoint k (from 0), "velocity" or "acceleration" (3,) in the world, where the path goes through it;
        no larger than the limits.
    most_seconds:
        Longest path that is made.

    Raises
    ------
    InputError
        An option out of range, a limit that the vehicle cannot reach, a tilted waypoint that cannot be flown, or a path
        of more than ``most_seconds``.
    MissingExtraError
        The extra ``flight`` is not installed.
    """
    if not isinstance(waypoints, Waypoints):
        raise InputError("waypoints", found=type(waypoints).__name__, wanted="Waypoints", hint="waypoints(posterior)")
    made = vehicle_named(vehicle)
    pace = _limits(made, speed, acceleration)
    if smoothing not in SMOOTHINGS:
        raise InputError("smoothing", found=repr(smoothing), wanted=" or ".join(map(repr, SMOOTHINGS)))
    bound = positive("overshoot", overshoot)
    placement = place(waypoints, plane, height, scale)
    route = route_of(waypoints, placement, rounds, positive("tilt_tolerance", tilt_tolerance))
    most = positive("most_seconds", most_seconds)
    lengths = np.linalg.norm(np.diff(route.places, axis=0), axis=1)
    untilted = ~(route.tilted[1:] | route.tilted[:-1])
    _check_duration(float(route.dwell.sum() + lengths[untilted].sum() / pace.speed), most)
    pinned = _constraints(constraints, route, pace)
    rests = route.dwell > 0
    rests[[0, -1]] = True
    if smoothing == "stop":
        rests |= ~route.tilted
        rests[[k for k in pinned if not route.tilted[k]]] = False
    path = _assembled(route, placement, made, rests, pace, bound, pinned)
    _check_duration(path.duration, most)
    return path


def _check_duration(seconds: float, most: float) -> None:
    if not seconds <= most:
        raise InputError("most_seconds", found=f"a flight of {seconds:,.0f} s or more", wanted=f"at most {most:,g} s",
                         hint="a higher speed, a smaller scale, shorter dwells, or a larger most_seconds "
                              "(--most-seconds)")  # fmt: skip


def _limits(vehicle: Vehicle, speed: float, acceleration: float) -> Limits:
    speed, acceleration = positive("speed", speed), positive("acceleration", acceleration)
    if speed > FASTEST:
        raise InputError("speed", found=speed, wanted=f"at most {FASTEST:g} m/s, beyond which the model does not hold")
    most = float(np.sqrt(max(vehicle.usable_thrust**2 - GRAVITY**2, 0.0)))
    if acceleration > most:
        raise InputError("acceleration", found=acceleration, wanted=f"at most {most:.1f} m/s² for {vehicle.name}")
    return Limits(speed, acceleration, SWING * vehicle.turning * GRAVITY**2)


def _constraints(
    given: Mapping[int, Mapping[str, Any]] | None, route: Route, pace: Limits
) -> dict[int, dict[str, Floats]]:
    """By place of the route, where the waypoint is neither first nor last."""
    found: dict[int, dict[str, Floats]] = {}
    given = {} if given is None else given
    if not isinstance(given, Mapping) or not all(isinstance(wanted, Mapping) for wanted in given.values()):
        raise InputError("constraints", found=type(given).__name__,
                         wanted="velocities and accelerations by waypoint",
                         hint='{1: {"velocity": [0, 0.2, 0]}}')  # fmt: skip
    for at, wanted in given.items():
        places = [k for k in np.flatnonzero(route.waypoint == at).tolist() if 0 < k < len(route.places) - 1]
        if not places or set(wanted) - {"velocity", "acceleration"}:
            raise InputError("constraints", where=f"waypoint {at}", found=list(wanted),
                             wanted="velocity or acceleration, neither first nor last")  # fmt: skip
        most = {"velocity": pace.speed, "acceleration": pace.acceleration}
        vectors = {name: _vector(name, value, most[name]) for name, value in wanted.items()}
        found |= dict.fromkeys(places, vectors)
    return found


def _vector(what: str, value: Any, most: float) -> Floats:
    """(3,) numbers, together no larger than ``most``."""
    vector = real_array(what, value, ndim=1)
    if vector.shape != (3,):
        raise InputError(what, found=f"shape {vector.shape}", wanted="(3,)")
    if not np.linalg.norm(vector) <= most:
        raise InputError(what, where="constraints", found=f"{np.linalg.norm(vector):.3g}", wanted=f"at most {most:g}",
                         hint=f"a larger limit {'speed' if what == 'velocity' else what}=")  # fmt: skip
    return vector


def _assembled(
    route: Route, placement: Placement, vehicle: Vehicle, rests: Any, pace: Limits, bound: float,
    pinned: dict[int, dict[str, Floats]],
) -> SmoothPath:  # fmt: skip
    """Ways from rest to rest, one after another, with the dwells between them."""
    parts: list[Pieces] = []
    arrivals, clock, widest = np.zeros(len(route.places)), 0.0, 0.0
    ends = np.flatnonzero(rests).tolist()
    for a, b in pairwise(ends):
        if route.dwell[a] > 0:
            parts.append(held(route.places[a], float(route.dwell[a])))
            clock += float(route.dwell[a])
        own = {k - a: pinned[k] for k in range(a + 1, b) if k in pinned}
        if route.tilted[a : b + 1].any():
            if own:
                raise InputError("constraints", where=route.name(a + min(own)), found="a way with tilts", wanted="none")
            part, reached = manoeuvre(route, placement, vehicle, a, b)
        else:
            part, reached, apart = way(route.places[a : b + 1], pace, bound, own)
            widest = max(widest, apart)
        arrivals[a + 1 : b + 1] = clock + reached[1:]
        clock += part.duration
        parts.append(part)
    if route.dwell[-1] > 0:
        parts.append(held(route.places[-1], float(route.dwell[-1])))
    return SmoothPath(route, placement, joined(parts), arrivals, widest)
