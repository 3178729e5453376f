"""Waypoints as a table of text: label, name, coordinates and dwell, one row each."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.errors import ReadError

LABEL, NAME, DWELL, UNIT = "label", "name", "dwell", "unit"
OWN = (LABEL, NAME, DWELL, UNIT)
"""Columns beside the coordinates."""
MOST_LABEL = 2**31
Line = tuple[int, dict[str, str]]
"""Number in the file, from 1, and cells by column."""


def write_table(waypoints: Waypoints, stream: Any) -> None:
    """A header and a row for each waypoint."""
    table = csv.writer(stream, lineterminator="\n")
    unit = [waypoints.units] if waypoints.units else []
    table.writerow([LABEL, NAME, *waypoints.dimensions, DWELL, *([UNIT] if unit else [])])
    rows = zip(waypoints.labels.tolist(), waypoints.names, waypoints.positions, waypoints.dwell.tolist(), strict=True)
    for label, name, place, dwell in rows:
        table.writerow([label, name, *map(repr, place.tolist()), repr(dwell), *unit])


def read_table(path: Path, text: str, units: str | None, period: tuple[float, ...]) -> Waypoints:
    """The waypoints of ``text``, the content of ``path``; ``ReadError`` names the line at fault.

    ``units`` None: those of the column "unit", metres where there is none.
    """
    columns, lines = _lines(path, text)
    names = tuple(name for name in columns if name not in OWN)
    if not lines or not names:
        raise ReadError(str(path), found="no row" if names else "no column of coordinates",
                        wanted="a header, and a row for each waypoint")  # fmt: skip
    more: dict[str, Any] = {}
    if LABEL in columns:
        more["labels"] = [_label(path, line) for line in lines]
    if NAME in columns:
        more["names"] = tuple(cells[NAME] for _, cells in lines)
    if DWELL in columns:
        more["dwell"] = [_number(path, line, DWELL) for line in lines]
    if units is None:
        units = _unit(path, lines) if UNIT in columns else "m"
    places = [[_number(path, line, name) for name in names] for line in lines]
    return Waypoints(np.array(places), dimensions=names, units=units, period=period, **more)


def _lines(path: Path, text: str) -> tuple[list[str], list[Line]]:
    """Names of the columns, and the lines below them that are not blank."""
    rows = csv.reader(io.StringIO(text, newline=""), strict=True)
    try:
        numbered = [(rows.line_num, row) for row in rows if any(map(str.strip, row))]
    except csv.Error as problem:
        raise ReadError(str(path), where=f"line {rows.line_num}", found=str(problem), wanted="cells of text") from None
    if not numbered:
        raise ReadError(str(path), found="no line", wanted="a header, and a row for each waypoint")
    (_, header), *others = numbered
    columns = [name.strip() for name in header]
    if "" in columns or len(set(columns)) < len(columns):
        raise ReadError(str(path), where="line 1", found=f"columns {', '.join(columns)}", wanted="names that differ")
    for number, row in others:
        if len(row) != len(columns):
            raise ReadError(str(path), where=f"line {number}", found=f"{len(row)} cells", wanted=f"{len(columns)}")
    return columns, [(number, dict(zip(columns, row, strict=True))) for number, row in others]


def _number(path: Path, line: Line, column: str) -> float:
    number, cells = line
    try:
        value = float(cells[column])
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise _wrong(path, number, column, cells[column], "a finite number")
    return value


def _label(path: Path, line: Line) -> int:
    number, cells = line
    try:
        value = int(cells[LABEL])
    except ValueError:
        value = 0
    if not 0 < value < MOST_LABEL:
        raise _wrong(path, number, LABEL, cells[LABEL], "the number of a subgoal, from 1")
    return value


def _unit(path: Path, lines: list[Line]) -> str:
    unit = lines[0][1][UNIT].strip()
    for number, cells in lines:
        if cells[UNIT].strip() != unit:
            raise _wrong(path, number, UNIT, cells[UNIT], f"{unit!r}, as in the lines before")
    return unit


def _wrong(path: Path, number: int, column: str, cell: str, wanted: str) -> ReadError:
    return ReadError(str(path), where=f"line {number}, column {column}", found=repr(cell), wanted=wanted)
