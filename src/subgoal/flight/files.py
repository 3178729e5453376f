"""Waypoints on disk: a table, a versioned file with units, or a path for ROS; written aside and renamed."""

from __future__ import annotations

import contextlib
import json
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight.bags import write_bag
from subgoal.flight.tables import read_table, write_table
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.errors import InputError, ReadError

KIND, VERSION = "subgoal waypoints", 1
BAGS = {".bag": "bag", ".mcap": "mcap", ".db3": "db3"}


def write_waypoints(
    waypoints: Waypoints, path: str | Path, *, frame: str = "map", plane: str | None = None, height: float = 1.0,
    scale: float | None = None,
) -> Path:  # fmt: skip
    """Write waypoints by the suffix of ``path``, and give back where they lie.

    ``.csv``: label, name, coordinates and dwell, one row each; neither unit, start nor cyclic. ``.json``: everything.
    ``.bag`` (ROS 1), ``.mcap`` and ``.db3`` (ROS 2): one ``nav_msgs/Path`` on the topic ``/waypoints``, in metres of
    the frame ``frame``, with ``plane``, ``height`` and ``scale`` as in ``fly``; of cyclic ones the first comes again at
    the end. A bag of ``.db3`` is a folder, with the name of ``path`` without its suffix; what is given back tells.

    Raises ``InputError`` for another suffix, and ``MissingExtraError`` where rosbags is not installed.
    """
    path = Path(path)
    if path.suffix == ".csv":
        with aside(path) as place, place.open("w", newline="", encoding="utf-8") as stream:
            write_table(waypoints, stream)
    elif path.suffix == ".json":
        with aside(path) as place:
            text = json.dumps(_record(waypoints), indent=1, allow_nan=False)
            place.write_text(text + "\n", encoding="utf-8")
    elif path.suffix in BAGS:
        return write_bag(waypoints, path, BAGS[path.suffix], frame, plane, height, scale, aside)
    else:
        raise InputError("path", found=repr(path.name), wanted="a name that ends in .csv, .json, .mcap, .db3 or .bag")
    return path


def read_waypoints(path: str | Path, *, units: str = "m", period: tuple[float, ...] = ()) -> Waypoints:
    """Read waypoints from ``.csv`` or ``.json``; a table says neither ``units`` nor ``period``.

    A table needs no more than the coordinates. Raises ``InputError`` for another suffix or what is no waypoint, and
    ``ReadError`` for a file that is damaged or of another kind.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".json"):
        raise InputError("path", found=repr(path.name), wanted="a name that ends in .csv or .json")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as problem:
        raise ReadError(str(path), found=str(problem), wanted="a file of waypoints") from None
    return read_table(path, text, units, period) if path.suffix == ".csv" else _from_record(path, text)


@contextmanager
def aside(path: Path) -> Iterator[Path]:
    """A name beside ``path`` to write to, which becomes ``path`` if all goes well; folders take a folder's place."""
    path.parent.mkdir(parents=True, exist_ok=True)
    made = path.with_name(f".{path.stem}.{secrets.token_hex(4)}{path.suffix}")
    try:
        yield made
        if path.is_dir() and made.is_dir():
            shutil.rmtree(path)
        made.replace(path)
    finally:
        if made.is_dir():
            shutil.rmtree(made, ignore_errors=True)
        else:
            with contextlib.suppress(FileNotFoundError):
                made.unlink()


def _record(waypoints: Waypoints) -> dict[str, Any]:
    return {
        "kind": KIND, "version": VERSION, "units": waypoints.units, "cyclic": waypoints.cyclic,
        "dimensions": list(waypoints.dimensions),
        "period": [None if np.isinf(length) else length for length in waypoints.period],
        "start": None if waypoints.start is None else waypoints.start.tolist(),
        "waypoints": [
            {"label": int(label), "name": name, "position": place.tolist(), "dwell": float(dwell), "turn": float(turn),
             "roundness": float(rounded)}
            for label, name, place, dwell, turn, rounded in zip(
                waypoints.labels, waypoints.names, waypoints.positions, waypoints.dwell, waypoints.turns,
                waypoints.roundness, strict=True,
            )
        ],
    }  # fmt: skip


def _from_record(path: Path, text: str) -> Waypoints:
    wanted = f"a file of kind {KIND!r}, version {VERSION}"
    try:
        record = json.loads(text)
    except json.JSONDecodeError as problem:
        raise ReadError(str(path), found=str(problem), wanted=wanted) from None
    kind = record.get("kind") if isinstance(record, dict) else None
    if kind != KIND or record.get("version") != VERSION:
        found = f"kind {kind!r}, version {record.get('version') if isinstance(record, dict) else None}"
        raise ReadError(str(path), found=found, wanted=wanted)
    try:
        rows = record["waypoints"]
        keys = ("name", "label", "dwell", "turn", "roundness")
        names, labels, dwell, turns, rounded = ([row[key] for row in rows] for key in keys)
        period = tuple(np.inf if length is None else float(length) for length in record["period"])
        return Waypoints(
            np.array([row["position"] for row in rows], float), tuple(names), labels, dwell, record["cyclic"],
            tuple(record["dimensions"]), record["units"], period, record["start"], turns, rounded,
        )  # fmt: skip
    except InputError:
        raise
    except (KeyError, TypeError, ValueError) as problem:
        raise ReadError(str(path), found=repr(problem), wanted=wanted) from None
