"""Track files of the Edinburgh Informatics Forum pedestrian database (Majecka 2009)."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.clock import order_rows
from subgoal.demonstrations.readers.columns import Treatment
from subgoal.demonstrations.readers.files import guarded, plain_file, source_of
from subgoal.demonstrations.recordings import piece_names
from subgoal.demonstrations.records import Recording
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import ReadError

TRACK = re.compile(r"TRACK\.(\w{1,20})\s{0,20}=")
ANNOUNCED = re.compile(r"Total number of trajectories in file are\s{1,20}(\d{1,9})\b")


def read_edinburgh(
    path: Any, *, rate: float | None = None, scale: float = 1.0, units: str = "px", clock: str = "refuse"
) -> Recording:
    """Read ``TRACK.Rn=[[x y frame];...];`` lines: pixel positions (y down) over frame numbers.

    Times are frames, or seconds if ``rate`` (frames per second, about 9 for this data base) is given. ``scale``
    multiplies the positions (0.0247 for metres), ``units`` names the unit they are in then. Repeated frames are
    dropped and counted, and so are tracks announced in the first line but absent from the file.

    Raises ``ReadError`` where a track is torn or named twice, ``clock`` as in ``read_csv``.
    """
    how = Treatment(scale=scale, units=units, clock=clock, rate=rate)
    path = plain_file(path)
    with guarded(path, "text"):
        text = path.read_text(encoding="latin-1")
    names, tracks = _tracks(path, text)
    told = ANNOUNCED.search(text, 0, 10_000)
    missing = max(int(told.group(1)) - len(names), 0) if told else 0
    rows = np.concatenate(tracks)
    group = np.repeat(np.arange(len(tracks)), [len(track) for track in tracks])
    source = source_of(path).noting(tracks_announced_but_not_in_the_file=missing)
    order, piece, source = order_rows(rows[:, 2], group, source, how.clock)
    starts = np.flatnonzero((np.diff(group[order], prepend=-1) != 0) | (np.diff(piece, prepend=0) != 0))
    return Recording(
        positions=rows[order, :2] * how.scale,
        times=rows[order, 2] / (1.0 if rate is None else rate),
        offset=np.append(starts, len(order)),
        names=("x", "y"),
        units=how.units,
        trajectory_names=piece_names(names, group[order][starts])[0],
        time_unit="frame" if rate is None else "s",
        source=source,
    )


def _tracks(path: Path, text: str) -> tuple[list[str], list[Floats]]:
    """Names and (points, 3) rows x, y, frame of all tracks."""
    names: list[str] = []
    tracks = []
    for match in TRACK.finditer(text):
        name = match.group(1)
        end = text.find("]]", match.end())
        body = text[match.end() : end]
        if end < 0 or "=" in body or not body.lstrip().startswith("[["):
            raise ReadError(str(path), where=f"TRACK.{name}", found="a torn track", wanted="[[x y frame];...];")
        tracks.append(_points(path, name, body.lstrip()[2:]))
        names.append(name)
    if not names:
        raise ReadError(str(path), found="no TRACK.Rn=[[...]] line", wanted="at least one track")
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise ReadError(str(path), where=f"TRACK.{twice}", found="the name twice", wanted="one track of a name")
    return names, tracks


def _points(path: Path, name: str, body: str) -> Floats:
    """(points, 3) from "x y frame];[x y frame];[..."."""
    cells = [point.strip(" \t\r\n[]").split() for point in body.split(";")]
    try:
        points = np.array(cells, dtype=np.float64)
    except ValueError:
        points = np.empty((0, 0))
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
        raise ReadError(str(path), where=f"TRACK.{name}", found=f"{body[:40]!r}...", wanted="three numbers a point")
    return points
