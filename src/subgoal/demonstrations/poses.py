"""Orientations in recordings: unit quaternions (x, y, z, w) as four columns, or one angle in a plane.

Rotations take vectors of the body to the world, and angular velocities are those of the world, in radians per unit of
time. The rate of a quaternion q that turns with angular velocity ω is ½ ω q, half as long as ω and at right angles to
q, so that a quaternion column counts 2 ℓ where a radian counts ℓ (``pose_metric``).
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.velocities import Velocity
from subgoal.runtime.checks import Floats, Ints, positive, real_array
from subgoal.runtime.errors import InputError

LEAST_NORM = 1e-6
"""A quaternion shorter than this says nothing of a rotation."""
AXES = "xyz"
QUARTER = np.pi / 2


def pose_metric(length: float, *, planar: bool = False) -> Metric:
    """Distance between poses in which a radian counts as ``length`` units of position.

    For (x, y, z, qx, qy, qz, qw), or for (a, b, angle) if ``planar``, where it is exact and wraps. Of quaternions it
    is 4 ℓ sin(φ/4) for rotations that are φ apart, short of ℓ φ by 1 % at 56° and by 10 % at 180°; two quaternions of
    opposite sign are one rotation but are far apart.
    """
    length = positive("length", length)
    if planar:
        return Metric.of(3, (1, 1, length), (np.inf, np.inf, 2 * np.pi))
    return Metric.of(7, (1, 1, 1, *(2 * length,) * 4))


def nothing_turns(quaternions: Floats) -> NDArray[np.bool_]:
    """(M,) which of the quaternions (M, 4) are too short to say a rotation, or too long for a norm."""
    with np.errstate(over="ignore"):
        norm = np.linalg.norm(quaternions, axis=1)
    return np.asarray((norm < LEAST_NORM) | np.isinf(norm))


def continue_quaternions(quaternions: Any, offset: Ints) -> Floats:
    """(M, 4) made unit quaternions whose sign continues: each is less than half a turn of the sphere from the last.

    ``offset`` (D+1,) is the start of each trajectory; these begin with the sign that is nearer to the first quaternion
    of all, whose last part w is not below 0. Raises ``InputError`` for a quaternion without length.
    """
    from scipy.spatial.transform import Rotation

    given = real_array("quaternions", quaternions, ndim=2)
    if given.shape[1] != 4:
        raise InputError("quaternions", found=f"{given.shape[1]} columns", wanted="4: x, y, z, w")
    short = nothing_turns(given)
    if short.any():
        row = int(np.argmax(short))
        raise InputError("quaternions", where=f"row {row}", found=list(given[row]), wanted="a rotation")
    unit = Rotation.from_quat(given).as_quat(canonical=True)
    steps = np.where(np.einsum("ij,ij->i", unit[1:], unit[:-1]) < 0, -1.0, 1.0)
    signs = np.ones(len(unit))
    for a, b in pairwise(np.asarray(offset).tolist()):
        signs[a] = -1.0 if unit[a] @ unit[0] < 0 else 1.0
        signs[a + 1 : b] = signs[a] * np.cumprod(steps[a : b - 1])
    return np.asarray(unit * signs[:, None])


def slerped(quaternions: Floats, times: Floats, grid: Floats) -> Floats:
    """(n, 4) quaternions at the times ``grid`` (n,), on the shortest way between (m, 4) at ``times`` (m,)."""
    from scipy.spatial.transform import Rotation, Slerp

    made = Slerp(times, Rotation.from_quat(quaternions))(grid).as_quat()
    straight = np.stack([np.interp(grid, times, column) for column in quaternions.T], axis=1)
    return np.where(np.einsum("ij,ij->i", made, straight)[:, None] < 0, -made, made)


def unrolled(quaternions: Floats) -> Floats:
    """(m, 3) the sum of the rotation vectors from each sample to the next, whose rate is the angular velocity."""
    from scipy.spatial.transform import Rotation

    rotations = Rotation.from_quat(quaternions)
    steps = (rotations[1:] * rotations[:-1].inv()).as_rotvec()
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def on_poses(velocity: Velocity, at: int) -> Velocity:
    """``velocity`` for places with a quaternion in the columns from ``at``, which it gives the rates of."""

    def of_poses(places: Floats, times: Floats, window: int) -> tuple[Ints, Floats]:
        before, four, after = places[:, :at], places[:, at : at + 4], places[:, at + 4 :]
        rows, rates = velocity(np.hstack([before, unrolled(four), after]), times, window)
        turning = quaternion_rates(four[rows], rates[:, at : at + 3])
        return rows, np.hstack([rates[:, :at], turning, rates[:, at + 3 :]])

    return of_poses


def quaternion_rates(quaternions: Floats, angular: Floats) -> Floats:
    """(..., 4) ½ ω q from unit quaternions q (..., 4) and angular velocities ω (..., 3) in the world."""
    from scipy.spatial.transform import Rotation

    speed = np.linalg.norm(angular, axis=-1, keepdims=True)
    axis = np.where(speed > 0, angular / np.where(speed > 0, speed, 1.0), 0.0)
    quarter = Rotation.from_rotvec(QUARTER * axis.reshape(-1, 3))
    turned = (quarter * Rotation.from_quat(quaternions.reshape(-1, 4))).as_quat().reshape(quaternions.shape)
    turned = np.where((turned * quaternions).sum(axis=-1, keepdims=True) < 0, -turned, turned)
    return np.asarray(speed * (turned / np.sin(QUARTER / 2) - quaternions) / 2)


def angular_velocities(quaternions: Any, rates: Any) -> Floats:
    """(N, 3) angular velocities in the world, from unit quaternions (N, 4) and their rates (N, 4).

    Those are columns of states and actions of demonstrations of poses: ``states[:, 3:7]`` and ``actions[:, 3:7]``.
    Raises ``InputError`` for other shapes.
    """
    from scipy.spatial.transform import Rotation

    four, rates = (real_array(what, each, ndim=2) for what, each in (("quaternions", quaternions), ("rates", rates)))
    if four.shape[1] != 4 or rates.shape != four.shape:
        raise InputError("rates", found=f"shapes {four.shape}, {rates.shape}", wanted="(N, 4) both")
    speed = np.linalg.norm(rates, axis=1, keepdims=True)
    along = np.where(speed > 0, rates / np.where(speed > 0, speed, 1.0), 0.0)
    turned = (four + along) * np.cos(QUARTER / 2)
    axis = (Rotation.from_quat(turned) * Rotation.from_quat(four).inv()).as_rotvec() / QUARTER
    return np.asarray(2 * speed * axis)


def towards_pose(state: Any, goal: Any) -> Floats:
    """The straight way in positions and the shortest rotation: a controller for ``action_comparison``.

    States and goals (..., 7) are (x, y, z, qx, qy, qz, qw) and broadcast; the sign of the quaternion of a goal does not
    matter. To be compared with ``compare="direction"``.
    """
    from scipy.spatial.transform import Rotation

    state, goal = np.asarray(state, float), np.asarray(goal, float)
    shape = np.broadcast_shapes(state.shape, goal.shape)
    here, there = (np.broadcast_to(each[..., 3:7], (*shape[:-1], 4)) for each in (state, goal))
    ways = Rotation.from_quat(there.reshape(-1, 4)) * Rotation.from_quat(here.reshape(-1, 4)).inv()
    turning = quaternion_rates(here, ways.as_rotvec().reshape(*shape[:-1], 3))
    return np.concatenate([np.broadcast_to((goal - state)[..., :3], (*shape[:-1], 3)), turning], axis=-1)


def plane_axes(plane: Any) -> tuple[int, int, int, int]:
    """Numbers of the two axes of a plane such as "yz", of its normal, and the sign of a turn from the first axis to
    the second about it. Raises ``InputError`` for anything else.
    """
    if not isinstance(plane, str) or len(plane) != 2 or len(set(plane) & set(AXES)) != 2:
        raise InputError("plane", found=repr(plane), wanted="two of the axes x, y and z, such as 'yz'")
    first, second = AXES.index(plane[0]), AXES.index(plane[1])
    return first, second, 3 - first - second, 1 if (second - first) % 3 == 1 else -1


def plane_angles(quaternions: Floats, offset: Ints, plane: str) -> tuple[Floats, Floats]:
    """(M,) angles in a plane, from its first axis to its second, and (M,) how far each pose leans out of the plane.

    A rotation is a turn about the normal after a tilt about an axis in the plane; angles are those of the turn, made
    continuous within each trajectory.
    """
    _, _, normal, sign = plane_axes(plane)
    along, whole = quaternions[:, normal], quaternions[:, 3]
    angles = sign * 2 * np.arctan2(along, whole)
    for a, b in pairwise(np.asarray(offset).tolist()):
        angles[a:b] = np.unwrap(angles[a:b])
    return angles, 2 * np.arccos(np.clip(np.hypot(along, whole), 0, 1))
