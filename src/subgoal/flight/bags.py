"""Waypoints as a message for ROS: one ``nav_msgs/Path`` in a bag, written with rosbags."""

from __future__ import annotations

import importlib.util
import tempfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight.placement import Placement, place
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import MissingExtraError

TOPIC = "/waypoints"
PATH = "nav_msgs/msg/Path"
Aside = Callable[[Path], AbstractContextManager[Path]]


def write_bag(
    waypoints: Waypoints, path: Path, kind: str, frame: str, plane: str | None, height: float, scale: float | None,
    aside: Aside,
) -> Path:  # fmt: skip
    """A bag of the kind "bag", "db3" or "mcap"; gives where it lies: ``path``, or for "db3" a folder with that stem."""
    if importlib.util.find_spec("rosbags") is None:
        raise MissingExtraError("rosbags", "ros")
    poses = _poses(waypoints, place(waypoints, plane, height, scale))
    lies = path.with_suffix("") if kind == "db3" else path
    with aside(lies) as made:
        if kind == "mcap":
            with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.stem}.") as folder:
                _write(Path(folder) / "bag", kind, poses, frame)
                next((Path(folder) / "bag").glob("*.mcap")).replace(made)
        else:
            _write(made, kind, poses, frame)
    return lies


def _poses(waypoints: Waypoints, placement: Placement) -> Floats:
    """(K, 7) metres and quaternions; the first again at the end of cyclic ones."""
    order = np.arange(len(waypoints))
    order = np.append(order, 0) if waypoints.cyclic else order
    places = waypoints.positions[order]
    return np.hstack([placement.to_world(places), _quaternions(places, placement)])


def _quaternions(places: Floats, placement: Placement) -> Floats:
    """(K, 4) x, y, z, w: level where nothing is said."""
    from scipy.spatial.transform import Rotation

    if placement.quaternion is not None:
        return places[:, placement.quaternion : placement.quaternion + 4]
    if placement.angle is None:
        return np.tile([0.0, 0.0, 0.0, 1.0], (len(places), 1))
    angles = places[:, placement.angle]
    if not placement.upright:
        return np.asarray(Rotation.from_euler("z", angles[:, None]).as_quat())
    first, second = placement.axes
    normal = np.cross(np.eye(3)[first], np.eye(3)[second])
    return np.asarray(Rotation.from_rotvec(angles[:, None] * normal).as_quat())


def _write(place: Path, kind: str, poses: Floats, frame: str) -> None:
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    old = kind == "bag"
    store = get_typestore(Stores.ROS1_NOETIC if old else Stores.ROS2_HUMBLE)
    message = _message(store.types, poses, frame, old=old)
    if old:
        with Writer1(place) as first:
            first.write(first.add_connection(TOPIC, PATH, typestore=store), 0, store.serialize_ros1(message, PATH))
        return
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    with Writer2(place, version=9, storage_plugin=plugin) as second:
        second.write(second.add_connection(TOPIC, PATH, typestore=store), 0, store.serialize_cdr(message, PATH))


def _message(types: Any, poses: Floats, frame: str, *, old: bool) -> Any:
    """A path of poses (K, 7), all stamped with no time."""
    stamp = types["builtin_interfaces/msg/Time"](0, 0)
    header = types["std_msgs/msg/Header"](*((0,) if old else ()), stamp, frame)
    point, turn = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Quaternion"]
    pose, stamped = types["geometry_msgs/msg/Pose"], types["geometry_msgs/msg/PoseStamped"]
    return types[PATH](header, [stamped(header, pose(point(*row[:3]), turn(*row[3:]))) for row in poses.tolist()])
