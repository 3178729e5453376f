"""Trajectory text of the TUM RGB-D benchmark: timestamp tx ty tz qx qy qz qw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from subgoal.demonstrations.readers.columns import assemble, choose
from subgoal.demonstrations.readers.csv import table
from subgoal.demonstrations.readers.euroc import since_first
from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.layout import Layout, find_layout
from subgoal.demonstrations.readers.poses import Posing, posed
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import InputError, ReadError

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")


def read_tum(
    path: Any,
    *,
    position: Sequence[str] = COLUMNS[1:4],
    pose: bool = False,
    plane: str | None = None,
    scale: float = 1.0,
    units: str = "m",
    clock: str = "refuse",
) -> Recording:
    """Read one trajectory of poses; ``position`` chooses among tx ty tz qx qy qz qw.

    ``pose`` gives positions and a unit quaternion, ``plane`` two positions and an angle (``Posing``); both need the
    position as it is by default. Times are seconds since the first pose. ``scale``, ``units``, ``clock`` and the errors
    are those of ``read_csv``; ``ReadError`` also for a quaternion without length.
    """
    how = Posing(pose, plane, scale, units, clock)
    path = plain_file(path)
    choice = choose(path, COLUMNS, position, "timestamp", None, None, None, None)
    if how.turns and choice.position != COLUMNS[1:4]:
        raise InputError("position", found=repr(position), wanted="none beside pose= and plane=")
    found = find_layout(path, separator=" ", decimal=".")
    if len(found.names) != len(COLUMNS):
        raise ReadError(str(path), found=f"{len(found.names)} columns", wanted=f"{len(COLUMNS)}: {' '.join(COLUMNS)}")
    if found.headed and found.names != COLUMNS:
        raise ReadError(str(path), found=f"a header line {found.names}", wanted="numbers, or comments with #")
    layout = Layout(found.encoding, " ", ".", found.skip, COLUMNS)
    columns = table(path, layout, COLUMNS if how.turns else choice.all)
    columns["timestamp"] = since_first(columns["timestamp"])
    if how.turns:
        return posed(path, columns, "timestamp", COLUMNS[1:], how, source_of(path))
    return assemble(path, columns, choice, how.treatment(scale), source_of(path))
