"""A file at the door: it exists, is a plain file (or a bag's folder), is not empty, and has a checksum."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from subgoal.demonstrations.records import Source
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError

HEAD = 65536
"""Bytes looked at to find out what a file is."""
LARGEST = 4 * 2**30
"""Bytes that are unpacked at most."""
BAG_TOLD_BY = "metadata.yaml"
"""The file in the folder of a ROS 2 bag that says what is in it."""
HIGHEST_RATIO = 1000
"""Unpacked over packed size above which more than ``SMALL`` bytes are taken for a bomb."""
SMALL = 2**20


def plain_file(path: Any) -> Path:
    """``path`` as a Path of an existing, readable, non-empty plain file.

    Raises ``ReadError`` saying which of these fails, ``InputError`` if it is no path.
    """
    if not isinstance(path, (str, os.PathLike)) or "\0" in str(path):
        raise InputError("path", found=repr(path), wanted="the name of a file")
    place = Path(path)
    try:
        if not place.is_file():
            found = "a folder" if place.is_dir() else "something special" if place.exists() else "no such file"
            raise ReadError(str(path), found=found, wanted="a plain file")
        if place.stat().st_size == 0:
            raise ReadError(str(path), found="an empty file", wanted="data")
    except OSError as problem:
        raise ReadError(str(path), found=problem.strerror or str(problem), wanted="a readable file") from None
    return place


def bag_path(path: Any) -> Path:
    """``path`` as a Path of the folder of a ROS 2 bag, or of anything that ``plain_file`` takes."""
    if isinstance(path, (str, os.PathLike)) and "\0" not in str(path):
        try:
            if (Path(path) / BAG_TOLD_BY).is_file():
                return Path(path)
        except OSError:
            pass
    return plain_file(path)


def head(path: Path) -> bytes:
    """The first bytes of a file."""
    try:
        with path.open("rb") as stream:
            return stream.read(HEAD)
    except OSError as problem:
        raise ReadError(str(path), found=problem.strerror or str(problem), wanted="a readable file") from None


def check_unpacked(path: Path, what: str, unpacked: int, packed: int) -> None:
    """Raise ``ReadError`` if unpacking ``packed`` bytes into ``unpacked`` is more than a file of data asks for."""
    if unpacked > LARGEST or unpacked > max(SMALL, HIGHEST_RATIO * packed):
        found = f"{unpacked:,} bytes packed into {packed:,}"
        wanted = f"at most {LARGEST:,} bytes, and at most {HIGHEST_RATIO} for each one packed"
        raise ReadError(str(path), where=what, found=found, wanted=wanted)


def source_of(path: Path) -> Source:
    """Name and SHA-256 of a file."""
    with guarded(path, "a readable file"), path.open("rb") as stream:
        return Source(path.name, hashlib.file_digest(stream, "sha256").hexdigest())


def folder_source(folder: Path) -> Source:
    """Name of a folder, and SHA-256 of the names and checksums of its files."""
    with guarded(folder, "readable files"):
        inside = sorted(path for path in folder.iterdir() if path.is_file())
        told = "".join(f"{path.name} {source_of(path).checksum}\n" for path in inside)
    return Source(folder.name, hashlib.sha256(told.encode()).hexdigest())


@contextmanager
def guarded(path: Path, wanted: str) -> Iterator[None]:
    """Turn whatever a foreign parser raises on a broken file into ``ReadError``; our own errors pass."""
    try:
        yield
    except (InputError, MissingExtraError):
        raise
    except Exception as problem:
        told = " ".join(f"{type(problem).__name__}: {problem}".split())[:300]
        raise ReadError(str(path), found=told, wanted=wanted) from problem
