"""Bags of ROS 1 (``.bag``) and ROS 2 (folder with ``metadata.yaml``, ``.db3``, ``.mcap``), read with rosbags."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.files import bag_path, folder_source, guarded, source_of
from subgoal.demonstrations.readers.poses import TWIST, Posing, posed
from subgoal.demonstrations.readers.ros_messages import KINDS, ODOMETRY, TRANSFORMS, Pose
from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError

COLUMNS = ("x", "y", "z", "qx", "qy", "qz", "qw")
Stamped = tuple[int, Pose]
"""Nanoseconds of receipt, and a pose."""


def read_rosbag(
    path: Any,
    *,
    topic: str | None = None,
    frame: str | None = None,
    pose: bool = False,
    plane: str | None = None,
    twist: bool = False,
    scale: float = 1.0,
    units: str = "m",
    clock: str = "refuse",
) -> Recording:
    """Read the poses of one topic: PoseStamped, Odometry, TransformStamped, TFMessage.

    Parameters
    ----------
    path:
        A bag: a file, or the folder of a ROS 2 bag.
    topic:
        Which topic; None if only one holds poses.
    frame:
        Of a TFMessage, the child frame whose poses in its parent are read; None if there is only one.
    pose, plane:
        A quaternion beside the position, or two positions and an angle (``Posing``); by default positions.
    twist:
        Take the velocities of Odometry as actions. They are in the frame of the child and are turned into the world's.
    scale, units, clock:
        As in ``read_csv``; ``scale`` also multiplies the velocities of ``twist``.

    Returns
    -------
    Recording of one trajectory. Times are seconds since the first message, by the stamps of the headers; where a stamp
    is not set, all are the times of receipt, which ``source.notes`` counts.

    Raises
    ------
    ReadError
        The bag is damaged or empty, no topic holds poses, or a pose's frame of reference changes.
    InputError
        Several topics or frames, of which none is chosen, or one that is not there; they are listed.
    MissingExtraError
        rosbags is not installed.
    """
    how = Posing(pose, plane, scale, units, clock, time_scale=1e-9)
    path = bag_path(path)
    if importlib.util.find_spec("rosbags") is None:
        raise MissingExtraError("rosbags", "ros")
    with guarded(path, "a bag of ROS"):
        kind, found = _messages(path, topic)
    if frame is not None and kind not in TRANSFORMS:
        raise InputError("frame", found=repr(frame), wanted=f"None: {kind} is of one frame")
    if twist and kind != ODOMETRY:
        raise InputError("twist", found=f"True for {kind}", wanted=f"False, or a topic of {ODOMETRY}")
    if kind in TRANSFORMS:
        found = _of_frame(path, found, frame)
    parents = sorted({each.parent for _, each in found})
    if len(parents) > 1:
        raise ReadError(str(path), found=f"poses in the frames {_listed(parents)}", wanted="one frame of reference")
    source = folder_source(path) if path.is_dir() else source_of(path)
    columns, source = _columns(found, source)
    return posed(path, columns, "time", COLUMNS, how, source, twist=twist)


def _messages(path: Path, topic: str | None) -> tuple[str, list[Stamped]]:
    """Kind of the topic's messages, and their poses in the order of receipt."""
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        kinds = {each.topic: each.msgtype for each in reader.connections if each.msgtype in KINDS and each.msgcount}
        chosen = _choose_topic(path, topic, kinds, sorted({each.topic for each in reader.connections}))
        kind = kinds[chosen]
        wanted = [each for each in reader.connections if each.topic == chosen and each.msgtype == kind]
        return kind, [
            (received, pose)
            for connection, received, content in reader.messages(wanted)
            for pose in KINDS[kind](reader.deserialize(content, connection.msgtype))
        ]


def _choose_topic(path: Path, topic: str | None, kinds: dict[str, str], others: list[str]) -> str:
    if not kinds:
        raise ReadError(
            str(path), found=f"topics {_listed(others)}" if others else "no topic",
            wanted=f"messages of a kind that holds poses: {', '.join(KINDS)}",
        )  # fmt: skip
    if topic in kinds or (topic is None and len(kinds) == 1):
        return topic if topic is not None else next(iter(kinds))
    listed = ", ".join(f"{name!r} ({kind})" for name, kind in sorted(kinds.items())[:50])
    hint = f"topic={min(kinds)!r}"
    raise InputError("topic", where=path.name, found=repr(topic), wanted=f"one of {listed}", hint=hint)


def _of_frame(path: Path, found: list[Stamped], frame: str | None) -> list[Stamped]:
    """The poses of one child frame."""
    children = sorted({each.child for _, each in found})
    if not children:
        raise ReadError(str(path), found="messages without a transform", wanted="at least one")
    chosen = children[0] if frame is None and len(children) == 1 else frame
    wanted = chosen.lstrip("/") if isinstance(chosen, str) else None
    if wanted not in children:
        hint = f"frame={children[0]!r}"
        raise InputError("frame", where=path.name, found=repr(frame), wanted=f"one of {_listed(children)}", hint=hint)
    return [(received, each) for received, each in found if each.child == wanted]


def _columns(found: list[Stamped], source: Source) -> tuple[dict[str, Any], Source]:
    """Columns (M,) of time in nanoseconds since the first message, place and twist."""
    stamps = [each.stamp for _, each in found]
    if not all(stamps):
        stamps = [received for received, _ in found]
        source = source.noting(times_of_receipt_taken_for_stamps_that_are_not_set=len(stamps))
    columns: dict[str, Any] = {"time": np.array([stamp - stamps[0] for stamp in stamps], dtype=np.float64)}
    for names, rows in ((COLUMNS, [each.place for _, each in found]), (TWIST, [each.twist for _, each in found])):
        if rows and rows[0]:
            columns |= dict(zip(names, np.array(rows, dtype=np.float64).T, strict=True))
    return columns, source


def _listed(names: list[str]) -> str:
    return ", ".join(map(repr, names[:50])) + (" and more" if len(names) > 50 else "")
