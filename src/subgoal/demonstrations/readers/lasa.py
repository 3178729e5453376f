"""The LASA handwriting set: a MATLAB file with several demonstrations of one shape."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.columns import Treatment
from subgoal.demonstrations.readers.files import guarded, plain_file, source_of
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
    with guarded(path, "a MATLAB file (version 5 to 7) with the variable 'demos'"):
        from scipy.io import loadmat

        content = loadmat(path, squeeze_me=True, struct_as_record=False, variable_names=["demos"])
    if "demos" not in content:
        raise ReadError(str(path), found="no variable 'demos'", wanted="the demonstrations of one shape")
    demos = np.atleast_1d(content["demos"]).ravel()
    pieces = [_demo(path, k, demo) for k, demo in enumerate(demos)]
    if not pieces:
        raise ReadError(str(path), found="an empty 'demos'", wanted="at least one demonstration")
    scaled = [(name, places * how.scale, times) for name, places, times in pieces]
    return join(scaled, names=("x", "y"), units=how.units, source=source_of(path))


def _demo(path: Path, k: int, demo: Any) -> tuple[str, Floats, Floats]:
    """Name, positions (M, 2) and times (M,) of one demonstration."""
    with guarded(path, f"positions (2, M) and times (M,) in demos[{k}]"):
        places = np.atleast_2d(np.asarray(demo.pos)).T
        times = np.atleast_1d(np.asarray(demo.t))
    if places.shape != (times.size, 2) or times.ndim != 1 or {places.dtype.kind, times.dtype.kind} - set("iuf"):
        raise ReadError(
            str(path), where=f"demos[{k}]", found=f"pos {places.T.shape}, t {times.shape}", wanted="(2, M) and (M,)"
        )
    return f"demo {k + 1}", places.astype(np.float64), times.astype(np.float64)
