"""Ways on which a vehicle turns over: arcs of a circle, flown fast enough that thrust points where it should.

Under a controller of positions the attitude follows from the acceleration: thrust balances weight and acceleration. A
vehicle is inverted only where it accelerates downwards by more than gravity, at the top of a loop of radius R where
v² / R > g. So a turn by Δ between two waypoints is an arc of Δ, and the whole way is flown at the lowest speed at which
thrust points as wanted at every tilted waypoint: near enough to the tilt where the way leans most, more loosely at the
sides of a loop, where thrust has to carry the weight too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.flight.placement import Placement
from subgoal.flight.polynomials import Pieces, minimum_snap
from subgoal.flight.route import Route
from subgoal.flight.vehicle import GRAVITY, RESERVE, WEIGHT, Vehicle
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError

PART = np.pi / 8
"""Radians of an arc between points that the path goes through."""
MOST_TURN = 1.6 * np.pi
AIM = 2 / 3
"""Of the tolerance of a tilt, what the path may use up: the rest is for the controller."""
LEAST = GRAVITY
"""Thrust over mass that is left at a tilted waypoint, m/s²."""
TRIED = np.geomspace(0.05, 10.0, 200)
LOOKED_AT = 200
"""Moments of a way at which thrust is looked at."""
WIDER = np.linspace(0, 1, 6)
"""Of the way from a loop as narrow as the demonstrated one to a circle, what is tried."""
RAMPS = (0.5, 0.45, 0.4)
"""Of the time, what goes by before the vehicle is at full speed."""


@dataclass(frozen=True)
class Pace:
    """A speed of a way, with what it asks for.

    Attributes
    ----------
    factor:
        Ways a second.
    thrust, turning:
        Largest thrust over mass, and largest share of the moment that the vehicle has at its thrust.
    aside, place:
        Angle between thrust and what a tilted waypoint wants, and the place of the route where that is worst.
    missed:
        The same as a share of what the path may point aside there.
    """

    factor: float
    thrust: float
    turning: float
    aside: float
    missed: float
    place: int

    def unfit(self, vehicle: Vehicle) -> float:
        """How far this is beyond what the vehicle can: 0 if it can."""
        over = max(self.thrust / vehicle.usable_thrust, self.turning / RESERVE, self.missed)
        return max(over - 1, 0.0)


def manoeuvre(route: Route, placement: Placement, vehicle: Vehicle, first: int, last: int) -> tuple[Pieces, Floats]:
    """The way from place ``first`` to ``last``, from rest to rest, and when it comes to each place.

    Of loops at least as wide as the demonstrated one the narrowest that can be flown, and of several laws of speed the
    one that asks for the least thrust. Raises ``InputError`` where thrust cannot be made to point as wanted, naming the
    waypoint.
    """
    narrow = route.roundness[first + 1 : last + 1]
    for wider in WIDER if (narrow < 1).any() else (1.0,):
        points, at = _points(route, placement, first, narrow + wider * (1 - narrow))
        lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        tried = []
        for ramp in RAMPS:
            times = _eased(lengths / lengths[-1], ramp)
            path = minimum_snap(points, times)
            tried.append((_pace(path, times[at], route, placement, vehicle, first), path, times[at]))
        pace, path, reached = min(tried, key=lambda each: (each[0].unfit(vehicle), each[0].thrust))
        if pace.unfit(vehicle) == 0:
            return path.stretched(1 / pace.factor), reached / pace.factor
    raise _refused(pace, route, vehicle)


def _points(route: Route, placement: Placement, first: int, roundness: Floats) -> tuple[Floats, list[int]]:
    """Points along the arcs, and which of them are the places of the route."""
    parts, at = [route.places[first : first + 1]], [0]
    for k, rounded in enumerate(roundness.tolist(), first):
        turn = float(route.angles[k + 1] - route.angles[k])
        if not abs(turn) <= MOST_TURN:
            raise InputError("waypoints", where=route.name(k + 1), found=f"a turn by {np.degrees(turn):.0f}°",
                             wanted=f"at most {np.degrees(MOST_TURN):.0f}°, a waypoint in between")  # fmt: skip
        count = max(1, int(np.ceil(abs(turn) / PART - 1e-9)))
        share = np.arange(1, count + 1) / count
        parts.append(_arc(route.places[k], route.places[k + 1], turn, share, rounded, placement))
        at.append(at[-1] + count)
    return np.vstack(parts), at


def _arc(begin: Floats, end: Floats, turn: float, share: Floats, rounded: float, placement: Placement) -> Floats:
    """(n, 3) points at ``share`` (n,) of an arc of ``turn`` radians that is ``rounded`` times as wide as a circle's."""
    if abs(turn) < 1e-9:
        return np.asarray(begin + share[:, None] * (end - begin))
    across, up = placement.axes
    chord = complex(end[across] - begin[across], end[up] - begin[up])
    arc = (np.exp(1j * turn * share) - 1) / (np.exp(1j * turn) - 1)
    moved = chord * (arc.real + 1j * rounded * arc.imag)
    made = np.tile(begin, (share.size, 1))
    made[:, across] += moved.real
    made[:, up] += moved.imag
    return made


def _eased(share: Floats, ramp: float) -> Floats:
    """Times from 0 to 1 at which the vehicle has gone each share of the way.

    Its speed rises by 10t³ − 15t⁴ + 6t⁵ over the first ``ramp`` of the time, is even, and falls likewise.
    """
    clock = np.linspace(0, 1, 2001)
    edge = np.clip(np.minimum(clock, 1 - clock) / ramp, 0, 1)
    speed = edge**3 * (10 - 15 * edge + 6 * edge**2)
    gone = np.append(0.0, np.cumsum(speed[1:] + speed[:-1]))
    return np.interp(share, gone / gone[-1], clock)


def _pace(path: Pieces, reached: Floats, route: Route, placement: Placement, vehicle: Vehicle, first: int) -> Pace:
    """The lowest of the speeds tried that the vehicle can fly with its thrust as wanted, else the one that comes
    nearest.
    """
    tilted = [k for k in range(len(reached)) if route.tilted[first + k]]
    square = (TRIED**2)[:, None, None]
    clock = np.linspace(0, path.duration, LOOKED_AT)
    thrust = square * path.at(clock, 3)[2] + WEIGHT
    size = np.linalg.norm(thrust, axis=2)
    turned = np.unwrap(placement.tilts(thrust), axis=1)
    bend = np.abs(np.diff(turned, 2, axis=1)) * (TRIED[:, None] / clock[1]) ** 2
    turning = (bend / (vehicle.turning * np.maximum(size[:, 1:-1], 1e-9))).max(axis=1)
    there = square * path.at(reached[tilted], 3)[2] + WEIGHT
    wanted = placement.direction(route.angles[first + np.array(tilted)])
    along = (there * wanted).sum(axis=2) / np.maximum(np.linalg.norm(there, axis=2), 1e-9)
    aside = np.where(np.linalg.norm(there, axis=2) < LEAST, np.pi, np.arccos(np.clip(along, -1, 1)))
    missed = aside / (AIM * route.tilt_tolerance[first + np.array(tilted)])
    worst = np.argmax(missed, axis=1)
    paces = [
        Pace(float(TRIED[k]), float(size[k].max()), float(turning[k]), float(aside[k, worst[k]]),
             float(missed[k, worst[k]]), first + tilted[worst[k]])
        for k in range(TRIED.size)
    ]  # fmt: skip
    return min(paces, key=lambda pace: pace.unfit(vehicle))


def _refused(pace: Pace, route: Route, vehicle: Vehicle) -> InputError:
    tilt = np.degrees(np.arccos(np.cos(route.angles[pace.place])))
    return InputError(
        "waypoints", where=route.name(pace.place),
        found=f"a tilt of {tilt:.0f}° that {vehicle.name} cannot have there: at best thrust points "
              f"{np.degrees(pace.aside):.0f}° aside, with {pace.thrust / vehicle.usable_thrust:.0%} of the thrust "
              f"and {pace.turning / RESERVE:.0%} of the moment there are",
        wanted="at most 100% of both, on a loop where the angle turns as the path bends",
        hint="a larger tilt_tolerance= (--tilt-tolerance), fewer waypoints (a larger least_share=, --least-share), or "
             "angles of the other sign",
    )  # fmt: skip
