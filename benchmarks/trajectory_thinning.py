"""Recordings thinned by regression before learning: what it saves, and what it costs.

``python -m benchmarks.trajectory_thinning`` prints one table: pen strokes and a hand-held camera at their full rate
where ``SUBGOAL_DATA`` leads to them, and a made hand that goes round a square. Positions are kept to 1 % of the
extent, actions to 30 % of the median speed. Beside it the same number of pairs by keeping every k-th, positions and
actions between them by straight lines. Subgoals are places with at least 5 %; a goal is missed by the distance to the
nearest of them.
"""

from __future__ import annotations

import sys
import time
import warnings
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

from benchmarks.common import Row
from experiments.common import find_data
from subgoal.answers.subgoals import subgoals
from subgoal.candidates import Candidates, epsilon_net
from subgoal.demonstrations.read import read
from subgoal.demonstrations.records import Demonstrations
from subgoal.gaussian.trajectory_thinning import thin_trajectories
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats

Goals = list[tuple[float, ...]]
POSITION, ACTION, COUNTED = 0.01, 0.3, 0.05
KNOWN: dict[str, tuple[str, Goals]] = {
    "pen, Line": ("lasa_handwriting/Line.mat", [(0, 0)]),
    "pen, Angle": ("lasa_handwriting/Angle.mat", [(-25, 39), (0, 0)]),
    "pen, Zshape": ("lasa_handwriting/Zshape.mat", [(-3, 40), (-40, 5), (0, 0)]),
    "camera": (
        "tum_rgbd_handheld/freiburg1_xyz-groundtruth.txt",
        [(1.08, 0.64, 1.34), (1.42, 0.64, 1.76), (1.29, 0.95, 1.58), (1.25, 0.29, 1.57), (1.02, 0.59, 1.66),
         (1.44, 0.56, 1.41)],
    ),
}  # fmt: skip
"""File and goals of each recording."""
SQUARE: Goals = [(1.5, 0.0), (1.5, 1.5), (0.0, 1.5), (0.0, 0.0)]


@dataclass(frozen=True, eq=False)
class Learned:
    """Places found, the weight of each, and the seconds from demonstrations to posterior."""

    places: Floats
    shares: Floats
    seconds: float

    def misses(self, goals: Goals) -> float:
        """Largest distance from a goal to the nearest place."""
        return float(np.linalg.norm(np.array(goals)[:, None] - self.places[None], axis=2).min(axis=1).max())


def recordings() -> dict[str, tuple[Demonstrations, Goals]]:
    """Those whose file is at hand, and the made one."""
    found = {"made square": (made(), SQUARE)}
    for name, (path, goals) in KNOWN.items():
        folder, _ = find_data(path.split("/")[0], None)
        if folder is not None:
            found[name] = (read(folder / path.split("/")[1]), goals)
    return found


def made(rounds: int = 3, rate: float = 100.0) -> Demonstrations:
    """A hand at 0.4 m/s round a square of 1.5 m, corners rounded over 8 cm, with 1 mm of tremor at 10 Hz."""
    corners = np.array([SQUARE[-1], *SQUARE * rounds])
    sharp = np.vstack([np.linspace(a, b, int(1.5 / 0.4 * rate), endpoint=False) for a, b in pairwise(corners)])
    path = gaussian_filter1d(sharp, 0.04 / 0.4 * rate, axis=0, mode="nearest")
    t = np.arange(len(path)) / rate
    path = path + 0.001 * np.column_stack([np.sin(20 * np.pi * t), np.cos(20 * np.pi * t)])
    return Demonstrations(path, np.gradient(path, t, axis=0), np.array([0, len(t)]), times=t)


def learn(demos: Demonstrations, candidates: Candidates) -> Learned:
    """The default sampler at its default settings."""
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(action_comparison(demos, candidates))
    took = time.perf_counter() - begin
    counted = [goal for goal in subgoals(posterior) if goal.share >= COUNTED]
    return Learned(np.array([g.position for g in counted]), np.array([g.share for g in counted]), took)


def table_of(demos: Demonstrations, candidates: Candidates) -> Floats:
    """(N, G) log densities."""
    table: Any = action_comparison(demos, candidates, dense_entries=2**62).dense
    return np.asarray(table)


def every(demos: Demonstrations, count: int) -> tuple[Demonstrations, Demonstrations]:
    """About ``count`` evenly spaced pairs, ends among them; and all pairs as straight lines between them give them."""
    offset, kept, lines = demos.offset, [], []
    values = np.hstack([demos.states, demos.actions])
    for start, end in pairwise(offset):
        share = max(2, round(count * (end - start) / len(values)))
        rows = np.unique(np.linspace(start, end - 1, share).round().astype(int))
        kept.append(rows)
        lines.append([np.interp(np.arange(start, end), rows, column[rows]) for column in values.T])
    rows, filled = np.concatenate(kept), np.hstack(lines).T
    width = np.asarray(demos.states).shape[1]
    few = replace(
        demos, states=demos.states[rows], actions=demos.actions[rows], times=None,
        offset=np.cumsum([0, *(len(part) for part in kept)]),
    )  # fmt: skip
    return few, replace(demos, states=filled[:, :width], actions=filled[:, width:])


def case(name: str, demos: Demonstrations, goals: Goals) -> list[Row]:
    """Saving, and three costs, of one recording."""
    candidates, extent = epsilon_net(demos), demos.extent
    speed = float(np.median(np.linalg.norm(demos.actions, axis=1)))
    begin = time.perf_counter()
    thinned = thin_trajectories(demos, POSITION * extent, ACTION * speed)
    took = time.perf_counter() - begin
    whole = learn(demos, candidates)
    few, lines = every(demos, len(thinned.rows))
    ours, plain = learn(thinned.demonstrations, candidates), learn(few, candidates)
    recorded = table_of(demos, candidates)
    reproduced = replace(demos, states=thinned.states, actions=thinned.actions)
    table, table_by_lines = (float(np.abs(table_of(d, candidates) - recorded).mean()) for d in (reproduced, lines))
    worst, worst_by_lines = (worst_error(d, demos, speed) for d in (reproduced, lines))
    missed, missed_by_all, missed_by_few = (found.misses(goals) / extent for found in (ours, whole, plain))
    places = f"{len(ours.places)} places ({len(whole.places)} from all, {len(plain.places)} from every k-th)"
    total = took + ours.seconds
    further = missed / missed_by_all if missed_by_all else None
    return [
        Row(f"{name}: {len(thinned.rows)} of {demos.n_observations:,} pairs, thinned in {took:.2f} s and learned",
            f"{total:.2f} s", "≥ 5 ×", whole.seconds >= 5 * total, "all pairs", whole.seconds / total),
        Row(f"  {len(goals)} goals, {places}; missed by", f"{missed:.1%}", "≤ 12 %", missed <= 0.12,
            f"all pairs ({missed_by_all:.1%}; every k-th {missed_by_few:.1%})", further),
        Row(f"  shares that are elsewhere than with all pairs (every k-th: {apart(plain, whole):.0%})",
            f"{apart(ours, whole):.0%}", "≤ 15 %", apart(ours, whole) <= 0.15),
        Row("  worst error of a reproduced pair, in tolerances", f"{worst:.2f}", "≤ 1", worst <= 1,
            "less than lines between every k-th", worst_by_lines / worst),
        Row(f"  mean error of the table, of {np.abs(recorded).mean():.2f} nats", f"{table:.3f}", "", True,
            "less than lines between every k-th", table_by_lines / table),
    ]  # fmt: skip


def worst_error(found: Demonstrations, recorded: Demonstrations, speed: float) -> float:
    """Largest error of a position or an action, in tolerances."""
    position = np.abs(found.states - recorded.states).max() / (POSITION * recorded.extent)
    return float(max(position, np.abs(found.actions - recorded.actions).max() / (ACTION * speed)))


def apart(found: Learned, whole: Learned) -> float:
    """Half the sum of differences of shares, those of each place going to the nearest that all pairs give."""
    nearest = np.linalg.norm(found.places[:, None] - whole.places[None], axis=2).argmin(axis=1)
    shares = np.bincount(nearest, found.shares, minlength=len(whole.shares))
    return float(np.abs(shares - whole.shares).sum() / 2)


def main() -> int:
    """1 if a target is missed."""
    rows = []
    for name, (demos, goals) in recordings().items():
        for row in case(name, demos, goals):
            print(row, flush=True)
            rows.append(row)
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
