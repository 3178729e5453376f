"""Synthetic recordings, honest clocks and the rows of the table."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats


@dataclass(frozen=True)
class Row:
    """One line: what was timed, the figure, what it is held against, and the ratio where there is an alternative."""

    what: str
    figure: str
    target: str
    met: bool
    alternative: str = ""
    ratio: float | None = None

    def __str__(self) -> str:
        ratio = "" if self.ratio is None else f"{self.ratio:.1f}x {self.alternative}"
        return f"{'ok  ' if self.met else 'MISS'}  {self.what:<58} {self.figure:>12}  {self.target:<14} {ratio}"


def seconds(function: Callable[[], Any], *, repeats: int = 3, warm: bool = True) -> float:
    """The best of ``repeats`` runs, after one that is not counted if ``warm``."""
    if warm:
        function()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return min(times)


def walkers(n: int, goals: int = 6, seed: int = 0) -> tuple[Floats, Floats]:
    """Positions (n, 2) and velocities (n, 2) of walkers that head for one of a few places with some noise."""
    generator = np.random.default_rng(seed)
    places = generator.uniform(0, 100, size=(goals, 2))
    states = generator.uniform(0, 100, size=(n, 2))
    way = places[generator.integers(goals, size=n)] - states
    angle = np.arctan2(way[:, 1], way[:, 0]) + generator.normal(scale=0.2, size=n)
    return states, np.column_stack([np.cos(angle), np.sin(angle)])


def problem(n: int, g_count: int) -> tuple[Demonstrations, Candidates]:
    """``n`` pairs and ``g_count`` candidate places."""
    states, actions = walkers(n)
    points = np.random.default_rng(1).uniform(0, 100, size=(g_count, 2))
    return Demonstrations.from_arrays(states, actions), Candidates(points, radius=2.0)


def peak_megabytes() -> float:
    """Largest resident memory of this process so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
