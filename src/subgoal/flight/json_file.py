"""Waypoints as a versioned JSON file: all that is known of them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.flight.waypoints import Waypoints
from subgoal.runtime.checks import real_array
from subgoal.runtime.errors import ReadError

KIND, VERSION = "subgoal waypoints", 1
NUMBERS = "label", "dwell", "turn", "roundness"
"""Keys of each waypoint."""
WORDS = {list: "a list", str: "a text", bool: "true or false", float: "a number"}
MOST_TOLD = 60


def write_record(waypoints: Waypoints) -> str:
    """Everything, as text."""
    record = {
        "kind": KIND, "version": VERSION, "units": waypoints.units, "cyclic": waypoints.cyclic,
        "dimensions": list(waypoints.dimensions),
        "period": [None if np.isinf(length) else length for length in waypoints.period],
        "notes": list(waypoints.notes),
        "start": None if waypoints.start is None else waypoints.start.tolist(),
        "waypoints": [
            {"label": int(label), "name": name, "position": place.tolist(), "dwell": float(dwell), "turn": float(turn),
             "roundness": float(rounded)}
            for label, name, place, dwell, turn, rounded in zip(
                waypoints.labels, waypoints.names, waypoints.positions, waypoints.dwell, waypoints.turns,
                waypoints.roundness, strict=True,
            )
        ],
    }  # fmt: skip
    return json.dumps(record, indent=1, allow_nan=False) + "\n"


def read_record(path: Path, text: str) -> Waypoints:
    """The waypoints of ``text``, the content of ``path``; ``ReadError`` names the key at fault, and its waypoint."""
    wanted = f"a file of kind {KIND!r}, version {VERSION}"
    try:
        record = json.loads(text)
    except (json.JSONDecodeError, RecursionError) as problem:
        raise ReadError(str(path), found=str(problem), wanted=wanted) from None
    told = [record.get(key) for key in ("kind", "version")] if isinstance(record, dict) else [None, None]
    if told[0] != KIND or told[1] is True or told[1] != VERSION:
        raise ReadError(str(path), found=f"kind {told[0]!r}, version {told[1]!r}", wanted=wanted)
    whole = Entry(path, "", record)
    rows = [Entry(path, f"waypoint {k}", row) for k, row in enumerate(whole.take("waypoints", list), 1)]
    period = whole.take("period", list)
    if not all(length is None or _is_number(length) for length in period):
        raise whole.wrong("period", period, "lengths, or null")
    labels, dwell, turns, rounded = ([row.take(key, float) for row in rows] for key in NUMBERS)
    places = real_array("positions", [row.take("position", list) for row in rows], ndim=2)
    return Waypoints(
        places, tuple(row.take("name", str) for row in rows), labels, dwell,
        whole.take("cyclic", bool), tuple(map(str, whole.take("dimensions", list))), whole.take("units", str),
        tuple(np.inf if length is None else float(length) for length in period),
        whole.take("start", (list, type(None))), turns, rounded, tuple(whole.take("notes", list)),
    )  # fmt: skip


@dataclass(frozen=True)
class Entry:
    """An object of a file, and where it stands."""

    path: Path
    where: str
    values: Any

    def take(self, key: str, kind: type | tuple[type, ...]) -> Any:
        """The value of a key, of that kind; ``float`` are all numbers. ``ReadError`` where it is missing or another."""
        if not isinstance(self.values, dict):
            raise ReadError(str(self.path), where=self.where, found=_short(self.values), wanted="an object with keys")
        if key not in self.values:
            raise ReadError(str(self.path), where=self.where or None, found=f"no {key!r}",
                            wanted=f"one beside {', '.join(map(repr, self.values))}")  # fmt: skip
        value = self.values[key]
        right = _is_number(value) if kind is float else isinstance(value, kind)
        if not right:
            raise self.wrong(key, value, WORDS[kind[0] if isinstance(kind, tuple) else kind])
        return value

    def wrong(self, key: str, value: Any, wanted: str) -> ReadError:
        """What is at a key is not what it should be."""
        where = f"{self.where}, {key}" if self.where else key
        return ReadError(str(self.path), where=where, found=_short(value), wanted=wanted)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _short(value: Any) -> str:
    """A value in at most 60 characters."""
    told = repr(value)
    return told if len(told) <= MOST_TOLD else f"{told[:MOST_TOLD]}…"
