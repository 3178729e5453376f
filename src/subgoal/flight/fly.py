"""Waypoints flown by a simulated quadrotor: rotorpy's dynamics and its SE(3) controller."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from subgoal.flight.commands import Commands, commands_along
from subgoal.flight.placement import Placement
from subgoal.flight.record import Flight, FlightStatus
from subgoal.flight.smooth import MOST_SECONDS, SmoothPath, smooth
from subgoal.flight.vehicle import Simulated, Vehicle, vehicle_named
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream

STEP = 0.01
"""Seconds between commands, and of the integration."""
SETTLE = 0.5
"""Seconds of hovering at the end."""
ASTRAY = 2.0
"""Metres from the path at which a vehicle has lost it."""
TOLD_EVERY = 50
NEAR, APART = 0.1, 0.25
"""Metres within which a waypoint is reached, but no more than this share of the shortest leg."""


def fly(
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
    tolerance: float | None = None,
    tilt_tolerance: float = 0.3,
    constraints: Mapping[int, Mapping[str, Any]] | None = None,
    most_seconds: float = MOST_SECONDS,
    noise: float = 0.0,
    seed: int = 0,
    progress: Progress | None = None,
) -> Flight:
    """Fly ``smooth(waypoints, ...)`` from hover at its begin to hover at its end.

    Parameters
    ----------
    plane, height, scale, speed, acceleration, smoothing, overshoot, rounds, tilt_tolerance, constraints, most_seconds:
        As in ``smooth``.
    vehicle:
        "hummingbird" (0.5 kg, ten times its weight of thrust) or "crazyflie" (30 g, twice its weight: no loops).
    tolerance:
        Metres within which a waypoint is reached; a tilted one also within ``tilt_tolerance`` radians, or 1.2 at the
        sides of a loop. By default 0.1, or a quarter of the shortest way between two waypoints where that is less.
    noise:
        Standard deviation in metres of the positions that the controller is told; drawn with ``seed``.
    progress:
        Told how far the flight is.

    A flight that is interrupted, or whose vehicle comes 2 m from its path, ends there, and its status says so. Raises
    ``InputError`` and ``MissingExtraError`` as ``smooth`` does.
    """
    begin = time.perf_counter()
    made, noise = vehicle_named(vehicle), positive("noise", noise, zero=True)
    wanted = None if tolerance is None else positive("tolerance", tolerance)
    path = smooth(
        waypoints, plane=plane, height=height, scale=scale, speed=speed, acceleration=acceleration,
        smoothing=smoothing, overshoot=overshoot, rounds=rounds, vehicle=vehicle, tilt_tolerance=tilt_tolerance,
        constraints=constraints, most_seconds=most_seconds,
    )  # fmt: skip
    commands = commands_along(path, made, STEP, SETTLE)
    errors = noise * stream(seed).standard_normal((len(commands.times), 3))
    logged, ended = _simulated(made, commands, errors, Silent() if progress is None else progress)
    within = min(NEAR, APART * path.route.least_leg) if wanted is None else wanted, float(tilt_tolerance)
    return _flight(waypoints, path, made, commands, logged, ended, within, noise, time.perf_counter() - begin)


def _simulated(
    vehicle: Vehicle, commands: Commands, errors: Floats, progress: Progress
) -> tuple[dict[str, Floats], FlightStatus]:
    """States at each step, (n, …) for each part of the state, and why the flight ended if it did not fly to the end."""
    count = len(commands.times)
    craft = Simulated(vehicle, commands.positions[0], float(commands.yaw[0]), STEP)
    kept = {name: np.empty((count, value.size)) for name, value in craft.state.items()}
    ended, n = FlightStatus.FLOWN, count
    with Interrupt() as interrupt, progress as display:
        for k in range(count):
            for name, value in craft.state.items():
                kept[name][k] = value
            away = craft.state["x"] - commands.positions[k]
            if not away @ away < ASTRAY**2 or interrupt.requested:
                ended, n = (FlightStatus.STOPPED if interrupt.requested else FlightStatus.DIVERGED), k + 1
                break
            flat = {
                "x": commands.positions[k], "x_dot": commands.velocities[k], "x_ddot": commands.accelerations[k],
                "yaw": commands.yaw[k], "yaw_dot": 0.0,
            }  # fmt: skip
            turn = commands.rates[k], commands.angular[k]
            craft.advance(craft.command(commands.times[k], flat, *turn, craft.state["x"] + errors[k]))
            if k % TOLD_EVERY == 0:
                display.update(k, count)
    return {name: values[:n] for name, values in kept.items()}, ended


def _flight(
    waypoints: Waypoints, path: SmoothPath, vehicle: Vehicle, commands: Commands, logged: dict[str, Floats],
    ended: FlightStatus, within: tuple[float, float], noise: float, seconds: float,
) -> Flight:  # fmt: skip
    n = len(logged["x"])
    times = commands.times[:n]
    misses, tilts = _nearest(path, times, logged["x"], logged["q"])
    there = (misses <= within[0]) & (tilts <= path.route.tilt_tolerance)
    status = ended if ended is not FlightStatus.FLOWN or there.all() else FlightStatus.DID_NOT_ARRIVE
    return Flight(
        times, logged["x"], logged["v"], logged["q"], commands.positions[:n], logged["rotor_speeds"],
        vehicle.thrust(logged["rotor_speeds"]), waypoints, path, misses, tilts, *within, status,
        noise, vehicle.name, seconds,
    )  # fmt: skip


def _nearest(path: SmoothPath, times: Floats, positions: Floats, quaternions: Floats) -> tuple[Floats, Floats]:
    """(K,) how near the vehicle came to each place about the time it was due, and how far its thrust pointed aside."""
    route, due = path.route, path.arrivals
    count = len(due)
    misses, tilts = np.full(count, np.inf), np.where(route.tilted, np.inf, 0.0)
    legs = (due[1:] - due[:-1] - route.dwell[:-1]) / 2
    for k in range(count):
        early = due[k] - (legs[k - 1] if k else 0.0)
        late = due[k] + route.dwell[k] + (legs[k] if k < count - 1 else SETTLE)
        rows = np.flatnonzero((times >= early) & (times <= late))
        if not rows.size:
            continue
        gaps = np.linalg.norm(positions[rows] - route.places[k], axis=1)
        misses[k] = gaps.min()
        if route.tilted[k]:
            tilts[k] = _aside(path.placement, quaternions[rows[np.argmin(gaps)]], float(route.angles[k]))
    return misses, tilts


def _aside(placement: Placement, quaternion: Floats, angle: float) -> float:
    """Radians between the thrust of an attitude (4,) and that at a tilt."""
    from scipy.spatial.transform import Rotation

    thrust = Rotation.from_quat(quaternion).apply([0.0, 0.0, 1.0])
    return float(np.arccos(np.clip(thrust @ placement.direction(np.array([angle]))[0], -1, 1)))
