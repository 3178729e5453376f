"""The likelihood table: held whole, and passed over in tiles at a size that is never held."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

from benchmarks.common import Row, peak_megabytes, problem, seconds
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.normalisers import log_direction_normaliser
from subgoal.runtime.checks import Floats

CONFIDENCE = 10.0
CHUNK = 1000


def numpy_table(states: Floats, units: Floats, points: Floats, radius: float) -> Floats:
    """The same rows by vectorised NumPy."""
    way = points[None] - states[:, None]
    length = np.linalg.norm(way, axis=2)
    with np.errstate(invalid="ignore", divide="ignore"):
        gap = np.linalg.norm(units[:, None] - way / length[..., None], axis=2)
    table = -CONFIDENCE * gap - log_direction_normaliser(CONFIDENCE, 2)
    table[length <= radius / 2] = -np.log(2 * np.pi)
    return np.asarray(table)


def numpy_pass(demos: Demonstrations, candidates: Candidates, rows: int) -> Floats:
    """log Σ_g p_g L_ig of the first ``rows`` observations, a chunk at a time."""
    units = demos.actions / np.linalg.norm(demos.actions, axis=1, keepdims=True)
    parts = []
    for start in range(0, rows, CHUNK):
        block = slice(start, min(start + CHUNK, rows))
        table = numpy_table(demos.states[block], units[block], candidates.points, candidates.radius)
        table += candidates.log_prior
        peak = table.max(axis=1)
        parts.append(peak + np.log(np.exp(table - peak[:, None]).sum(axis=1)))
    return np.concatenate(parts)


def whole_table() -> Row:
    """N = G = 1,000."""
    demos, candidates = problem(1000, 1000)
    units = demos.actions / np.linalg.norm(demos.actions, axis=1, keepdims=True)
    ours = seconds(lambda: action_comparison(demos, candidates, confidence=CONFIDENCE).dense)
    numpy_time = seconds(lambda: numpy_table(demos.states, units, candidates.points, candidates.radius))
    return Row("table N = G = 1,000", f"{1e3 * ours:.1f} ms", "< 50 ms", ours < 0.05, "NumPy", numpy_time / ours)


def tiled_pass(rows: int = 1_000_000) -> list[Row]:
    """10⁶ × 10³ in a process of its own, so that the peak memory is its own."""
    answer = subprocess.run(
        [sys.executable, "-m", "benchmarks.table", str(rows)], capture_output=True, text=True, check=True
    )
    ours, numpy_time, memory, difference = (float(word) for word in answer.stdout.split())
    ratio = numpy_time / ours
    return [
        Row(f"tiled pass {rows:,} x 1,000", f"{ours:.1f} s", "> 4x NumPy", ratio >= 4, "chunked NumPy", ratio),
        Row("  peak memory of that pass", f"{memory:.0f} MB", "< 1000 MB", memory < 1000),
        Row("  largest difference from NumPy", f"{difference:.1e}", "< 1e-6", difference < 1e-6),
    ]


def main(rows: int) -> None:
    """Time both passes; print seconds, seconds, megabytes before NumPy ran, and the largest difference."""
    demos, candidates = problem(rows, 1000)
    action_comparison(*problem(1000, 1000), confidence=CONFIDENCE, dense_entries=1).log_marginal  # noqa: B018
    ours: list[Floats] = []
    time_ours = seconds(
        lambda: ours.append(action_comparison(demos, candidates, confidence=CONFIDENCE).log_marginal),
        repeats=1, warm=False,
    )  # fmt: skip
    memory = peak_megabytes()
    theirs: list[Floats] = []
    time_theirs = seconds(lambda: theirs.append(numpy_pass(demos, candidates, rows)), repeats=1, warm=False)
    print(time_ours, time_theirs, memory, float(np.abs(ours[0] - theirs[0]).max()))


if __name__ == "__main__":
    main(int(sys.argv[1]))
