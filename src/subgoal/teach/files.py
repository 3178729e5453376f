"""Files in and out: a dropped recording laid on the plane, and a project folder that holds all that was taught."""

from __future__ import annotations

import csv
import re
import secrets
import shutil
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.answers.subgoals import Subgoals
from subgoal.demonstrations.readers import format_of, read_recording
from subgoal.demonstrations.readers.layout import find_layout
from subgoal.demonstrations.records import Recording, Source
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.results import write_results
from subgoal.runtime.errors import InputError
from subgoal.teach.drawing import NAMES, Sheet, stroke_name
from subgoal.teach.flying import waypoint_text
from subgoal.teach.limits import Limits
from subgoal.teach.messages import RefusedError

HEADS = ("time", *NAMES, "stroke")
"""Columns of recording.csv; they are found again in a file that is dropped."""
NAMED = re.compile(r"[^A-Za-z0-9._-]+")


def read_dropped(name: str, content: bytes, limits: Limits) -> Recording:
    """The recording in a file of that name, on the vertical plane.

    Raises ``RefusedError``, in words of the page, where it cannot be read or is too long.
    """
    with tempfile.TemporaryDirectory(prefix="subgoal-teach-") as folder:
        path = Path(folder) / (NAMED.sub("_", Path(name).name)[-100:].lstrip(".") or "recording")
        path.write_bytes(content)
        try:
            recording = planar(read_recording(path, **_own_columns(path)))
        except InputError as problem:
            raise RefusedError("file", _told(problem, path, name[:100])) from None
    recording = replace(recording, source=Source(name[:100], recording.source.checksum))
    for what, found, most in (
        ("samples", len(recording.times), limits.points), ("trajectories", recording.n_trajectories, limits.strokes),
    ):  # fmt: skip
        if found > most:
            raise RefusedError("file", f"{name[:100]}: found {found:,} {what}, wanted at most {most:,}.")
    return recording


def _told(problem: InputError, path: Path, name: str) -> str:
    """What is wrong with a file, without the folder it was put in and without advice for Python."""
    place = f" at {problem.where}" if problem.where else ""
    text = f"{name}{place}: found {problem.found}, wanted {problem.wanted}."
    return text.replace(", or to be told.", ".").replace(str(path), name)


def _own_columns(path: Path) -> dict[str, Any]:
    """Options for tables whose columns are called as in recording.csv."""
    if format_of(path) != "csv":
        return {}
    names = find_layout(path, None, None).names
    if not set(NAMES) <= set(names) or "x" in names:
        return {}
    options: dict[str, Any] = {"position": list(NAMES), "units": "m"}
    return options | ({"trajectory": "stroke"} if "stroke" in names else {})


def planar(recording: Recording) -> Recording:
    """The columns y and z, where both are there; else the first two."""
    if recording.positions.shape[1] < 2:
        raise InputError("recording", found="one column of positions", wanted="two, or more")
    names = list(recording.names)
    columns = [names.index(name) for name in NAMES] if set(NAMES) <= set(names) else [0, 1]
    positions = np.ascontiguousarray(recording.positions[:, columns])
    chosen = tuple(names[k] for k in columns)
    return replace(recording, positions=positions, names=chosen, actions=None, period=(), quaternion=None)


def save_project(sheet: Sheet, found: Subgoals, posterior: Posterior, out: Path) -> Path:
    """A new folder in ``out``: recording.csv, waypoints.csv and .json, and all that ``write_results`` writes.

    It has the time in its name, and is whole or not there.
    """
    out.mkdir(parents=True, exist_ok=True)
    aside = Path(tempfile.mkdtemp(prefix=".teaching-", dir=out))
    try:
        aside.chmod(0o755)
        with (aside / "recording.csv").open("w", newline="", encoding="utf-8") as stream:
            writer = csv.writer(stream)
            writer.writerow((HEADS[0], *sheet.names, HEADS[-1]))
            writer.writerows(
                (*map(repr, point), stroke_name(k)) for k, stroke in enumerate(sheet.strokes) for point in stroke
            )
        write_results(posterior, aside, found=found)
        for kind in ("csv", "json"):
            (aside / f"waypoints.{kind}").write_text(waypoint_text(posterior, kind), encoding="utf-8")
        return _moved(aside, out)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _moved(aside: Path, out: Path) -> Path:
    """The folder under its own name, which no other has."""
    begun = time.strftime("teach-%Y%m%d-%H%M%S")
    folder = out / begun
    while True:
        try:
            folder.mkdir()
            break
        except FileExistsError:
            folder = out / f"{begun}-{secrets.token_hex(3)}"
    return aside.replace(folder)
