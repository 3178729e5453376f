"""What a controller is told at each step: where to be, how to move, and how to turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.flight.smooth import SmoothPath
from subgoal.flight.vehicle import GRAVITY, WEIGHT, Vehicle
from subgoal.runtime.checks import Floats


@dataclass(frozen=True, eq=False)
class Commands:
    """Flat outputs at each step.

    Attributes
    ----------
    times:
        (n,) seconds.
    positions, velocities:
        (n, 3) of the path.
    accelerations:
        (n, 3) of the path, and what the drag of the rotors takes away.
    yaw:
        (n,) radians.
    rates, angular:
        (n, 3) angular velocities and accelerations in the body, of the attitude that all this asks for.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats
    yaw: Floats
    rates: Floats
    angular: Floats


def commands_along(path: SmoothPath, vehicle: Vehicle, step: float, settle: float) -> Commands:
    """Commands every ``step`` seconds along the path, and for ``settle`` seconds after its end."""
    from scipy.spatial.transform import Rotation

    times = np.asarray(np.arange(int(np.ceil((path.duration + settle) / step)) + 1) * step, np.float64)
    positions, velocities, accelerations = path.at(times, 3)
    yaw = path.headings(times)
    needed = accelerations + _drag(velocities, _attitudes(accelerations, yaw), accelerations, vehicle)
    turned = Rotation.from_matrix(_attitudes(needed, yaw))
    rates = np.vstack([(turned[:-1].inv() * turned[1:]).as_rotvec() / step, np.zeros((1, 3))])
    return Commands(times, positions, velocities, needed, yaw, rates, np.gradient(rates, step, axis=0))


def _attitudes(accelerations: Floats, yaw: Floats) -> Floats:
    """(n, 3, 3) from the body to the world, whose thrust gives the accelerations (n, 3) at yaw (n,)."""
    up = accelerations + WEIGHT
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    nose = np.stack([np.cos(yaw), np.sin(yaw), np.zeros(len(yaw))], axis=1)
    side = np.cross(up, nose)
    side /= np.maximum(np.linalg.norm(side, axis=1, keepdims=True), 1e-9)
    return np.stack([np.cross(side, up), side, up], axis=2)


def _drag(velocities: Floats, attitudes: Floats, accelerations: Floats, vehicle: Vehicle) -> Floats:
    """(n, 3) m/s² that make up for the drag of the rotors: proportional to their speed and to that of the body."""
    p = vehicle.parameters
    thrust = np.linalg.norm(accelerations + WEIGHT, axis=1)
    spin = p["num_rotors"] * vehicle.hover_speed * np.sqrt(thrust / GRAVITY)
    body = np.einsum("nij,ni->nj", attitudes, velocities) * [p["k_d"], p["k_d"], p["k_z"]]
    return np.asarray(np.einsum("nij,nj->ni", attitudes, body) * spin[:, None] / p["mass"])
