"""What a driver is to do and for how long: scripts of named steady states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError

Order = Literal["script", "shuffled"]
Script = Sequence[tuple[str, float]]

SCRIPT: Script = (
    ("stop", 2.0), ("straight", 3.0), ("left", 4.5), ("straight", 2.5), ("right", 4.5), ("straight", 2.5),
    ("left drift", 4.5), ("straight", 2.5), ("right drift", 4.5), ("stop", 2.0),
)  # fmt: skip
"""The six manoeuvres of thesis 7.3, in seconds before they are varied."""

SPREAD = 0.15
"""Standard deviation of the logarithm of a length."""


def timetable(script: Script, order: Order, duration: float, generator: np.random.Generator) -> list[tuple[str, float]]:
    """(name, seconds at which it ends) of each segment: lengths × exp(0.15 N), in all ``duration`` seconds.

    "shuffled" permutes everything between the first and the last segment, so that manoeuvres often follow each other
    without a straight between.
    """
    names = [name for name, _ in script]
    lengths = np.array([length for _, length in script]) * np.exp(SPREAD * generator.standard_normal(len(script)))
    turn = np.arange(len(script))
    if order == "shuffled":
        turn[1:-1] = generator.permutation(turn[1:-1])
    ends = np.cumsum(lengths[turn])
    return [(names[k], float(end)) for k, end in zip(turn, ends * (duration / ends[-1]), strict=True)]


def check_script(script: Script, places: Mapping[str, Any], order: Any) -> Script:
    """The script, every name a place and every length above zero; raises ``InputError`` naming the segment."""
    if order not in ("script", "shuffled"):
        raise InputError("order", found=repr(order), wanted="'script' or 'shuffled'")
    if not len(script):
        raise InputError("script", found="no segments", wanted="(name, seconds) of at least one")
    for k, segment in enumerate(script):
        if len(segment) != 2 or segment[0] not in places:
            raise InputError(
                "script", where=f"segment {k}", found=repr(segment), wanted=f"(name, seconds), of {', '.join(places)}"
            )
        positive(f"seconds of segment {k} of the script", segment[1])
    return script
