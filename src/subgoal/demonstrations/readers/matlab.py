"""MATLAB files of versions 5 to 7: numbers, cells and structs, every length checked before it is believed.

A reader of its own, because a damaged file can crash the process inside the compiled reader of SciPy. Layout after
"MAT-File Format" (MathWorks): a header of 128 bytes, then elements of an 8-byte tag (type, size) and a body.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.readers.files import check_unpacked, guarded
from subgoal.runtime.errors import ReadError

NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
MATRIX, COMPRESSED = 14, 15
CELL, STRUCT = 1, 2
NUMERIC_CLASSES = range(6, 16)
COMPLEX = 0x0800
DEEPEST = 20


class _TornError(ValueError):
    """A length or type in the file cannot be right."""


@dataclass
class _Cursor:
    """A place in a run of elements; ``order`` is "<" or ">"."""

    data: bytes
    order: str
    at: int = 0

    def element(self) -> tuple[int, bytes]:
        """Type and body of the element here; moves past it and its padding."""
        if self.at + 8 > len(self.data):
            raise _TornError("the file ends inside a tag")
        kind, size = struct.unpack_from(self.order + "II", self.data, self.at)
        begin = self.at + 8
        if kind >> 16:
            kind, size, begin = kind & 0xFFFF, kind >> 16, self.at + 4
            if size > 4:
                raise _TornError(f"a short element of {size} bytes")
            self.at += 8
        else:
            self.at = begin + size + (-size % 8 if kind != COMPRESSED else 0)
        if begin + size > len(self.data):
            raise _TornError(f"an element of {size} bytes where {len(self.data) - begin} are left")
        return kind, self.data[begin : begin + size]

    def numbers(self) -> np.ndarray[Any, Any]:
        """The element here as a flat array."""
        kind, body = self.element()
        if kind not in NUMBERS or len(body) % int(NUMBERS[kind][1]):
            raise _TornError(f"{len(body)} bytes of type {kind} where numbers belong")
        return np.frombuffer(body, self.order + NUMBERS[kind])


def read_variable(path: Path, wanted: str) -> Any:
    """The variable of that name: an array, a list of values for a cell, a list of dictionaries for a struct.

    Anything else inside (text, sparse matrices, functions) is None. Raises ``ReadError`` if the file is torn, of
    another version, or has no such variable.
    """
    with guarded(path, f"a MATLAB file of version 5 to 7 with the variable {wanted!r}"):
        content = path.read_bytes()
        order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
        if order is None or content[124:126] not in (b"\x00\x01", b"\x01\x00"):
            raise ReadError(str(path), found="another header", wanted="a MATLAB file of version 5 to 7",
                            hint="save(..., '-v7')")  # fmt: skip
        found = []
        for body in _variables(path, _Cursor(content, order, 128)):
            name, value = _matrix(_Cursor(body, order), wanted, 0)
            if name == wanted:
                return value
            found.append(name)
    raise ReadError(str(path), found=f"variables {found[:20]}", wanted=f"the variable {wanted!r}")


def _variables(path: Path, cursor: _Cursor) -> Iterator[bytes]:
    """Bodies of the matrices at the top of the file, unpacked."""
    while cursor.at < len(cursor.data):
        kind, body = cursor.element()
        if kind == COMPRESSED:
            unpacker = zlib.decompressobj()
            size = struct.unpack(cursor.order + "I", unpacker.decompress(body, 8)[4:8])[0]
            check_unpacked(path, "a variable", size, len(body))
            inner = unpacker.decompress(unpacker.unconsumed_tail, size)
            if len(inner) != size:
                raise _TornError(f"{len(inner)} bytes unpacked where {size} are announced")
            yield inner
        elif kind == MATRIX:
            yield body


def _matrix(cursor: _Cursor, wanted: str | None, depth: int) -> tuple[str, Any]:
    """Name and value of a matrix; the value is left out unless the name is ``wanted`` (None: any)."""
    if not cursor.data:
        return "", np.empty((0, 0))
    if depth > DEEPEST:
        raise _TornError(f"more than {DEEPEST} levels")
    flags = cursor.numbers()
    shape = [int(length) for length in cursor.numbers()]
    name = cursor.element()[1].decode("latin-1")
    if flags.size != 2 or not shape or min(shape) < 0:
        raise _TornError(f"flags {flags}, shape {shape}")
    if wanted is not None and name != wanted:
        return name, None
    count, kind = 1, int(flags[0]) & 0xFF
    for length in shape:
        count *= length
    if kind in NUMERIC_CLASSES and not int(flags[0]) & COMPLEX:
        values = cursor.numbers()
        if values.size != count:
            raise _TornError(f"{values.size} numbers for shape {shape}")
        return name, values.astype(np.float64).reshape(shape, order="F")
    if kind == CELL:
        return name, [_inner(cursor, depth) for _ in _counted(count, cursor)]
    if kind == STRUCT:
        fields = _field_names(cursor)
        return name, [{field: _inner(cursor, depth) for field in fields} for _ in _counted(count, cursor)]
    return name, None


def _counted(count: int, cursor: _Cursor) -> range:
    """Range of a count, after checking that so many parts of 8 bytes could follow."""
    if count > len(cursor.data) // 8:
        raise _TornError(f"{count} parts in {len(cursor.data)} bytes")
    return range(count)


def _inner(cursor: _Cursor, depth: int) -> Any:
    kind, body = cursor.element()
    if kind != MATRIX:
        raise _TornError(f"type {kind} where a matrix belongs")
    return _matrix(_Cursor(body, cursor.order), None, depth + 1)[1]


def _field_names(cursor: _Cursor) -> list[str]:
    width = cursor.numbers()
    names = cursor.element()[1]
    if width.size != 1 or int(width[0]) < 1 or len(names) % int(width[0]):
        raise _TornError(f"field names of {len(names)} bytes, {width} each")
    size = int(width[0])
    return [names[k : k + size].split(b"\0")[0].decode("latin-1") for k in range(0, len(names), size)]
