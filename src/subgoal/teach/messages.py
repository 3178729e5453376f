"""What a page may say: each message checked once, field by field, and made a frozen record."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from subgoal.teach.limits import Limits

NAME = re.compile(r"[A-Za-z0-9_-]{8,64}")
LONGEST_FILE_NAME = 200
LEAST_CONFIDENCE, MOST_CONFIDENCE = 0.1, 100.0
LEAST_CONCENTRATION, MOST_CONCENTRATION = 0.01, 100.0
Point = tuple[float, float, float]
"""Time (seconds since the session began), y and z (metres)."""


class RefusedError(Exception):
    """A message that is answered with an error and otherwise left alone; ``more`` goes into the answer."""

    def __init__(self, code: str, text: str, **more: Any) -> None:
        super().__init__(text)
        self.code, self.text, self.more = code, text, more


@dataclass(frozen=True)
class Hello:
    """First message of a connection: which load of the page speaks, and the session it goes on with, if any."""

    page: str
    session: str | None


@dataclass(frozen=True)
class Operation:
    """Something done to a session, numbered from 1 without gaps, so that it is done once however often it is sent."""

    number: int


@dataclass(frozen=True)
class Begin(Operation):
    """Pen down."""


@dataclass(frozen=True)
class Points(Operation):
    """Where the pen went."""

    points: tuple[Point, ...]


@dataclass(frozen=True)
class Lift(Operation):
    """Pen up."""


@dataclass(frozen=True)
class Undo(Operation):
    """Take the last stroke away."""


@dataclass(frozen=True)
class Clear(Operation):
    """Take everything away."""


@dataclass(frozen=True)
class Tune(Operation):
    """Other parameters of the model: confidence α and concentration η."""

    confidence: float
    concentration: float


@dataclass(frozen=True)
class Fly(Operation):
    """Fly the subgoals."""


@dataclass(frozen=True)
class Save(Operation):
    """Write a project folder."""


@dataclass(frozen=True)
class Export(Operation):
    """Send the waypoints as a file of ``format`` "csv" or "json"."""

    format: str


@dataclass(frozen=True)
class Dropped(Operation):
    """A file in place of the drawing."""

    name: str
    content: bytes


def parse(message: str | bytes, limits: Limits) -> Hello | Operation:
    """The record of a message: JSON text, or a file as one line of JSON and then its bytes.

    Raises ``RefusedError``: too-large, malformed, out-of-range.
    """
    if isinstance(message, bytes):
        return _dropped(message, limits)
    if len(message) > limits.message_bytes or len(message.encode("utf-8", "replace")) > limits.message_bytes:
        raise RefusedError("too-large", f"a message of more than {limits.message_bytes:,} bytes")
    fields = _fields(message)
    kind = fields.pop("type", None)
    if not isinstance(kind, str):
        raise RefusedError("malformed", "type: wanted a word")
    if kind == "hello":
        session = fields.pop("session", None)
        hello = Hello(_name(fields.pop("page", None)), None if session is None else _name(session))
        _nothing_left(fields)
        return hello
    number = _number(fields)
    if kind in SIMPLE:
        _nothing_left(fields)
        return SIMPLE[kind](number)
    if kind not in DETAILED:
        raise RefusedError("malformed", f"no message is of type {kind[:40]!r}")
    operation = DETAILED[kind](number, fields, limits)
    _nothing_left(fields)
    return operation


def _fields(text: str) -> dict[str, Any]:
    try:
        fields = json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError):
        raise RefusedError("malformed", "not JSON, or with numbers that are not finite") from None
    if not isinstance(fields, dict):
        raise RefusedError("malformed", "not an object")
    return fields


def _no_number(word: str) -> float:
    raise ValueError(word)


def _points(number: int, fields: dict[str, Any], limits: Limits) -> Points:
    rows = fields.pop("points", None)
    if not isinstance(rows, list) or not rows:
        raise RefusedError("malformed", "points: wanted a list of [t, y, z]")
    if len(rows) > limits.batch_points:
        raise RefusedError("too-large", f"more than {limits.batch_points:,} points in one message")
    points = []
    for row in rows:
        if not isinstance(row, list) or len(row) != 3:
            raise RefusedError("malformed", "points: wanted three numbers for each, t, y, z")
        time, y, z = (_real("points", each) for each in row)
        if not 0 <= time <= limits.seconds or not max(abs(y), abs(z)) <= limits.reach:
            raise RefusedError("out-of-range", f"points: t from 0 to {limits.seconds:g}, y and z to ±{limits.reach:g}")
        points.append((time, y, z))
    return Points(number, tuple(points))


def _tune(number: int, fields: dict[str, Any], limits: Limits) -> Tune:
    confidence = _real("confidence", fields.pop("confidence", None))
    concentration = _real("concentration", fields.pop("concentration", None))
    if not LEAST_CONFIDENCE <= confidence <= MOST_CONFIDENCE:
        raise RefusedError("out-of-range", f"confidence: from {LEAST_CONFIDENCE:g} to {MOST_CONFIDENCE:g}")
    if not LEAST_CONCENTRATION <= concentration <= MOST_CONCENTRATION:
        raise RefusedError("out-of-range", f"concentration: from {LEAST_CONCENTRATION:g} to {MOST_CONCENTRATION:g}")
    return Tune(number, confidence, concentration)


def _export(number: int, fields: dict[str, Any], limits: Limits) -> Export:
    chosen = fields.pop("format", None)
    if chosen not in ("csv", "json"):
        raise RefusedError("malformed", "format: wanted csv or json")
    return Export(number, chosen)


SIMPLE: dict[str, Callable[[int], Operation]] = {
    "begin": Begin, "lift": Lift, "undo": Undo, "clear": Clear, "fly": Fly, "save": Save,
}  # fmt: skip
DETAILED: dict[str, Callable[[int, dict[str, Any], Limits], Operation]] = {
    "points": _points, "tune": _tune, "export": _export,
}  # fmt: skip


def _dropped(message: bytes, limits: Limits) -> Dropped:
    head, line, content = message.partition(b"\n")
    if not line or len(head) > limits.message_bytes:
        raise RefusedError("malformed", "a file without the line before it")
    if len(content) > limits.file_bytes:
        raise RefusedError("too-large", f"a file of more than {limits.file_bytes / 2**20:g} MiB")
    try:
        fields = _fields(head.decode("utf-8"))
    except UnicodeDecodeError:
        raise RefusedError("malformed", "not UTF-8") from None
    if fields.pop("type", None) != "file":
        raise RefusedError("malformed", "bytes that are no file")
    number, name = _number(fields), fields.pop("name", None)
    if not isinstance(name, str) or not 0 < len(name) <= LONGEST_FILE_NAME or not name.isprintable():
        raise RefusedError("malformed", "name: wanted that of the file")
    _nothing_left(fields)
    return Dropped(number, name, content)


def _number(fields: dict[str, Any]) -> int:
    number = fields.pop("number", None)
    if not isinstance(number, int) or isinstance(number, bool) or not 1 <= number < 2**53:
        raise RefusedError("malformed", "number: wanted a whole number from 1")
    return number


def _real(what: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise RefusedError("malformed", f"{what}: wanted numbers")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise RefusedError("out-of-range", f"{what}: wanted finite numbers")
    return number


def _name(value: Any) -> str:
    if not isinstance(value, str) or not NAME.fullmatch(value):
        raise RefusedError("malformed", "page, session: wanted 8 to 64 letters, digits, - or _")
    return value


def _nothing_left(fields: dict[str, Any]) -> None:
    if fields:
        raise RefusedError("malformed", f"unknown field {min(fields)[:40]!r}")
