"""The car by vectors of the plane as complex numbers, one state at a time, integrated to rounding by SciPy."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

MASS, INERTIA, FRONT, REAR, MU, STIFFNESS, SHAPE, V0, LAG = 0.906, 0.003, 0.10, 0.107, 0.45, 4.0, 1.4, 0.3, 0.10
LOAD = {"front": MASS * 9.81 * REAR / (FRONT + REAR), "rear": MASS * 9.81 * FRONT / (FRONT + REAR)}


def tyre(slip: complex) -> complex:
    size = abs(slip)
    return 0j if size == 0 else -slip / size * MU * np.sin(SHAPE * np.arctan(STIFFNESS * size))


def derivative(state: np.ndarray, action: np.ndarray, drive: str) -> np.ndarray:
    vx, vy, r, w = state
    wheel = np.exp(1j * action[0])
    at_front = (vx + 1j * (vy + FRONT * r)) / wheel
    if drive == "all":
        front = tyre((at_front - w) / np.hypot(w, V0))
    else:
        scale = np.hypot(at_front.real, V0)
        front = tyre(1j * at_front.imag / scale) - 0.02 * at_front.real / scale
    front *= wheel * LOAD["front"]
    rear = LOAD["rear"] * tyre((vx + 1j * (vy - REAR * r) - w) / np.hypot(w, V0))
    rate = (front + rear) / MASS - 1j * r * (vx + 1j * vy)
    return np.array([rate.real, rate.imag, (FRONT * front.imag - REAR * rear.imag) / INERTIA, (action[1] - w) / LAG])


def after(state: np.ndarray, action: np.ndarray, drive: str, duration: float) -> np.ndarray:
    found = solve_ivp(
        lambda _, s: derivative(s, action, drive), (0, duration), state, method="DOP853", rtol=1e-11, atol=1e-12
    )
    return found.y[:, -1]
