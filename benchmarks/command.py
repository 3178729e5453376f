"""The command as a whole process: help, import, and from a file of 1,000 pairs to the report."""

from __future__ import annotations

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.common import Row, seconds, walkers

THESIS_SECONDS = 10.0
"""The thesis's time from demonstration to flight (7.2)."""


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True)


def _command() -> str:
    return str(Path(sys.executable).with_name("subgoal"))


def start() -> list[Row]:
    """Import and help."""
    importing = seconds(lambda: _run(sys.executable, "-c", "import subgoal"))
    helping = seconds(lambda: _run(_command(), "--help"))
    return [
        Row("import subgoal (whole process)", f"{importing:.2f} s", "< 1 s", importing < 1),
        Row("subgoal --help (whole process)", f"{helping:.2f} s", "< 0.5 s", helping < 0.5),
    ]


def learn() -> Row:
    """``subgoal learn`` with the default settings on 1,000 pairs, report and pictures included."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pairs.csv"
        states, actions = walkers(1000)
        with path.open("w", newline="") as stream:
            writer = csv.writer(stream)
            writer.writerow(["x", "y", "vx", "vy", "t", "track"])
            writer.writerows([*s, *a, k % 20, k // 20] for k, (s, a) in enumerate(zip(states, actions, strict=True)))
        words = [_command(), "learn", str(path), "-p", "x,y", "--action", "vx,vy", "-t", "t", "-i", "track", "-q"]
        best = seconds(lambda: _run(*words, "--out", str(Path(folder) / "out")), repeats=2)
    return Row(
        "subgoal learn, 1,000 pairs, process start to report", f"{best:.1f} s", "< 10 s", best < 10, "thesis",
        THESIS_SECONDS / best,
    )  # fmt: skip
