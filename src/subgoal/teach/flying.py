"""The subgoals flown by a simulated quadrotor, in the words of the page."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight import Flight, FlightStatus, Waypoints, fly, tracking, waypoints, write_waypoints
from subgoal.flight.placement import METRES
from subgoal.flight.vehicle import GRAVITY, vehicle_named
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.progress import Silent
from subgoal.teach.picture import HALF_WIDTH, HEIGHT

PLANE = "yz"
EVERY = 3
"""Steps of the simulation between two that the page is told."""
SPEED = 1.5
"""Metres per second."""
TINY = 1e-12


class Watched(Silent):
    """Progress that ends a flight, by ``StoppedError``, once nobody waits for it."""

    def __init__(self, wanted: Callable[[], bool]) -> None:
        self._wanted = wanted

    def update(self, done: int, total: int, note: str = "") -> None:
        """Go on only while somebody waits."""
        if not self._wanted():
            raise StoppedError("Nobody waits for this flight.")


def flown(posterior: Posterior, most_seconds: float, wanted: Callable[[], bool]) -> dict[str, Any]:
    """A flight over the subgoals: places, tilts and thrust (1 is hovering) at a few times, its stops in order, and how
    well it followed.

    Raises ``InputError`` where there are no two subgoals to fly between or the flight is longer than ``most_seconds``,
    ``MissingExtraError`` without ``flight``, and ``StoppedError`` soon after it is not ``wanted`` any more.
    """
    watched = Watched(wanted)
    watched.update(0, 1)
    points = waypoints(posterior)
    scale = metres_per_unit(points)
    try:
        flight = fly(points, plane=PLANE, speed=SPEED, scale=scale, most_seconds=most_seconds, progress=watched)
    except InputError as problem:
        if problem.what != "most_seconds":
            raise
        raise InputError("the path", found=problem.found, wanted=problem.wanted, hint="a shorter one") from None
    error = tracking(flight, posterior.demonstrations)
    rows = np.unique(np.append(np.arange(0, len(flight.times), EVERY), len(flight.times) - 1))
    weight = vehicle_named(flight.vehicle).parameters["mass"] * GRAVITY
    return {
        "type": "flight",
        "times": flight.times[rows].tolist(),
        "y": flight.shown[rows, 0].tolist(),
        "z": flight.shown[rows, 1].tolist(),
        "tilt": flight.angles[rows].tolist(),
        "thrust": (flight.thrust[rows] / weight).tolist(),
        "stops": _stops(flight, flight.times[rows]),
        "rmse": error.rmse,
        "largest": error.largest,
        "summary": _summary(flight, error.rmse, error.largest, points.units, scale),
    }


def _stops(flight: Flight, told: Floats) -> list[dict[str, Any]]:
    """Each waypoint in the order of the route, and which of the times told is the first at which it is due."""
    at = flight.route.waypoint
    rows = np.searchsorted(told, np.minimum(flight.path.arrivals, told[-1]))
    return [
        {"y": float(y), "z": float(z), "row": int(row)}
        for (y, z), row in zip(flight.waypoints.positions[at[at >= 0]], rows[at >= 0], strict=True)
    ]


def metres_per_unit(points: Waypoints) -> float:
    """That of a known unit; of another, 1 or what makes waypoints (n, 2) fit the empty plane, if that is less."""
    if points.units in METRES and points.units:
        return METRES[points.units]
    across, up = np.ptp(points.positions, axis=0)
    return float(min(1.0, 2 * HALF_WIDTH / max(across, TINY), HEIGHT / max(up, TINY)))


def _summary(flight: Flight, rmse: float, largest: float, units: str, scale: float) -> str:
    far = [f"{100 * scale * error:.0f} cm" for error in (rmse, largest)]
    told = f"Flown in {flight.duration:.1f} s, {far[0]} from your path (root mean square), {far[1]} at most."
    if scale != METRES.get(units):
        told += f" The unit of the file is {units or 'unknown'}: each was flown as {scale:.2g} m."
    return told if flight.status is FlightStatus.FLOWN else f"{told} It {flight.status.value}."


def waypoint_text(posterior: Posterior, kind: str) -> str:
    """Waypoints as "csv" or "json"; raises ``InputError`` where there are no two."""
    with tempfile.TemporaryDirectory(prefix="subgoal-teach-") as folder:
        path = Path(folder) / f"waypoints.{kind}"
        write_waypoints(waypoints(posterior), path)
        return path.read_text(encoding="utf-8")
