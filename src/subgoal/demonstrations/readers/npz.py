"""NumPy archives, opened without pickle and only after the directory of the zip file was looked at."""

from __future__ import annotations

import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.readers.columns import Treatment, column_names
from subgoal.demonstrations.readers.files import check_unpacked, guarded, plain_file, source_of
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.errors import ReadError


def read_npz(
    path: Any,
    *,
    action: Sequence[str] | None = None,
    group: str | None = None,
    rate: float | None = None,
    scale: float = 1.0,
    units: str = "",
) -> Recording:
    """Read ``positions`` (M, d), ``times`` (M,) and ``offset`` (D+1,) from an archive.

    Without ``times``, samples are numbered within their trajectory (and divided by ``rate`` if given); without
    ``offset`` they are one trajectory. ``action`` names arrays (M, k) or (M,) of recorded actions, side by side.
    ``group`` names an array (D,) of whole numbers, the group of each trajectory. ``scale`` multiplies the positions,
    ``units`` is their unit then.

    Raises ``ReadError`` for pickled objects, bombs, torn files and arrays that do not fit each other.
    """
    how = Treatment(scale=scale, units=units, rate=rate)
    path = plain_file(path)
    named = () if action is None else column_names("action", action)
    arrays = load_arrays(path, ("positions", *named, *_one("group", group)), ("times", "offset"))
    count = len(np.atleast_1d(arrays["positions"]))
    offset = arrays.get("offset", np.array([0, count]))
    times, unit = arrays.get("times"), "s"
    if times is None:
        steps = np.arange(count, dtype=np.float64)
        with guarded(path, "an offset (D+1,) that fits the positions"):
            times = steps - np.repeat(steps[offset[:-1]], np.diff(offset))
        times, unit = (times, "sample") if how.rate is None else (times / how.rate, "s")
    with guarded(path, "real numbers"), np.errstate(over="ignore"):
        places = np.asarray(arrays["positions"], dtype=np.float64) * how.scale
    with guarded(path, "actions (M, k) or (M,), equally long"):
        actions = np.column_stack([arrays[name] for name in named]) if named else None
    return Recording(
        positions=places[:, None] if places.ndim == 1 else places, times=times, offset=offset,
        names=(), units=how.units, time_unit=unit, source=source_of(path), actions=actions,
        groups=_groups(path, arrays, group, np.size(offset) - 1),
    )  # fmt: skip


def read_pairs(path: Any, *, group: str | None = None, units: str = "") -> Demonstrations:
    """Read ready state-action pairs: ``states`` and ``actions``, and if they are there ``offset``, ``times``,
    ``final_states`` and ``truncated``, shaped as in ``Demonstrations``. Without ``offset`` the pairs are unordered.
    ``group`` as in ``read_npz``.

    Raises ``ReadError`` as ``read_npz`` does.
    """
    path = plain_file(path)
    optional = ("offset", "times", "final_states", "truncated")
    arrays = load_arrays(path, ("states", "actions", *_one("group", group)), optional)
    with guarded(path, "arrays of at least one dimension"):
        count = len(arrays["states"])
    groups = _groups(path, arrays, group, np.size(arrays["offset"]) - 1 if "offset" in arrays else count)
    fields = {name: arrays[name] for name in ("states", "actions", *optional) if name in arrays}
    return Demonstrations.from_arrays(**fields, units=units, source=source_of(path), groups=groups)


def _one(what: str, name: Any) -> tuple[str, ...]:
    return () if name is None else column_names(what, name)[:1]


def _groups(path: Path, arrays: dict[str, NDArray[Any]], name: str | None, count: int) -> tuple[str, ...]:
    """Names of the groups of ``count`` trajectories: the whole numbers of an array. ``ReadError`` for any other."""
    if name is None:
        return ()
    values = arrays[name]
    if values.shape != (count,) or values.dtype.kind not in "iu":
        found, wanted = f"{values.dtype} of shape {values.shape}", f"whole numbers of shape ({count},)"
        raise ReadError(str(path), where=f"array {name!r}", found=found, wanted=wanted)
    return tuple(str(value) for value in values.tolist())


def array_names(path: Path) -> tuple[str, ...]:
    """Names of the arrays in an archive. Raises ``ReadError`` if it is none or not to be trusted."""
    with guarded(path, "a zip archive of arrays"), zipfile.ZipFile(path) as archive:
        return tuple(member.filename.removesuffix(".npy") for member in _members(path, archive))


def load_arrays(path: Path, required: tuple[str, ...], optional: tuple[str, ...]) -> dict[str, NDArray[Any]]:
    """The named arrays, real numbers or truth values all of them."""
    found = array_names(path)
    for name in required:
        if name not in found:
            listed = ", ".join(map(repr, found[:30]))
            raise ReadError(str(path), where=f"array {name!r}", found=f"arrays {listed}", wanted="one of that name")
    with guarded(path, "arrays that are whole"), zipfile.ZipFile(path) as archive:
        return {name: _load(path, archive, name) for name in (*required, *optional) if name in found}


def _members(path: Path, archive: zipfile.ZipFile) -> list[zipfile.ZipInfo]:
    """The members, after a look at their names and sizes."""
    members = archive.infolist()
    check_unpacked(path, "all arrays", sum(m.file_size for m in members), sum(m.compress_size for m in members))
    names = [member.filename for member in members]
    for member in members:
        check_unpacked(path, member.filename, member.file_size, member.compress_size)
        if ".." in member.filename or member.filename.startswith(("/", "\\")) or ":" in member.filename:
            raise ReadError(str(path), where=repr(member.filename), found="a path", wanted="the name of an array")
        if names.count(member.filename) > 1:
            raise ReadError(str(path), where=repr(member.filename), found="the name twice", wanted="it once")
    return members


def _load(path: Path, archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """One array; its header must agree with its size before anything is allocated."""
    member = archive.getinfo(name if name in archive.namelist() else f"{name}.npy")
    with archive.open(member) as stream:
        version = np.lib.format.read_magic(stream)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[version]
        shape, _, dtype = read_header(stream)
        begin = stream.tell()
    if dtype.kind not in "biuf":
        raise ReadError(str(path), where=f"array {name!r}", found=f"type {dtype}", wanted="real numbers, no objects")
    size = dtype.itemsize
    for length in shape:
        size *= length
    if begin + size != member.file_size:
        found = f"shape {shape} of {dtype} in {member.file_size} bytes"
        raise ReadError(str(path), where=f"array {name!r}", found=found, wanted=f"{begin + size} bytes")
    with archive.open(member) as stream:
        return np.asarray(np.lib.format.read_array(stream, allow_pickle=False))
