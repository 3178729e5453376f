"""Predictions of DeepLabCut: CSV with three or four header lines, or the HDF5 file beside it."""

from __future__ import annotations

import csv
import io
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.columns import numbers
from subgoal.demonstrations.readers.csv import table
from subgoal.demonstrations.readers.files import guarded, head, plain_file, source_of
from subgoal.demonstrations.readers.hdf5 import HDF5_MAGIC, read_hdf5
from subgoal.demonstrations.readers.layout import Layout
from subgoal.demonstrations.readers.tracking import Tracking, animals
from subgoal.demonstrations.records import Recording
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import ReadError, data_row

Column = tuple[str, str, str]
"""Animal ("" if the file knows only one), body part, and x, y or likelihood."""


def read_deeplabcut(
    path: Any,
    *,
    bodypart: str | None = None,
    min_likelihood: float = 0.6,
    max_gap: float | None = None,
    rate: float | None = None,
    scale: float = 1.0,
    units: str = "px",
) -> Recording:
    """Read the header lines scorer, [individuals], bodyparts, coords and x, y, likelihood of every frame.

    Each animal is a trajectory, cut at long gaps; the options are described in ``Tracking``.

    Raises ``ReadError`` for a file that is no such table, ``InputError`` for a body part that is not there, and for
    the HDF5 form ``MissingExtraError`` without h5py.
    """
    how = Tracking(bodypart, min_likelihood, max_gap, rate, scale, units)
    path = plain_file(path)
    frames, labels, values = _from_hdf5(path) if head(path).startswith(HDF5_MAGIC) else _from_csv(path)
    if len(frames) > 1 and not (np.diff(frames) > 0).all():
        row = int(np.argmax(~(np.diff(frames) > 0))) + 1
        raise ReadError(str(path), where=data_row(row), found=frames[row], wanted="frame numbers that increase")
    part = how.choose_bodypart(path, [column[1] for column in labels])
    if len(set(labels)) != len(labels):
        raise ReadError(str(path), found="a body part and coordinate twice", wanted="each once")
    tracks = []
    for animal in dict.fromkeys(column[0] for column in labels if column[1] == part):
        at = [(animal, part, coordinate) for coordinate in ("x", "y", "likelihood")]
        absent = [column[2] for column in at if column not in labels]
        if absent:
            raise ReadError(str(path), where=f"body part {part!r}", found=f"no {absent[0]}", wanted="x, y, likelihood")
        x, y, likelihood = (values[:, labels.index(column)] for column in at)
        tracks.append((animal or "animal", np.stack([x, y], axis=1), likelihood, frames))
    return animals(path, tracks, how, source_of(path))


def _from_csv(path: Path) -> tuple[Floats, list[Column], Floats]:
    """Frames (F,), what each column is, values (F, columns)."""
    with guarded(path, "a table with header lines"), path.open(encoding="utf-8", newline="") as stream:
        lines = [line for line, _ in zip(csv.reader(stream), range(4), strict=False)]
    keys = [line[0] if line else "" for line in lines]
    depth = keys.index("coords") + 1 if "coords" in keys else 0
    if keys[:depth] not in (["scorer", "bodyparts", "coords"], ["scorer", "individuals", "bodyparts", "coords"]):
        raise ReadError(str(path), found=f"lines {keys}", wanted="scorer, [individuals], bodyparts, coords")
    count = len(lines[0])
    if {len(line) for line in lines[:depth]} != {count} or count < 2:
        raise ReadError(str(path), found="header lines of different length", wanted="one label a column")
    layout = Layout("utf-8", ",", ".", depth, tuple(map(str, range(count))))
    cells = table(path, layout, layout.names)
    values = np.stack([numbers(path, name, cells[name]) for name in layout.names], axis=1)
    if np.isnan(values[:, 0]).any():
        raise ReadError(
            str(path), where=data_row(int(np.argmax(np.isnan(values[:, 0])))), found="no frame number", wanted="one"
        )
    return values[:, 0], _labels(path, list(zip(*(line[1:] for line in lines[:depth]), strict=True))), values[:, 1:]


def _from_hdf5(path: Path) -> tuple[Floats, list[Column], Floats]:
    """As ``_from_csv``, from a table written by pandas."""
    told = "a table of DeepLabCut written by pandas"
    arrays = read_hdf5(path, told, ("fields", "index", "values_block_0", "labels"))
    wanted = ["index", "values_block_0"]
    if arrays["fields"].tolist() != wanted or arrays["index"].dtype.kind not in "iu":
        found = f"fields {arrays['fields'].tolist()}"
        raise ReadError(str(path), found=found, wanted=f"{wanted}", hint="the CSV file instead")
    with guarded(path, told):
        values = np.asarray(arrays["values_block_0"], dtype=np.float64)
        frames = np.asarray(arrays["index"], dtype=np.float64)
        labels = _PlainUnpickler(io.BytesIO(arrays["labels"].tobytes())).load()
        columns = _labels(path, [tuple(label)[:5] for label in labels])
    if values.ndim != 2 or values.shape[1] != len(columns):
        raise ReadError(str(path), found=f"{len(columns)} labels, shape {values.shape}", wanted="a label a column")
    if np.isinf(values).any():
        raise ReadError(str(path), found="an infinite value", wanted="finite numbers")
    return frames, columns, values


def _labels(path: Path, headers: Sequence[tuple[Any, ...]]) -> list[Column]:
    """Header entries (scorer, [animal], body part, coordinate) without the scorer."""
    if any(len(header) not in (3, 4) or not all(isinstance(h, str) for h in header) for header in headers):
        raise ReadError(str(path), found="labels of another kind", wanted="scorer, [individuals], bodyparts, coords")
    return [(header[1] if len(header) == 4 else "", header[-2], header[-1]) for header in headers]


class _PlainUnpickler(pickle.Unpickler):
    """Lists, tuples, text and numbers only: no class or function is ever looked up, so none can be run."""

    def find_class(self, module: str, name: str) -> Any:
        """Refuse every class."""
        raise pickle.UnpicklingError(f"{module}.{name} is refused")

    def persistent_load(self, pid: Any) -> Any:
        """Refuse every outside reference."""
        raise pickle.UnpicklingError("outside references are refused")
