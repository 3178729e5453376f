"""Files of this library: npz without pickle, with a JSON header and a checksum, written aside and renamed."""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import secrets
import struct
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from subgoal.runtime.errors import StorageError

FORMAT = 1
LARGEST_ARCHIVE = 2**34
LARGEST_RATIO = 1000
Arrays = Mapping[str, NDArray[Any]]
UNREADABLE = (
    OSError, ValueError, KeyError, AttributeError, EOFError, RuntimeError, MemoryError, OverflowError, SyntaxError,
    TypeError, struct.error, zlib.error, zipfile.BadZipFile,
)  # fmt: skip
"""What NumPy, zipfile and json raise on files that are torn, foreign or made to hurt."""


def previous(path: Path) -> Path:
    """Where ``write_archive`` keeps the file that it replaces."""
    return path.with_name(path.name + ".previous")


def write_archive(path: Path, kind: str, header: Mapping[str, Any], arrays: Arrays, *, keep_previous: bool) -> None:
    """Write ``arrays`` and a JSON ``header``; a reader finds the old file or the new one, never half of one."""
    text = json.dumps({"kind": kind, "format": FORMAT, **header})
    packed = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    seal = np.frombuffer(_digest(text, packed), np.uint8)
    aside = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
    try:
        with aside.open("wb") as stream:
            members: dict[str, Any] = {**packed, "header": np.frombuffer(text.encode(), np.uint8), "seal": seal}
            np.savez(stream, **members)
            stream.flush()
            os.fsync(stream.fileno())
        if keep_previous and path.exists():
            path.replace(previous(path))
        aside.replace(path)
    except OSError as problem:
        raise StorageError(f"{kind} file", where=str(path), found=str(problem), wanted="a place to write to") from None
    finally:
        with contextlib.suppress(OSError):
            aside.unlink()


def read_archive(path: Path, kind: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Header and arrays of a file that ``write_archive`` wrote.

    Raises ``StorageError`` for a missing, torn, foreign, oversized or newer file.
    """
    try:
        check_zip(path)
        _check_stored(path)
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        text = arrays.pop("header").tobytes().decode()
        seal = arrays.pop("seal").tobytes()
        header = json.loads(text)
    except StorageError:
        raise
    except FileNotFoundError:
        raise StorageError(f"{kind} file", where=str(path), found="no such file", wanted="an existing file") from None
    except UNREADABLE as problem:
        raise StorageError(f"{kind} file", where=str(path), found=f"a torn or foreign file ({problem})",
                           wanted="a whole file written by subgoal") from None  # fmt: skip
    if not isinstance(header, dict):
        header = {}
    if header.get("kind") != kind or header.get("format") != FORMAT:
        found = f"kind {header.get('kind')!r}, format {header.get('format')!r}"
        raise StorageError(f"{kind} file", where=str(path), found=found, wanted=f"kind {kind!r}, format {FORMAT}")
    if seal != _digest(text, arrays):
        raise StorageError(
            f"{kind} file", where=str(path), found="a wrong checksum", wanted="the one it was written with"
        )
    return header, arrays


def check_zip(path: Path) -> None:
    """Refuse an npz that would unpack to more than it should, before anything is unpacked."""
    with zipfile.ZipFile(path) as archive:
        members = archive.infolist()
    unpacked, packed = sum(m.file_size for m in members), sum(m.compress_size for m in members)
    if unpacked > LARGEST_ARCHIVE or unpacked > LARGEST_RATIO * max(packed, 2**20):
        raise StorageError("npz file", where=str(path), found=f"{unpacked:,} bytes once unpacked from {packed:,}",
                           wanted=f"at most {LARGEST_ARCHIVE:,} bytes and a ratio of {LARGEST_RATIO}")  # fmt: skip
    for member in members:
        if member.filename.startswith(("/", "\\")) or ".." in Path(member.filename).parts:
            raise StorageError("npz file", where=str(path), found=f"a member named {member.filename!r}",
                               wanted="plain names")  # fmt: skip


def _check_stored(path: Path) -> None:
    """Refuse what ``write_archive`` never writes: packed members, and arrays larger than the bytes that hold them."""
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            if member.compress_type != zipfile.ZIP_STORED or member.file_size > path.stat().st_size:
                raise StorageError("npz file", where=str(path), found=f"a packed member {member.filename!r}",
                                   wanted="members as write_archive stores them")  # fmt: skip
            with archive.open(member) as stream:
                shape, dtype = _array_header(stream)
                if math.prod(shape) * dtype.itemsize > member.file_size:
                    raise ValueError(f"{member.filename} is shorter than its shape {shape}")


def _array_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any]]:
    version = np.lib.format.read_magic(stream)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    shape, _, dtype = read(stream)
    return shape, dtype


def digest_arrays(*arrays: Any) -> str:
    """A short checksum of arrays, for provenance: sixteen hexadecimal digits of SHA-256."""
    return _digest("", {str(k): np.ascontiguousarray(array) for k, array in enumerate(arrays)}).hex()[:16]


def _digest(text: str, arrays: Arrays) -> bytes:
    seal = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        array = arrays[name]
        seal.update(f"{name}{array.dtype.str}{array.shape}".encode())
        seal.update(np.ascontiguousarray(array).tobytes())
    return seal.digest()
