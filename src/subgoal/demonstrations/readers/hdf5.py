"""HDF5 files, read by a process of their own, which a damaged file may bring down without harm."""

from __future__ import annotations

import importlib.util
import io
import mmap
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.readers.files import guarded
from subgoal.runtime.errors import MissingExtraError, ReadError

HDF5_MAGIC = b"\x89HDF\r\n\x1a\n"
CHILD = "subgoal.demonstrations.readers.hdf5_child"
PATIENCE = 30.0
"""Seconds, beyond the child's own limit, after which it is ended."""


def is_pandas_table(path: Path) -> bool:
    """Whether pandas wrote this HDF5 file in its table form (looked up without opening it as HDF5)."""
    with (
        guarded(path, "a readable file"),
        path.open("rb") as stream,
        mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as view,
    ):
        return view.find(b"values_block_0_kind") >= 0


def read_hdf5(path: Path, wanted: str, required: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    """The arrays that ``hdf5_child.content`` finds in a file, all of ``required`` among them.

    Raises ``MissingExtraError`` without h5py, and ``ReadError`` where the file is damaged (also where it crashes the
    HDF5 library) or lacks one; ``wanted`` says what it should have been.
    """
    if importlib.util.find_spec("h5py") is None:
        raise MissingExtraError("h5py", "sleap")
    command = [sys.executable, "-P", "-m", CHILD, str(path.absolute())]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    patience = PATIENCE + path.stat().st_size / 1e7
    with guarded(path, wanted):
        child = subprocess.run(command, capture_output=True, timeout=patience, env=environment, check=False)
        if child.returncode != 0 or not child.stdout:
            told = f"damage that stopped the HDF5 library (exit {child.returncode})"
            raise ReadError(str(path), found=told, wanted=wanted)
        with np.load(io.BytesIO(child.stdout), allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    if "error" in arrays:
        raise ReadError(str(path), found=str(arrays["error"]), wanted=wanted)
    for name in required:
        if name not in arrays:
            raise ReadError(str(path), found=f"only {sorted(arrays)}", wanted=f"{name!r}: {wanted}")
    return arrays
