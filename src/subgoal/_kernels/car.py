"""A single-track car on tyres with combined slip (Velenis, Tsiotras, Lu): derivatives and held actions.

A state is (v_x, v_y, r, w): body velocities in m/s, yaw rate in rad/s, surface speed of the wheels in m/s. An action is
(δ, w_c): steering angle in rad and commanded w. Every tyre has the theoretical slip s = (v_long − w, v_lat) / √(w² +
v₀²) and the force −F_z μ(s) s / |s|, μ(s) = μ sin(C arctan(B |s|)): the simplified magic formula on a friction circle.
"""

from __future__ import annotations

from math import atan, ceil, cos, sin, sqrt
from typing import NamedTuple

from numba import njit

GRAVITY = 9.81
"""m/s²."""


class Build(NamedTuple):
    """The numbers of a car: lengths in m from the centre of mass, kg, kg m², s, m/s; ``drives_front`` is a boolean."""

    mass: float
    inertia: float
    front: float
    rear: float
    height: float
    friction: float
    stiffness: float
    shape: float
    rolling: float
    lag: float
    smoothing: float
    drives_front: bool


@njit(cache=True, nogil=True)
def grip(along, across, build):
    """Force per load (along, across) at a slip: μ(s) against the direction of the slip."""
    size = sqrt(along * along + across * across)
    if size == 0.0:
        return 0.0, 0.0
    share = -build.friction * sin(build.shape * atan(build.stiffness * size)) / size
    return share * along, share * across


@njit(cache=True, nogil=True)
def front_grip(along, across, wheel, build):
    """Force per load of a front tyre that moves at (along, across) m/s in its own frame.

    Driven, it has combined slip; free, it turns with the road and has lateral slip and a rolling drag.
    """
    if build.drives_front:
        scale = sqrt(wheel * wheel + build.smoothing * build.smoothing)
        return grip((along - wheel) / scale, across / scale, build)
    scale = sqrt(along * along + build.smoothing * build.smoothing)
    return -build.rolling * along / scale, grip(0.0, across / scale, build)[1]


@njit(cache=True, nogil=True)
def slope(vx, vy, rate, wheel, cosine, sine, command, build):
    """d(v_x, v_y, r, w)/dt, steered by an angle of this ``cosine`` and ``sine``.

    With the centre of mass at a height, the acceleration along the car loads the rear axle: F_zf = (m g l_r − h X) / L.
    """
    base = build.front + build.rear
    lateral = vy + build.front * rate
    along, across = front_grip(vx * cosine + lateral * sine, lateral * cosine - vx * sine, wheel, build)
    front_x, front_y = along * cosine - across * sine, along * sine + across * cosine
    scale = sqrt(wheel * wheel + build.smoothing * build.smoothing)
    rear_x, rear_y = grip((vx - wheel) / scale, (vy - build.rear * rate) / scale, build)
    weight = build.mass * GRAVITY
    total = weight * (front_x * build.rear + rear_x * build.front) / (base + build.height * (front_x - rear_x))
    front_load = (weight * build.rear - build.height * total) / base
    rear_load = weight - front_load
    force = front_y * front_load + rear_y * rear_load
    moment = build.front * front_y * front_load - build.rear * rear_y * rear_load
    return (
        total / build.mass + vy * rate,
        force / build.mass - vx * rate,
        moment / build.inertia,
        (command - wheel) / build.lag,
    )


@njit(cache=True, nogil=True)
def derivatives(states, actions, build, out):
    """Write ``out`` (B, 4): the derivative of each of ``states`` (B, 4) under ``actions`` (B, 2)."""
    for b in range(states.shape[0]):
        vx, vy, rate, wheel = states[b]
        out[b] = slope(vx, vy, rate, wheel, cos(actions[b, 0]), sin(actions[b, 0]), actions[b, 1], build)


@njit(cache=True, nogil=True)
def advance(states, actions, duration, step, build, out):
    """Write ``out`` (B, 4): ``states`` (B, 4) after ``duration`` seconds of held ``actions`` (B, 2).

    Heun's method (second order) in equal steps of at most ``step`` seconds.
    """
    count = max(1, ceil(duration / step - 1e-9))
    h = duration / count
    for b in range(states.shape[0]):
        vx, vy, rate, wheel = states[b]
        cosine, sine, command = cos(actions[b, 0]), sin(actions[b, 0]), actions[b, 1]
        for _ in range(count):
            ax, ay, ar, aw = slope(vx, vy, rate, wheel, cosine, sine, command, build)
            bx, by, br, bw = slope(
                vx + h * ax, vy + h * ay, rate + h * ar, wheel + h * aw, cosine, sine, command, build
            )
            vx += 0.5 * h * (ax + bx)
            vy += 0.5 * h * (ay + by)
            rate += 0.5 * h * (ar + br)
            wheel += 0.5 * h * (aw + bw)
        out[b, 0], out[b, 1], out[b, 2], out[b, 3] = vx, vy, rate, wheel
