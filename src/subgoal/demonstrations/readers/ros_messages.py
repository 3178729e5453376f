"""Messages of ROS that hold a pose: what each kind calls its parts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

Row = tuple[float, ...]


@dataclass(frozen=True)
class Pose:
    """One pose of a message.

    Attributes
    ----------
    stamp:
        Nanoseconds of the header, 0 where it was not set.
    parent, child:
        Frames that the pose is in and of; ``child`` is empty where the message does not say.
    place:
        x, y, z, and the quaternion's x, y, z, w.
    twist:
        Velocity and angular velocity in the child's frame, six numbers, or empty.
    """

    stamp: int
    parent: str
    child: str
    place: Row
    twist: Row = ()


def _pose(message: Any) -> Iterator[Pose]:
    yield _made(message.header, "", message.pose.position, message.pose.orientation)


def _pose_with_covariance(message: Any) -> Iterator[Pose]:
    yield _made(message.header, "", message.pose.pose.position, message.pose.pose.orientation)


def _odometry(message: Any) -> Iterator[Pose]:
    inside, twist = message.pose.pose, message.twist.twist
    row = (*_three(twist.linear), *_three(twist.angular))
    yield _made(message.header, message.child_frame_id, inside.position, inside.orientation, row)


def _transform(message: Any) -> Iterator[Pose]:
    inside = message.transform
    yield _made(message.header, message.child_frame_id, inside.translation, inside.rotation)


def _transforms(message: Any) -> Iterator[Pose]:
    for each in message.transforms:
        yield from _transform(each)


TRANSFORMS = frozenset({"tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"})
"""Kinds that hold poses of several frames."""
ODOMETRY = "nav_msgs/msg/Odometry"
KINDS: Mapping[str, Callable[[Any], Iterator[Pose]]] = {
    "geometry_msgs/msg/PoseStamped": _pose,
    "geometry_msgs/msg/PoseWithCovarianceStamped": _pose_with_covariance,
    "geometry_msgs/msg/TransformStamped": _transform,
    ODOMETRY: _odometry,
    **dict.fromkeys(TRANSFORMS, _transforms),
}
"""Kinds of messages that hold poses, as ROS 2 spells them."""


def _made(header: Any, child: str, position: Any, orientation: Any, twist: Row = ()) -> Pose:
    stamp = int(header.stamp.sec) * 10**9 + int(header.stamp.nanosec)
    place = (*_three(position), *_three(orientation), float(orientation.w))
    return Pose(stamp, header.frame_id.lstrip("/"), child.lstrip("/"), place, twist)


def _three(vector: Any) -> Row:
    return float(vector.x), float(vector.y), float(vector.z)
