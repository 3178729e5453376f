"""How a text table is laid out: encoding, separator, decimal sign, header. Looked up in its first lines."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

from subgoal.demonstrations.readers.files import guarded, head
from subgoal.runtime.errors import InputError, ReadError

SEPARATORS = ("\t", ";", ",", "|", " ")
"""In order of preference; a blank stands for any run of white space."""
BYTE_ORDER_MARKS = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
LINE_END = re.compile(r"\r\n|\n|\r")
NUMBER = re.compile(r"\s*[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?\s*|\s*[+-]?(nan|inf|infinity)\s*", re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+([eE][+-]?\d+)?\s*")
DECIMAL_POINT = re.compile(r"\s*[+-]?\d*\.\d+([eE][+-]?\d+)?\s*")


@dataclass(frozen=True)
class Layout:
    """Where the table of a text file begins and how to read it.

    ``skip`` is the number of lines before the data (comments, header); ``names`` the columns, "0", "1", ... if the
    file has no header line (``headed`` is False then); ``latin`` is True where the bytes were no UTF-8 and were read
    as Latin-1.
    """

    encoding: str
    separator: str
    decimal: str
    skip: int
    names: tuple[str, ...]
    headed: bool = False
    latin: bool = False


def find_layout(path: Path, separator: str | None = None, decimal: str | None = None) -> Layout:
    """The layout of a text table; ``separator`` and ``decimal`` are looked up unless given.

    Raises ``ReadError`` for bytes that are no text and for a file without any row.
    """
    if separator is not None and (not isinstance(separator, str) or len(separator) != 1):
        raise InputError("separator", found=repr(separator), wanted="one character")
    if decimal not in (None, ".", ","):
        raise InputError("decimal", found=repr(decimal), wanted="'.' or ','")
    encoding, latin = find_encoding(path)
    lines = LINE_END.split(head(path).decode(encoding, errors="ignore"))
    skip = next((k for k, line in enumerate(lines) if line.strip() and not line.startswith("#")), None)
    if skip is None:
        raise ReadError(str(path), found="no line that is not empty or a comment", wanted="a table")
    separator = separator or _separator(lines[skip : skip + 20])
    with guarded(path, "a table of text"):
        rows = _cells(lines[skip : skip + 200], separator)
        comment = _cells([lines[skip - 1].lstrip("# ")], separator)[0] if skip else []
    names = [name.strip() for name in rows[0]]
    headed = not _are_data(names)
    if not headed:
        told = len(comment) == len(names) and not any(NUMBER.fullmatch(name) for name in comment)
        names = [name.strip() for name in comment] if told else [str(k) for k in range(len(names))]
    else:
        skip, rows = skip + 1, rows[1:]
    return Layout(encoding, separator, decimal or _decimal(rows, separator), skip, tuple(names), headed, latin)


def find_encoding(path: Path) -> tuple[str, bool]:
    """Encoding of a text file, and whether it is Latin-1 for want of anything better. Raises for zero bytes."""
    start = head(path)
    for mark, encoding in BYTE_ORDER_MARKS.items():
        if start.startswith(mark):
            return encoding, False
    if b"\0" in start:
        raise ReadError(str(path), where=f"byte {start.index(0)}", found="a zero byte", wanted="text")
    return ("utf-8", False) if _is_utf8(path) else ("latin-1", True)


def _is_utf8(path: Path) -> bool:
    try:
        with path.open(encoding="utf-8", newline="") as stream:
            while stream.read(2**20):
                pass
    except UnicodeDecodeError:
        return False
    return True


def _cells(lines: list[str], separator: str) -> list[list[str]]:
    return [line.split() for line in lines] if separator == " " else list(csv.reader(lines, delimiter=separator))


def _are_data(cells: list[str]) -> bool:
    """Whether the first line holds data and not names: more than half of it are numbers.

    A first cell that is empty with 0, 1, 2, ... after it are the names a data frame without names writes.
    """
    told = [cell for cell in cells if cell]
    unnamed = not cells[0] and told == [str(k) for k in range(len(cells) - 1)] if cells else False
    return sum(NUMBER.fullmatch(cell) is not None for cell in told) > len(told) / 2 and not unnamed


def _separator(lines: list[str]) -> str:
    """The character that cuts most of the first lines into as many fields as the very first."""

    def agreement(mark: str) -> int:
        counts = [len(line.split()) - 1 if mark == " " else line.count(mark) for line in lines if line.strip()]
        return sum(count == counts[0] for count in counts) if counts[0] else 0

    best = max(SEPARATORS, key=agreement)
    return best if agreement(best) else ","


def _decimal(rows: list[list[str]], separator: str) -> str:
    """A comma, if some cells need one and none has a point."""
    cells = [cell for row in rows for cell in row]
    if separator == "," or any(DECIMAL_POINT.fullmatch(cell) for cell in cells):
        return "."
    return "," if any(DECIMAL_COMMA.fullmatch(cell) for cell in cells) else "."
