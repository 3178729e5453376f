"""One file per format; ``read_recording`` chooses among them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from subgoal.demonstrations.readers.csv import read_csv
from subgoal.demonstrations.readers.deeplabcut import read_deeplabcut
from subgoal.demonstrations.readers.detect import find_format
from subgoal.demonstrations.readers.edinburgh import read_edinburgh
from subgoal.demonstrations.readers.euroc import read_euroc
from subgoal.demonstrations.readers.files import bag_path
from subgoal.demonstrations.readers.labyrinth import read_labyrinth
from subgoal.demonstrations.readers.lasa import read_lasa
from subgoal.demonstrations.readers.npz import read_npz, read_pairs
from subgoal.demonstrations.readers.parquet import read_parquet
from subgoal.demonstrations.readers.rosbag import read_rosbag
from subgoal.demonstrations.readers.sleap import read_sleap
from subgoal.demonstrations.readers.tum import read_tum
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.errors import InputError

RECORDINGS: Mapping[str, Callable[..., Recording]] = {
    "csv": read_csv,
    "parquet": read_parquet,
    "npz": read_npz,
    "edinburgh": read_edinburgh,
    "tum": read_tum,
    "euroc": read_euroc,
    "rosbag": read_rosbag,
    "lasa": read_lasa,
    "deeplabcut": read_deeplabcut,
    "sleap": read_sleap,
}
"""Formats that hold positions over time."""

PAIRS: Mapping[str, Callable[..., Demonstrations]] = {
    "pairs": read_pairs,
    "labyrinth": read_labyrinth,
}
"""Formats that hold states and actions already."""


def read_recording(path: Any, *, format: str | None = None, **options: Any) -> Recording:
    """Read positions over time from a file, by the reader for its format.

    Parameters
    ----------
    path:
        The file.
    format:
        A key of ``RECORDINGS``; found out from the name and the first bytes if not given.
    options:
        Those of the reader, such as ``position=["x", "y"]`` for "csv".

    Raises
    ------
    ReadError
        The file is missing, torn, or not of its format.
    InputError
        An unknown format or option, or a file of ready pairs, which ``read`` reads.
    """
    chosen = format_of(path, format)
    if chosen in PAIRS:
        raise InputError("format", found=f"{chosen!r}, ready pairs", wanted="positions over time", hint="read(path)")
    return RECORDINGS[chosen](path, **known_options(chosen, options))


def format_of(path: Any, format: str | None = None) -> str:
    """The format given, checked, or the one found out."""
    known = [*RECORDINGS, *PAIRS]
    if format is None:
        return find_format(bag_path(path))
    if format not in known:
        raise InputError("format", found=repr(format), wanted=", ".join(map(repr, known)))
    return format


def accepted(reader: Callable[..., Any]) -> set[str]:
    """Names of the options a reader takes."""
    return set(inspect.signature(reader).parameters) - {"path"}


def known_options(format: str, options: dict[str, Any]) -> dict[str, Any]:
    """``options``, after checking that the reader of the format takes all of them."""
    known = accepted({**RECORDINGS, **PAIRS}[format])
    unknown = sorted(set(options) - known)
    if unknown:
        raise InputError("options", found=_written(unknown), wanted=f"those of {format!r} files: {_written(known)}")
    return options


def _written(names: Iterable[str]) -> str:
    return ", ".join(f"{name}=" for name in sorted(names))


__all__ = ["PAIRS", "RECORDINGS", "format_of", "read_recording"]
