"""Ways on which a vehicle turns over: arcs of a circle, flown fast enough that thrust points where it should.

Under a controller of positions the attitude follows from the acceleration: thrust balances weight and acceleration. A
vehicle is inverted only where it accelerates downwards by more than gravity, at the top of a loop of radius R where
v² / R > g. So a turn by Δ between two waypoints is an arc of Δ, and the whole way is flown at the lowest speed at which
thrust points as wanted at every tilted waypoint.
"""

from __future__ import annotations

import numpy as np

from subgoal.flight.placement import Placement
from subgoal.flight.polynomials import Pieces, minimum_snap
from subgoal.flight.route import Route
from subgoal.flight.vehicle import GRAVITY, WEIGHT, Vehicle
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError

PART = np.pi / 4
"""Radians of an arc between points that the path goes through."""
MOST_TURN = 1.6 * np.pi
AIM = 0.15
"""Radians by which thrust may point aside at a tilted waypoint, in the path."""
LEAST = 0.5 * GRAVITY
"""Thrust over mass that is left at a tilted waypoint, m/s²."""
TRIED = np.geomspace(0.05, 20.0, 600)


def manoeuvre(route: Route, placement: Placement, vehicle: Vehicle, first: int, last: int) -> tuple[Pieces, Floats]:
    """The way from place ``first`` to ``last``, from rest to rest, and when it comes to each place.

    Raises ``InputError`` where thrust cannot be made to point as wanted, naming the waypoint.
    """
    points, at = _points(route, placement, first, last)
    lengths = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
    times = _eased(lengths / lengths[-1])
    path = minimum_snap(points, times)
    factor = _pace(path, times[at], route, placement, vehicle, first)
    return path.stretched(1 / factor), times[at] / factor


def _points(route: Route, placement: Placement, first: int, last: int) -> tuple[Floats, list[int]]:
    """Points along the arcs, and which of them are the places of the route."""
    parts, at = [route.places[first : first + 1]], [0]
    for k in range(first, last):
        turn = float(route.angles[k + 1] - route.angles[k])
        if not abs(turn) <= MOST_TURN:
            raise InputError("waypoints", where=route.name(k + 1), found=f"a turn by {np.degrees(turn):.0f}°",
                             wanted=f"at most {np.degrees(MOST_TURN):.0f}°, a waypoint in between")  # fmt: skip
        count = max(1, int(np.ceil(abs(turn) / PART - 1e-9)))
        share = np.arange(1, count + 1) / count
        parts.append(_arc(route.places[k], route.places[k + 1], turn, share, placement))
        at.append(at[-1] + count)
    return np.vstack(parts), at


def _arc(begin: Floats, end: Floats, turn: float, share: Floats, placement: Placement) -> Floats:
    """(n, 3) points on the arc of ``turn`` radians at ``share`` (n,) of it, in the plane of flight."""
    if abs(turn) < 1e-9:
        return np.asarray(begin + share[:, None] * (end - begin))
    across, up = placement.axes
    chord = complex(end[across] - begin[across], end[up] - begin[up])
    moved = chord * (np.exp(1j * turn * share) - 1) / (np.exp(1j * turn) - 1)
    made = np.tile(begin, (share.size, 1))
    made[:, across] += moved.real
    made[:, up] += moved.imag
    return made


def _eased(share: Floats) -> Floats:
    """Times from 0 to 1 at which 35t⁴ − 84t⁵ + 70t⁶ − 20t⁷, which begins and ends at rest, comes to each share."""
    clock = np.linspace(0, 1, 2001)
    law = clock**4 * (35 - 84 * clock + 70 * clock**2 - 20 * clock**3)
    return np.interp(share, law, clock)


def _pace(path: Pieces, reached: Floats, route: Route, placement: Placement, vehicle: Vehicle, first: int) -> float:
    """The lowest of the speeds tried at which every tilted waypoint has its thrust."""
    tilted = [k for k in range(len(reached)) if route.tilted[first + k]]
    pulls = path.at(reached[tilted], 3)[2]
    wanted = placement.direction(route.angles[first + np.array(tilted)])
    square = (TRIED**2)[:, None, None]
    hardest = np.linalg.norm(square * path.at(path.samples(), 3)[2] + WEIGHT, axis=2).max(axis=1)
    thrust = square * pulls + WEIGHT
    size = np.linalg.norm(thrust, axis=2)
    aside = np.arccos(np.clip((thrust * wanted).sum(axis=2) / np.maximum(size, 1e-12), -1, 1))
    there = (aside <= AIM) & (size >= LEAST)
    fits = there.all(axis=1)
    flown = fits & (hardest <= vehicle.usable_thrust)
    if flown.any():
        return float(TRIED[np.argmax(flown)])
    best = int(np.argmin(aside.max(axis=1)))
    k = int(np.argmax(aside[best])) if not fits.any() else 0
    angle = np.degrees(np.arccos(np.cos(route.angles[first + tilted[k]])))
    found = (
        f"a loop that needs {hardest[fits].min():.0f} m/s² of thrust to tilt by {angle:.0f}°" if fits.any()
        else f"a tilt of {angle:.0f}° from which thrust stays {np.degrees(aside[best, k]):.0f}° aside at any speed"
    )  # fmt: skip
    raise InputError("waypoints", where=route.name(first + tilted[k]), found=found,
                     wanted=f"at most {vehicle.usable_thrust:.0f} m/s² ({vehicle.name}), and an arc that turns "
                            "the way the angle does")  # fmt: skip
