"""Ground truth in the CSV of EuRoC MAV and others (ASL): ``#timestamp [ns], p_RS_R_x [m], ..., q_RS_w [], ...``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.readers.csv import table
from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.layout import Layout, find_layout
from subgoal.demonstrations.readers.poses import Posing, posed
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import ReadError


def read_euroc(
    path: Any,
    *,
    pose: bool = False,
    plane: str | None = None,
    scale: float = 1.0,
    units: str = "m",
    clock: str = "refuse",
) -> Recording:
    """Read one trajectory of poses; times are seconds since the first, from whole nanoseconds.

    ``pose`` gives a quaternion (x, y, z, w) beside the position, ``plane`` two positions and an angle (``Posing``);
    by default states are positions. ``scale``, ``units``, ``clock`` and the errors are those of ``read_csv``;
    ``ReadError`` also for a quaternion without length.
    """
    how = Posing(pose, plane, scale, units, clock, time_scale=1e-9)
    path = plain_file(path)
    found = find_layout(path, separator=",", decimal=".")
    names = tuple(name.split("[")[0].strip() for name in found.names)
    wanted = _columns(path, names, how.turns)
    layout = Layout(found.encoding, ",", ".", found.skip, names)
    columns = table(path, layout, wanted)
    columns["timestamp"] = since_first(columns["timestamp"])
    return posed(path, columns, "timestamp", wanted[1:], how, source_of(path))


def since_first(stamps: NDArray[Any]) -> NDArray[Any]:
    """(M,) stamps less the first of them, in whole numbers as long as they are such; text is left as it is."""
    if stamps.dtype.kind in "iu" and stamps.size:
        first = int(stamps[0])
        return np.array([int(stamp) - first for stamp in stamps], dtype=np.float64)
    if stamps.dtype.kind == "f" and np.isfinite(stamps[:1]).all():
        return np.asarray(stamps - stamps[:1])
    return stamps


def _columns(path: Path, names: tuple[str, ...], turns: bool) -> tuple[str, ...]:
    """Names of the columns of time, x, y, z, and of the quaternion's x, y, z, w if those are wanted."""
    ends = [f"p_{axis}" for axis in "xyz"] + ([f"q_{axis}" for axis in "xyzw"] if turns else [])
    found = ["timestamp"]
    for end in ends:
        here = [name for name in names if name[:2] == end[:2] and name[-2:] == end[1:]]
        if len(here) != 1:
            raise ReadError(str(path), found=f"columns {', '.join(names[:20])}", wanted=f"one p_..._x and so on: {end}")
        found += here
    if names.count("timestamp") != 1:
        raise ReadError(str(path), found=f"columns {', '.join(names[:20])}", wanted="a comment line with timestamp")
    return tuple(found)
