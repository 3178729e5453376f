"""The subgoals flown by a simulated quadrotor, in the words of the page."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight import Flight, FlightStatus, fly, tracking, waypoints, write_waypoints
from subgoal.flight.vehicle import GRAVITY, vehicle_named
from subgoal.posterior.posterior import Posterior

PLANE = "yz"
EVERY = 3
"""Steps of the simulation between two that the page is told."""
SPEED = 1.5
"""Metres per second."""


def flown(posterior: Posterior) -> dict[str, Any]:
    """A flight over the subgoals: places, tilts and thrust (1 is hovering) at a few times, and how well it followed.

    Raises ``InputError`` where there are no two subgoals to fly between, and ``MissingExtraError`` without ``flight``.
    """
    flight = fly(waypoints(posterior), plane=PLANE, speed=SPEED)
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
        "rmse": error.rmse,
        "largest": error.largest,
        "summary": _summary(flight, error.rmse, error.largest, error.units),
    }


def _summary(flight: Flight, rmse: float, largest: float, units: str) -> str:
    far = [_length(error, units) for error in (rmse, largest)]
    told = f"Flown in {flight.duration:.1f} s, {far[0]} from your path (root mean square), {far[1]} at most."
    return told if flight.status is FlightStatus.FLOWN else f"{told} It {flight.status.value}."


def _length(value: float, units: str) -> str:
    return f"{100 * value:.0f} cm" if units in ("m", "") else f"{value:.2g} {units}"


def waypoint_text(posterior: Posterior, kind: str) -> str:
    """Waypoints as "csv" or "json"; raises ``InputError`` where there are no two."""
    with tempfile.TemporaryDirectory(prefix="subgoal-teach-") as folder:
        path = Path(folder) / f"waypoints.{kind}"
        write_waypoints(waypoints(posterior), path)
        return path.read_text(encoding="utf-8")
