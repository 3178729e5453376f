"""Trajectory text of the TUM RGB-D benchmark: timestamp tx ty tz qx qy qz qw."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.columns import Treatment, assemble, choose
from subgoal.demonstrations.readers.csv import table
from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.layout import Layout, find_layout
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import ReadError

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")


def read_tum(
    path: Any,
    *,
    position: Sequence[str] = ("tx", "ty", "tz"),
    scale: float = 1.0,
    units: str = "m",
    clock: str = "refuse",
) -> Recording:
    """Read one trajectory of poses; ``position`` chooses among tx ty tz qx qy qz qw.

    Times are seconds since the first pose. ``scale``, ``units``, ``clock`` and the errors are those of ``read_csv``.
    """
    how = Treatment(scale=scale, units=units, clock=clock)
    path = plain_file(path)
    choice = choose(path, COLUMNS, position, "timestamp", None, None, None, None)
    found = find_layout(path, separator=" ", decimal=".")
    if len(found.names) != len(COLUMNS):
        raise ReadError(str(path), found=f"{len(found.names)} columns", wanted=f"{len(COLUMNS)}: {' '.join(COLUMNS)}")
    if found.headed and found.names != COLUMNS:
        raise ReadError(str(path), found=f"a header line {found.names}", wanted="numbers, or comments with #")
    layout = Layout(found.encoding, " ", ".", found.skip, COLUMNS)
    columns = table(path, layout, choice.all)
    first = columns["timestamp"][:1]
    if first.dtype.kind in "iuf" and np.isfinite(first).all():
        columns["timestamp"] = columns["timestamp"] - first
    return assemble(path, columns, choice, how, source_of(path))
