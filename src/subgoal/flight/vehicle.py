"""A quadrotor of rotorpy with its own SE(3) controller, stepped by the midpoint rule."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError, MissingExtraError

VEHICLES = ("hummingbird", "crazyflie")
GRAVITY = 9.81
WEIGHT = np.array([0.0, 0.0, GRAVITY])
RESERVE = 0.85
"""Of the thrust of all rotors, what a path may ask for: the rest is for keeping to it."""
FASTEST = 20.0
"""Metres per second above which the vehicle's model is not to be trusted."""
State = dict[str, Floats]


@dataclass(frozen=True, eq=False)
class Vehicle:
    """Parameters of a vehicle.

    Attributes
    ----------
    name:
        One of ``VEHICLES``.
    parameters:
        As rotorpy has them.
    """

    name: str
    parameters: dict[str, Any]

    @property
    def most_thrust(self) -> float:
        """Thrust of all rotors at full speed, over the mass: m/s²."""
        p = self.parameters
        return float(p["num_rotors"] * p["k_eta"] * p["rotor_speed_max"] ** 2 / p["mass"])

    @property
    def usable_thrust(self) -> float:
        """What a path may ask for, m/s²."""
        return RESERVE * self.most_thrust

    @property
    def turning(self) -> float:
        """Angular acceleration about a level axis for each m/s² of thrust, with all of it on one side: rad/s² per m/s².

        More would need rotors that pull.
        """
        p = self.parameters
        arm = min(abs(float(each[0])) for each in p["rotor_pos"].values())
        return float(arm * p["mass"] / max(p["Ixx"], p["Iyy"]))

    @property
    def hover_speed(self) -> float:
        """Speed of each rotor, rad/s, that carries the weight."""
        p = self.parameters
        return float(np.sqrt(p["mass"] * GRAVITY / (p["num_rotors"] * p["k_eta"])))

    def thrust(self, rotor_speeds: Floats) -> Floats:
        """(n,) thrust in newtons for rotor speeds (n, 4)."""
        return np.asarray(self.parameters["k_eta"] * (rotor_speeds**2).sum(axis=-1))


def vehicle_named(name: str) -> Vehicle:
    """Raises ``InputError`` for another name and ``MissingExtraError`` without rotorpy."""
    if name not in VEHICLES:
        raise InputError("vehicle", found=repr(name), wanted=f"one of {', '.join(map(repr, VEHICLES))}")
    need_flight()
    return Vehicle(name, dict(import_module(f"rotorpy.vehicles.{name}_params").quad_params))


def need_flight() -> None:
    """Raise ``MissingExtraError`` unless the packages of the extra are there."""
    for package in ("rotorpy", "minsnap_trajectories"):
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError(package, "flight")


class Simulated:
    """A vehicle in the air and its controller.

    rotorpy's dynamics give the accelerations. Rotors follow their commands exactly as its first-order lag says, and the
    rest is stepped by the midpoint rule: two evaluations a step, where ``Multirotor.step`` sets up an adaptive solver.
    """

    def __init__(self, vehicle: Vehicle, position: Floats, yaw: float, step: float) -> None:
        from rotorpy.controllers.quadrotor_control import SE3Control
        from rotorpy.vehicles.multirotor import Multirotor

        p = vehicle.parameters
        self._model, self._controller, self._step = Multirotor(p), SE3Control(p), step
        self._slowest, self._fastest = p["rotor_speed_min"], p["rotor_speed_max"]
        self._half, self._whole = (float(np.exp(-part * step / p["tau_m"])) for part in (0.5, 1.0))
        self.state: State = {
            "x": np.array(position, float), "v": np.zeros(3), "w": np.zeros(3), "wind": np.zeros(3),
            "q": np.array([0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)]),
            "rotor_speeds": np.full(p["num_rotors"], vehicle.hover_speed),
        }  # fmt: skip

    def command(self, time: float, flat: dict[str, Any], rates: Floats, angular: Floats, told: Floats) -> Floats:
        """(4,) rotor speeds for the flat output; ``told`` (3,) is the position that is measured.

        ``rates`` and ``angular`` (3,) are the angular velocity and acceleration of the attitude of the flat output. The
        controller holds that attitude as if it stood still; seen from it, an error −``angular`` / kd asks for the
        moment that turns the vehicle along with it.
        """
        error = self.state["w"] - rates - angular / self._controller.kd_att
        seen = {**self.state, "x": told, "w": error}
        speeds = self._controller.update(time, seen, flat)["cmd_motor_speeds"]
        return np.asarray(np.clip(speeds, self._slowest, self._fastest))

    def advance(self, speeds: Floats) -> None:
        """One step with rotors commanded to ``speeds`` (4,)."""
        now, half, control = self.state, 0.5 * self._step, {"cmd_motor_speeds": speeds}
        rate = self._model.statedot(now, control, self._step)
        middle = {
            "x": now["x"] + half * now["v"], "v": now["v"] + half * rate["vdot"],
            "q": turned(now["q"], half * now["w"]), "w": now["w"] + half * rate["wdot"], "wind": now["wind"],
            "rotor_speeds": speeds + self._half * (now["rotor_speeds"] - speeds),
        }  # fmt: skip
        rate = self._model.statedot(middle, control, self._step)
        self.state = {
            "x": now["x"] + self._step * middle["v"], "v": now["v"] + self._step * rate["vdot"],
            "q": turned(now["q"], self._step * middle["w"]), "w": now["w"] + self._step * rate["wdot"],
            "wind": now["wind"], "rotor_speeds": speeds + self._whole * (now["rotor_speeds"] - speeds),
        }  # fmt: skip


def turned(quaternion: Floats, turn: Floats) -> Floats:
    """(4,) unit quaternion (x, y, z, w) after a rotation vector (3,) of the body."""
    angle = float(np.sqrt(turn @ turn))
    part = 0.5 if angle < 1e-12 else np.sin(angle / 2) / angle
    a, b, c = (float(part * each) for each in turn)
    d = float(np.cos(angle / 2))
    x, y, z, w = (float(each) for each in quaternion)
    made = np.array([
        w * a + x * d + y * c - z * b, w * b - x * c + y * d + z * a, w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    ])  # fmt: skip
    return np.asarray(made / np.sqrt(made @ made))
