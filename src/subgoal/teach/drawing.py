"""A drawing: strokes of points with their times, as they came from the hand or from a file."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from subgoal.demonstrations.records import Recording, Source
from subgoal.teach.limits import Limits
from subgoal.teach.messages import Point, RefusedError

BY_HAND = "drawing"
NAMES = ("y", "z")
"""To the right and up."""


@dataclass(frozen=True)
class Sheet:
    """A drawing at one moment.

    Attributes
    ----------
    strokes:
        Points (t, y, z) of each stroke.
    drawn:
        Whether the pen is down.
    names, units, time_unit, source:
        As in ``Recording``.
    revision:
        Counts the changes of the drawing.
    lineage:
        Counts the changes that did more than add points.
    """

    strokes: tuple[tuple[Point, ...], ...]
    drawn: bool
    names: tuple[str, ...]
    units: str
    time_unit: str
    source: str
    revision: int
    lineage: int

    @property
    def n_points(self) -> int:
        """Points of all strokes."""
        return sum(map(len, self.strokes))

    @property
    def by_hand(self) -> bool:
        """Whether nothing of it is from a file."""
        return self.source == BY_HAND

    def recording(self) -> Recording:
        """Each stroke a trajectory, "stroke 1" and so on. Raises ``InputError`` where nothing is drawn."""
        rows = np.array([point for stroke in self.strokes for point in stroke], float).reshape(-1, 3)
        filled = [(k, len(stroke)) for k, stroke in enumerate(self.strokes) if stroke]
        return Recording(
            positions=rows[:, 1:], times=rows[:, 0], offset=np.cumsum([0, *(size for _, size in filled)]),
            names=self.names, units=self.units, trajectory_names=tuple(stroke_name(k) for k, _ in filled),
            time_unit=self.time_unit, source=Source(self.source),
        )  # fmt: skip


def stroke_name(k: int) -> str:
    """Of the k-th stroke (from 0)."""
    return f"stroke {k + 1}"


def stroke_of(name: str) -> int:
    """The number (from 0) of the stroke of that name."""
    return int(name.split()[-1]) - 1


class Drawing:
    """What a session has drawn; each operation raises ``RefusedError`` and changes nothing where it cannot be done."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._revision = self._lineage = 0
        self._empty()

    def _empty(self) -> None:
        self._strokes: list[list[Point]] = []
        self._drawn = False
        self._names: tuple[str, ...] = NAMES
        self._units, self._time_unit, self._source = "m", "s", BY_HAND

    @property
    def n_points(self) -> int:
        """Points of all strokes."""
        return sum(map(len, self._strokes))

    @property
    def revision(self) -> int:
        """How often it has changed."""
        return self._revision

    @property
    def drawn(self) -> bool:
        """Whether the pen is down."""
        return self._drawn

    def sheet(self) -> Sheet:
        """The drawing as it is now."""
        strokes = tuple(tuple(stroke) for stroke in self._strokes)
        return Sheet(strokes, self._drawn, self._names, self._units, self._time_unit, self._source,
                     self._revision, self._lineage)  # fmt: skip

    def begin(self) -> None:
        """Pen down: a new stroke."""
        if self._drawn:
            raise RefusedError("out-of-order", "the pen is down already")
        if len(self._strokes) >= self._limits.strokes:
            raise RefusedError("too-large", f"a drawing has at most {self._limits.strokes} strokes")
        self._strokes.append([])
        self._drawn = True

    def add(self, points: tuple[Point, ...]) -> None:
        """Where the pen went, at times that increase."""
        if not self._drawn:
            raise RefusedError("out-of-order", "points while the pen is up")
        if self.n_points + len(points) > self._limits.points:
            raise RefusedError("too-large", f"a drawing has at most {self._limits.points:,} points")
        stroke = self._strokes[-1]
        times = [point[0] for point in (*stroke[-1:], *points)]
        if not all(before < after for before, after in pairwise(times)):
            raise RefusedError("out-of-order", "times that do not increase along a stroke")
        stroke.extend(points)
        self._revision += 1

    def lift(self) -> None:
        """Pen up."""
        if not self._drawn:
            raise RefusedError("out-of-order", "the pen is up already")
        self._drawn = False
        self._revision += 1

    def undo(self) -> None:
        """Without the last stroke."""
        if not self._strokes:
            raise RefusedError("cannot", "There is no stroke to take away.")
        self._strokes.pop()
        self._changed()

    def clear(self) -> None:
        """An empty sheet."""
        self._empty()
        self._changed()

    def replace(self, recording: Recording) -> None:
        """The (M, 2) positions of a recording, in place of what was drawn."""
        rows = np.column_stack([recording.times, recording.positions]).tolist()
        edges = zip(recording.offset[:-1], recording.offset[1:], strict=True)
        self._empty()
        self._strokes = [[(t, y, z) for t, y, z in rows[a:b]] for a, b in edges]
        self._names, self._units = recording.names, recording.units
        self._time_unit, self._source = recording.time_unit, recording.source.name
        self._changed()

    def _changed(self) -> None:
        self._drawn = False
        self._revision += 1
        self._lineage += 1
