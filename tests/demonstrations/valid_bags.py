"""Small bags of ROS 1 and ROS 2, written by rosbags' own writers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

KINDS = ("bag", "db3", "mcap")
TRANSFORMS = "tf2_msgs/msg/TFMessage"
START = 1_700_000_000_000_000_123
"""Nanoseconds of the first stamp."""
Message = Callable[["Maker"], Any]


class Maker:
    """Makes messages for one version of ROS; places are x, y, z, qx, qy, qz, qw."""

    def __init__(self, version: int) -> None:
        self.version = version
        self.store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
        if TRANSFORMS not in self.store.types:
            self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TRANSFORMS))
        self.types = self.store.types

    def __call__(self, name: str, *parts: Any) -> Any:
        return self.types[name](*parts)

    def header(self, stamp: int, frame: str) -> Any:
        time = self("builtin_interfaces/msg/Time", stamp // 10**9, stamp % 10**9)
        return self("std_msgs/msg/Header", *((0,) if self.version == 1 else ()), time, frame)

    def inside(self, place: Iterable[float]) -> Any:
        place = list(place)
        point = self("geometry_msgs/msg/Point", *place[:3])
        return self("geometry_msgs/msg/Pose", point, self("geometry_msgs/msg/Quaternion", *place[3:]))

    def save(self, message: Any) -> bytes:
        save = self.store.serialize_ros1 if self.version == 1 else self.store.serialize_cdr
        return bytes(save(message, message.__msgtype__))


def pose(stamp: int, place: Iterable[float], frame: str = "map") -> Message:
    return lambda make: make("geometry_msgs/msg/PoseStamped", make.header(stamp, frame), make.inside(place))


def odometry(stamp: int, place: Iterable[float], twist: Iterable[float]) -> Message:
    def made(make: Maker) -> Any:
        linear, angular = (make("geometry_msgs/msg/Vector3", *part) for part in np.reshape(list(twist), (2, 3)))
        inside = make("geometry_msgs/msg/PoseWithCovariance", make.inside(place), np.zeros(36))
        moving = make("geometry_msgs/msg/Twist", linear, angular)
        moving = make("geometry_msgs/msg/TwistWithCovariance", moving, np.zeros(36))
        return make("nav_msgs/msg/Odometry", make.header(stamp, "odom"), "base", inside, moving)

    return made


def transforms(stamp: int, places: dict[str, Iterable[float]], frame: str = "world") -> Message:
    def made(make: Maker) -> Any:
        all_of_them = []
        for child, place in places.items():
            place = list(place)
            vector = make("geometry_msgs/msg/Vector3", *place[:3])
            inside = make("geometry_msgs/msg/Transform", vector, make("geometry_msgs/msg/Quaternion", *place[3:]))
            all_of_them.append(make("geometry_msgs/msg/TransformStamped", make.header(stamp, frame), child, inside))
        return make(TRANSFORMS, all_of_them)

    return made


def text(words: str) -> Message:
    return lambda make: make("std_msgs/msg/String", words)


def write_bag(
    folder: Path, kind: str, topics: dict[str, list[tuple[int, Message]]], *, name: str = "b", packed: str = ""
) -> Path:
    """A bag of (time of receipt, message) for each topic; gives the file, which for ROS 2 lies in a bag's folder.

    ``packed`` is "bz2" or "lz4" for ROS 1, "message" or "file" for ROS 2.
    """
    make = Maker(1 if kind == "bag" else 2)
    path = folder / (f"{name}.bag" if kind == "bag" else f"{name}_{kind}")
    with _writer(path, kind, packed.upper()) as writer:
        for topic, messages in topics.items():
            connection = None
            for received, message in messages:
                made = message(make)
                if connection is None:
                    connection = writer.add_connection(topic, made.__msgtype__, typestore=make.store)
                writer.write(connection, received, make.save(made))
    return path if kind == "bag" else path / f"{path.name}.{kind}"


def _writer(path: Path, kind: str, packed: str) -> Any:
    if kind == "bag":
        writer = Writer1(path)
        if packed:
            writer.set_compression(Writer1.CompressionFormat[packed])
        return writer
    plugin = StoragePlugin.MCAP if kind == "mcap" else StoragePlugin.SQLITE3
    other = Writer2(path, version=9, storage_plugin=plugin)
    if packed:
        other.set_compression(CompressionMode[packed], CompressionFormat.ZSTD)
    return other
