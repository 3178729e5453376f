"""A flight on disk: ``flight.csv`` with what the vehicle did, ``flight.json`` with how well."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np

from subgoal.flight.files import aside
from subgoal.flight.record import Flight
from subgoal.flight.tracking import Tracking

COLUMNS = (
    "time", "x", "y", "z", "vx", "vy", "vz", "qx", "qy", "qz", "qw", "commanded_x", "commanded_y", "commanded_z",
    "thrust", "angle",
)  # fmt: skip


def write_flight(flight: Flight, error: Tracking, folder: str | Path) -> tuple[Path, Path]:
    """Write both files into ``folder``, made if it is missing, and give back where they lie.

    The table is in seconds, metres, newtons and radians of the world. Numbers of the other are in the units of the
    demonstration where they are of the tracking, else in metres, seconds and radians.
    """
    table, numbers = Path(folder) / "flight.csv", Path(folder) / "flight.json"
    rows = np.column_stack([
        flight.times, flight.positions, flight.velocities, flight.quaternions, flight.commanded, flight.thrust,
        flight.angles,
    ])  # fmt: skip
    with aside(table) as place, place.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([f"{value:.9g}" for value in row] for row in rows.tolist())
    with aside(numbers) as place:
        place.write_text(json.dumps(_numbers(flight, error), indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return table, numbers


def _numbers(flight: Flight, error: Tracking) -> dict[str, object]:
    placement = flight.placement
    return {
        "status": flight.status.name, "message": flight.told, "notes": list(flight.waypoints.notes),
        "duration": flight.duration, "vehicle": flight.vehicle, "plane": placement.plane, "scale": placement.scale,
        "units": error.units, "tracking_rmse": error.rmse, "tracking_largest": error.largest,
        "angle_rmse": error.angle_rmse, "angle_largest": error.angle_largest,
        "half_extent_flown": error.halves_flown.tolist(),
        "half_extent_demonstrated": error.halves_demonstrated.tolist(), "overshoot": flight.path.overshoot,
        "tolerance": flight.tolerance, "tilt_tolerance": flight.tilt_tolerance,
        "largest_speed": float(np.linalg.norm(flight.velocities, axis=1).max()),
        "places": [
            {
                "waypoint": int(k) + 1 if k >= 0 else "start", "due": float(due), "reached": bool(there),
                "miss": float(miss) if np.isfinite(miss) else None, "tilt_error": float(tilt) if np.isfinite(tilt) else
                None,
            }
            for k, due, there, miss, tilt in zip(
                flight.route.waypoint, flight.path.arrivals, flight.reached, flight.misses, flight.tilts, strict=True
            )
        ],
    }  # fmt: skip
