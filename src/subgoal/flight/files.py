"""Waypoints on disk: a table, a versioned file with units, or a path for ROS; written aside and renamed."""

from __future__ import annotations

import contextlib
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from subgoal.flight.bags import write_bag
from subgoal.flight.json_file import read_record, write_record
from subgoal.flight.tables import read_table, write_table
from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.errors import InputError, ReadError

BAGS = {".bag": "bag", ".mcap": "mcap", ".db3": "db3"}


def write_waypoints(
    waypoints: Waypoints, path: str | Path, *, frame: str = "map", plane: str | None = None, height: float = 1.0,
    scale: float | None = None,
) -> Path:  # fmt: skip
    """Write waypoints by the suffix of ``path``, and give back where they lie.

    ``.csv``: label, name, coordinates, dwell and unit, one row each; neither start, turns nor whether the first comes
    again. ``.json``: everything.
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
            place.write_text(write_record(waypoints), encoding="utf-8")
    elif path.suffix in BAGS:
        return write_bag(waypoints, path, BAGS[path.suffix], frame, plane, height, scale, aside)
    else:
        raise InputError("path", found=repr(path.name), wanted="a name that ends in .csv, .json, .mcap, .db3 or .bag")
    return path


def read_waypoints(path: str | Path, *, units: str | None = None, period: tuple[float, ...] = ()) -> Waypoints:
    """Read waypoints from ``.csv`` or ``.json``; ``units`` and ``period`` are for a table.

    A table needs no more than the coordinates; without a column "unit" and without ``units`` they are in metres. Raises
    ``InputError`` for another suffix or what is no waypoint, and ``ReadError`` for a file that is damaged or of another
    kind.
    """
    path = Path(path)
    if path.suffix not in (".csv", ".json"):
        raise InputError("path", found=repr(path.name), wanted="a name that ends in .csv or .json")
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as problem:
        raise ReadError(str(path), found=str(problem), wanted="a file of waypoints") from None
    return read_table(path, text, units, period) if path.suffix == ".csv" else read_record(path, text)


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
