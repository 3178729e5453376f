"""Maps drawn in text: a character a cell, walls, free cells and tiles with a letter."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from subgoal.demonstrations.readers.files import guarded, plain_file
from subgoal.runtime.checks import Bools, Ints, copied, frozen
from subgoal.runtime.errors import InputError

WALLS = "#X"
FREE = " ."
Origin = Literal["lower", "upper"]


@dataclass(frozen=True, eq=False, repr=False)
class TextMap:
    """A map as it was read: where one can be, and the cells of each letter.

    Attributes
    ----------
    name:
        What the map is called; "" if it has no name.
    free:
        (height, width) booleans, ``free[y, x]``.
    tiles:
        The cells (M, 2) as (x, y) of each character that is neither wall nor free ground, in the order of states.
    origin:
        "lower": y upwards, the last row of the text is y = 0. "upper": y downwards, the first row is y = 0.

    ``GridWorld(map.free, discount, origin=map.origin)`` makes a world of it.
    """

    name: str
    free: Bools
    tiles: Mapping[str, Ints] = field(default_factory=dict)
    origin: Origin = "lower"

    def __post_init__(self) -> None:
        free = _checked(self.free, self.origin)
        object.__setattr__(self, "free", free)
        object.__setattr__(self, "tiles", {tile: _cells(tile, cells, free) for tile, cells in self.tiles.items()})

    def __repr__(self) -> str:
        height, width = self.free.shape
        tiles = "".join(sorted(self.tiles))
        return f"TextMap({self.name!r}: {width} × {height}, {int(self.free.sum())} free cells, tiles {tiles!r})"


class _Line(NamedTuple):
    number: int
    text: str


def read_map(source: Any, *, walls: str = WALLS, blocked: str = "", origin: Origin = "lower") -> TextMap:
    """Read one map without a name.

    Parameters
    ----------
    source:
        The text, or the name of a file that holds it (UTF-8). A string with a line break is text, any other names a
        file.
    walls:
        Characters one cannot be on, and that are of no interest.
    blocked:
        Tiles one cannot be on. Every other tile is free; so are " " and ".".
    origin:
        Whether y goes upwards ("lower") or downwards ("upper"), as in ``TextMap``.

    Raises
    ------
    InputError
        Nothing in it, more than one map, rows of different lengths, characters that cannot be seen: naming row and
        line. ``ReadError`` where the file cannot be read.
    """
    _check_kinds(walls, blocked)
    name, blocks = _blocks(source)
    if len(blocks) > 1:
        where = f"line {blocks[1][0].number}"
        raise InputError("map", where=where, found="a second map", wanted="one", hint="read_maps for maps with names")
    return _drawn(name, blocks[0], walls, blocked, origin)


def read_maps(
    source: Any, *, walls: str = WALLS, blocked: str = "", origin: Origin = "lower"
) -> dict[str, TextMap]:  # fmt: skip
    """Read maps that have names: the name on a line of its own, then the rows, then an empty line.

    Arguments and errors as for ``read_map``. Names must differ, and none may be what could be a row of its own map.
    """
    _check_kinds(walls, blocked)
    maps: dict[str, TextMap] = {}
    for first, *rows in _blocks(source)[1]:
        name = first.text.strip()
        if not name or not name.isprintable():
            raise InputError("map", where=_place("", first), found=repr(first.text), wanted="a name")
        if not rows:
            raise InputError("map", where=_place(name, first), found="no rows", wanted="rows below the name")
        if len(first.text) == len(rows[0].text) and set(first.text) <= {*walls, *FREE, *"".join(r.text for r in rows)}:
            wanted, hint = "a name that cannot be a row", "read_map for a map without a name"
            raise InputError("map", where=f"line {first.number}", found=repr(first.text), wanted=wanted, hint=hint)
        if name in maps:
            raise InputError("map", where=_place(name, first), found="the name twice", wanted="one map of a name")
        maps[name] = _drawn(name, rows, walls, blocked, origin)
    return maps


def print_map(
    free: Any, *, marks: Mapping[str, Any] | None = None, walls: str = WALLS, origin: Origin = "lower"
) -> str:  # fmt: skip
    """The map as text, a line a row: the first of ``walls`` where one cannot be, "." where one can.

    ``marks`` are characters and their cells (M, 2) as (x, y). ``read_map`` with the same ``walls`` and ``origin``
    reads the same map, if the marks that stand on walls are its ``blocked``.

    Raises
    ------
    InputError
        Cells outside, two marks on a cell, a mark that could be taken for something else, or one that stands on free
        cells and on walls.
    """
    table = _checked(free, origin)
    _check_kinds(walls, "")
    page = np.where(table, ".", walls[:1])
    taken = np.zeros(table.shape, bool)
    for mark, given in (marks or {}).items():
        if not isinstance(mark, str) or len(mark) != 1 or not mark.isprintable() or mark in walls + FREE:
            raise InputError("marks", found=repr(mark), wanted=f"one visible character, none of {walls + FREE!r}")
        x, y = _cells(mark, given, table).T
        here = np.zeros(table.shape, bool)
        here[y, x] = True
        if (here & taken).any():
            b, a = np.argwhere(here & taken)[0].tolist()
            raise InputError(
                "marks", where=f"cell ({a}, {b})", found=f"{mark!r} upon another", wanted="one mark a cell"
            )
        if table[here].any() and not table[here].all():
            raise InputError("marks", found=f"{mark!r} on free cells and on walls", wanted="two marks")
        page[here] = mark
        taken |= here
    rows = ["".join(row) for row in page.tolist()]
    return "".join(f"{row}\n" for row in (rows[::-1] if origin == "lower" else rows))


def _blocks(source: Any) -> tuple[str, list[list[_Line]]]:
    """Name of the file, and the lines between empty lines, each with its number from 1."""
    name, text = "", source
    if not isinstance(source, str) or (source and "\n" not in source):
        if not isinstance(source, (str, os.PathLike)):
            raise InputError("map", found=type(source).__name__, wanted="text, or the name of a file")
        path = plain_file(source)
        name = Path(path).stem
        with guarded(path, "text in UTF-8"):
            text = path.read_text(encoding="utf-8-sig")
    blocks: list[list[_Line]] = [[]]
    for number, line in enumerate(text.replace("\r\n", "\n").split("\n"), start=1):
        if line:
            blocks[-1].append(_Line(number, line))
        elif blocks[-1]:
            blocks.append([])
    blocks = [block for block in blocks if block]
    if not blocks:
        raise InputError("map", found="no rows", wanted="one at least")
    return name, blocks


def _drawn(name: str, rows: list[_Line], walls: str, blocked: str, origin: Origin) -> TextMap:
    """The map of these rows, top row first."""
    for k, row in enumerate(rows):
        if len(row.text) != len(rows[0].text):
            found, wanted = f"{len(row.text)} characters", f"{len(rows[0].text)}, as in the first row"
            raise InputError("map", where=_place(name, row, k), found=found, wanted=wanted)
        if not row.text.isprintable():
            found = repr(next(character for character in row.text if not character.isprintable()))
            raise InputError("map", where=_place(name, row, k), found=found, wanted="characters that can be seen")
    page = np.array([list(row.text) for row in rows])
    page = page if origin == "upper" else page[::-1]
    tiles = sorted(set(page.ravel().tolist()) - set(walls + FREE))
    cells = {tile: np.argwhere(page == tile)[:, ::-1] for tile in tiles}
    return TextMap(name, ~np.isin(page, list(walls + blocked)), cells, origin)


def _check_kinds(walls: str, blocked: str) -> None:
    for what, given, taken in (("walls", walls, FREE), ("blocked", blocked, f"{walls}{FREE}")):
        if not isinstance(given, str) or set(given) & set(taken):
            raise InputError(what, found=repr(given), wanted=f"characters, none of {taken!r}")
    if not walls:
        raise InputError("walls", found="none", wanted="one character at least")


def _checked(free: Any, origin: Any) -> Bools:
    table = copied("free", free)
    if table.dtype != bool or table.ndim != 2 or not table.size:
        raise InputError("free", found=f"{table.dtype} of shape {table.shape}", wanted="booleans (height, width)")
    if origin not in ("lower", "upper"):
        raise InputError("origin", found=repr(origin), wanted="'lower' or 'upper'")
    return np.asarray(frozen(table))


def _cells(tile: str, given: Any, free: Bools) -> Ints:
    """``given`` as cells (M, 2) inside the map."""
    cells = copied("cells", given)
    cells = cells if cells.size else np.zeros((0, 2), np.int64)
    if cells.dtype.kind not in "iu" or cells.ndim != 2 or cells.shape[1] != 2:
        found = f"{cells.dtype} of shape {cells.shape}"
        raise InputError("cells", where=f"tile {tile!r}", found=found, wanted="integers (M, 2) of (x, y)")
    height, width = free.shape
    outside = ((cells < 0) | (cells >= (width, height))).any(axis=1)
    if outside.any():
        found = str(tuple(cells[np.argmax(outside)].tolist()))
        raise InputError("cells", where=f"tile {tile!r}", found=found, wanted=f"a cell of {width} × {height}")
    return np.asarray(frozen(cells.astype(np.int64)))


def _place(name: str, line: _Line, row: int | None = None) -> str:
    told = [f"layout {name!r}"] if name else []
    return ", ".join([*told, *([] if row is None else [f"row {row}"]), f"line {line.number}"])
