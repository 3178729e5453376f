"""Rows of a table of text, one line after the other: header first, then samples."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from subgoal.runtime.errors import InputError, ReadError

SEPARATORS = (",", ";", "\t", "|")
COMMENT = "#"
MOST_TOLD = 100
"""Characters of a line that an error repeats."""


class Row(NamedTuple):
    """One sample: its time, its place (d,), and which trajectory it is of ("" where no column says)."""

    time: float
    place: tuple[float, ...]
    trajectory: str


@dataclass(frozen=True)
class Columns:
    """Where in a line what stands, as its header says: ``width`` fields, numbers with ``decimal`` sign."""

    separator: str
    width: int
    decimal: str
    time: int
    position: tuple[int, ...]
    trajectory: int | None

    @classmethod
    def of(
        cls, header: str, *, position: Sequence[str], time: str, trajectory: str | None = None,
        separator: str | None = None, decimal: str | None = None,
    ) -> Columns:  # fmt: skip
        """From the line with the names of the columns; ``ReadError`` where one is missing.

        Numbers may have a decimal comma where a comma separates no columns, unless ``decimal`` says which it is.
        """
        sign = separator or max(SEPARATORS, key=header.count)
        try:
            names = [name.strip() for name in _split(header, sign)]
        except InputError as problem:
            raise ReadError("header", where="line 1", found=problem.found, wanted="names of columns") from None
        wanted = [*position, time, *([] if trajectory is None else [trajectory])]
        missing = [name for name in wanted if name not in names]
        if missing:
            raise ReadError("header", where="line 1", found=f"columns {', '.join(names)}",
                            wanted=f"columns {', '.join(wanted)}")  # fmt: skip
        place = tuple(names.index(name) for name in position)
        own = (None if sign == "," else ",") if decimal is None else decimal
        kind = None if trajectory is None else names.index(trajectory)
        return cls(sign, len(names), own or ".", names.index(time), place, kind)

    def row(self, line: str) -> Row:
        """The sample of a line; ``InputError`` for another number of fields, and for what is no number."""
        fields = _split(line, self.separator)
        if len(fields) != self.width:
            raise InputError("line", found=f"{len(fields)} fields", wanted=f"{self.width}, as the header has")
        try:
            time, *place = (float(fields[k].replace(self.decimal, ".")) for k in (self.time, *self.position))
        except ValueError as problem:
            raise InputError("line", found=_short(str(problem)), wanted="numbers") from None
        return Row(time, tuple(place), "" if self.trajectory is None else fields[self.trajectory].strip())


def is_empty(line: str) -> bool:
    """Whether a line is blank or a comment."""
    return not line.strip() or line.lstrip().startswith(COMMENT)


def _split(line: str, separator: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=separator))
    except csv.Error as problem:
        raise InputError("line", found=_short(str(problem)), wanted="fields of text") from None


def _short(told: str) -> str:
    return told if len(told) <= MOST_TOLD else f"{told[:MOST_TOLD]}…"
