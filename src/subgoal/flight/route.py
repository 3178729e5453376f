"""The route of a flight: the places of the world it goes to, one after another, from rest to rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.flight.placement import Placement
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Bools, Floats, Ints, whole
from subgoal.runtime.errors import InputError

START = -1
MOST_PLACES = 10_000
SIDE = 1.2
"""Radians within which a tilt is had at the sides of a loop: weight keeps thrust from pointing to the middle there."""


@dataclass(frozen=True, eq=False)
class Route:
    """Where a flight goes.

    Attributes
    ----------
    places:
        (K, 3) metres of the world.
    waypoint:
        (K,) which waypoint is there, −1 for the start.
    dwell:
        (K,) seconds of rest.
    angles:
        (K,) radians wanted there, continuous along the route: tilts in a vertical plane, else headings; zeros where
        there is no angle.
    roundness:
        (K,) of the way to each place, as in ``Waypoints``.
    tilted:
        (K,) whether the angle is a tilt at which no vehicle can hover, not within the tolerance of level.
    tilt_tolerance:
        (K,) radians within which a tilt is had: what was asked for where a way leans most, more at its sides.
    """

    places: Floats
    waypoint: Ints
    dwell: Floats
    angles: Floats
    roundness: Floats
    tilted: Bools
    tilt_tolerance: Floats

    @property
    def least_leg(self) -> float:
        """Metres between the nearest two neighbours."""
        return float(np.linalg.norm(np.diff(self.places, axis=0), axis=1).min())

    def name(self, k: int) -> str:
        """The place ``k`` in words."""
        at = int(self.waypoint[k])
        return "the start" if at == START else f"waypoint {at + 1}"


def route_of(waypoints: Waypoints, placement: Placement, rounds: int, tolerance: float) -> Route:
    """From the start through all waypoints; ``rounds`` times, if they are cyclic, and back to where it began.

    A tilt of more than ``tolerance`` radians is one; on the way to one that is larger, or from it, ``SIDE`` will do.

    A cyclic route begins and ends at the waypoint nearest to the start. Raises ``InputError`` for rounds of waypoints
    that are not cyclic, for places that fall together in the world, and for first and last ones that are tilted.
    """
    rounds = whole("rounds", rounds)
    count = len(waypoints)
    if rounds > 1 and not waypoints.cyclic:
        raise InputError("rounds", found=rounds, wanted="1: the waypoints are not cyclic",
                         hint="cyclic=True (--cyclic)")  # fmt: skip
    if rounds * count > MOST_PLACES:
        raise InputError("rounds", found=rounds, wanted=f"at most {MOST_PLACES // count} of {count} waypoints")
    order = np.arange(count)
    if waypoints.cyclic:
        order = np.roll(order, -_nearest(waypoints))
        order = np.append(np.tile(order, rounds), order[0])
    elif waypoints.start is not None and _begins_elsewhere(waypoints):
        order = np.append(START, order)
    spots = waypoints.positions[order]
    if order[0] == START and waypoints.start is not None:
        spots[0] = waypoints.start
    places = placement.to_world(spots)
    angles, lean = _angles(waypoints, placement, spots, order)
    route = Route(
        places,
        order,
        np.where(order == START, 0.0, waypoints.dwell[order]),
        angles,
        waypoints.roundness[order],
        lean > tolerance,
        np.where(_leans_most(lean, lean > tolerance), tolerance, np.maximum(tolerance, SIDE)),
    )
    _check(route, placement)
    return route


def _nearest(waypoints: Waypoints) -> int:
    """The waypoint nearest to the start."""
    if waypoints.start is None:
        return 0
    return int(np.argmin(waypoints.metric.distance(waypoints.start, waypoints.positions)))


def _begins_elsewhere(waypoints: Waypoints) -> bool:
    """Whether the start is not at the first waypoint: farther from it than a tenth of the way to the next."""
    first, metric = waypoints.positions[0], waypoints.metric
    if len(waypoints) == 1:
        return True
    gap = metric.distance(waypoints.start, first)  # type: ignore[arg-type]
    return bool(gap > 0.1 * metric.distance(first, waypoints.positions[1]))


def _angles(waypoints: Waypoints, placement: Placement, spots: Floats, order: Ints) -> tuple[Floats, Floats]:
    """(K,) continuous angles, and (K,) how far each leans from level."""
    if placement.quaternion is not None:
        angles, lean = _of_quaternions(spots[:, placement.quaternion : placement.quaternion + 4])
        return np.unwrap(angles), lean
    if placement.angle is None:
        return np.zeros(len(order)), np.zeros(len(order))
    first = float(spots[0, placement.angle])
    turned = np.where(order == START, 0.0, waypoints.turns[order])[1:]
    angles = np.append(first, first + np.cumsum(turned))
    angles = angles if not placement.upright else angles - 2 * np.pi * np.round(first / (2 * np.pi))
    return angles, np.arccos(np.cos(angles)) * placement.upright


def _leans_most(lean: Floats, tilted: Bools) -> Bools:
    """(K,) which tilted places have none beside them that leans more."""
    beside = np.pad(np.where(tilted, lean, 0.0), 1)
    return np.asarray(tilted & (lean >= beside[:-2]) & (lean >= beside[2:]))


def _of_quaternions(four: Floats) -> tuple[Floats, Floats]:
    """(K,) headings and (K,) angles between thrust and the vertical."""
    from scipy.spatial.transform import Rotation

    turned = Rotation.from_quat(four)
    nose, thrust = turned.apply([1.0, 0.0, 0.0]), turned.apply([0.0, 0.0, 1.0])
    return np.arctan2(nose[:, 1], nose[:, 0]), np.arccos(np.clip(thrust[:, 2], -1, 1))


def _check(route: Route, placement: Placement) -> None:
    if route.tilted.any() and not placement.upright:
        raise InputError("waypoints", where=route.name(int(np.argmax(route.tilted))), found="a tilt in 3 dimensions",
                         wanted="tilts in a vertical plane", hint="read(..., plane='yz')")  # fmt: skip
    gaps = np.linalg.norm(np.diff(route.places, axis=0), axis=1)
    if not (gaps > 1e-6).all():
        k = int(np.argmin(gaps)) + 1
        raise InputError("waypoints", where=route.name(k), found="the same position as the one before",
                         wanted="positions that differ: a vehicle turns over only on its way")  # fmt: skip
    for k in (0, len(route.places) - 1):
        if route.tilted[k]:
            tilt = np.degrees(np.arccos(np.cos(route.angles[k])))
            raise InputError("waypoints", where=route.name(k), found=f"a flight that rests tilted by {tilt:.0f}°",
                             wanted="level ones at both ends",
                             hint="cyclic=True (--cyclic), visits=True (--visits), or more tilt_tolerance")  # fmt: skip
    rests = route.tilted & (route.dwell > 0)
    if rests.any():
        raise InputError("dwell", where=route.name(int(np.argmax(rests))), found="a rest where the vehicle is tilted",
                         wanted="0 there")  # fmt: skip
