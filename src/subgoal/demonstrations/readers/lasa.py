"""The LASA handwriting set: a MATLAB file with several demonstrations of one shape."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.columns import Treatment
from subgoal.demonstrations.readers.files import plain_file, source_of
from subgoal.demonstrations.readers.matlab import read_variable
from subgoal.demonstrations.recordings import join
from subgoal.demonstrations.records import Recording
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import ReadError


def read_lasa(path: Any, *, scale: float = 1.0, units: str = "mm") -> Recording:
    """Read ``demos``, each with ``pos`` (2, M) and ``t`` (M,), from a MATLAB file of version 5 to 7.

    ``scale`` multiplies the positions, ``units`` is their unit then. Raises ``ReadError`` if the file is torn, of
    version 7.3, or lacks these fields.
    """
    how = Treatment(scale=scale, units=units)
    path = plain_file(path)
    demos = read_variable(path, "demos")
    if not isinstance(demos, list):
        raise ReadError(str(path), where="demos", found="numbers", wanted="a cell or struct array")
    demos = [one for part in demos for one in (part if isinstance(part, list) else [part])]
    pieces = [_demo(path, k, demo) for k, demo in enumerate(demos)]
    if not pieces:
        raise ReadError(str(path), found="an empty 'demos'", wanted="at least one demonstration")
    scaled = [(name, places * how.scale, times) for name, places, times in pieces]
    return join(scaled, names=("x", "y"), units=how.units, source=source_of(path))


def _demo(path: Path, k: int, demo: Any) -> tuple[str, Floats, Floats]:
    """Name, positions (M, 2) and times (M,) of one demonstration."""
    fields = demo if isinstance(demo, dict) else {}
    places, times = fields.get("pos"), fields.get("t")
    if not isinstance(places, np.ndarray) or not isinstance(times, np.ndarray):
        raise ReadError(str(path), where=f"demos[{k}]", found=f"fields {list(fields)}", wanted="pos and t, numbers")
    if places.shape != (2, times.size) or times.size == 0:
        found = f"pos {places.shape}, t {times.shape}"
        raise ReadError(str(path), where=f"demos[{k}]", found=found, wanted="pos (2, M) and t (1, M)")
    return f"demo {k + 1}", places.T, times.ravel()
