"""From a file with a hand-held demonstration to subgoals, and to a flight: what Figures 7-2, 7-3 and 7-4 share.

The settings are the defaults of the library (confidence 3, concentration 1, net of 3 % of the extent); a radian counts
as ``LENGTH`` metres. Every stage is timed.
"""

from __future__ import annotations

import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pandas as pd

from experiments.common import Headline
from subgoal.answers.subgoals import COUNTED_FROM, Subgoal, Subgoals, reaches, subgoals
from subgoal.candidates import epsilon_net
from subgoal.demonstrations import pose_metric
from subgoal.demonstrations.read import read
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.flight import Flight, Tracking, Waypoints, fly, tracking, waypoints
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats

LENGTH = 0.3
RATE = 20.0
"""Hz, after down-sampling."""
NEAR = 0.1
"""Metres from a corner within which a subgoal is at it."""
SEEDS, QUICK_SEEDS = 25, 3
Outcome = TypeVar("Outcome")


@dataclass(frozen=True)
class Learned:
    """What one demonstration gave, and the seconds of each stage."""

    demonstrations: Demonstrations
    posterior: Posterior
    found: Subgoals
    seconds: dict[str, float]

    @property
    def main(self) -> tuple[Subgoal, ...]:
        """Subgoals with at least 5 % of the observations."""
        return tuple(goal for goal in self.found if reaches(goal.share, COUNTED_FROM))

    @property
    def places(self) -> Floats:
        """(K, 3) of the main subgoals."""
        return np.array([goal.position for goal in self.main])


@dataclass(frozen=True)
class Flown:
    """The flight of what was learned."""

    waypoints: Waypoints
    flight: Flight
    tracking: Tracking
    seconds: dict[str, float]


class Clock:
    """Seconds of each stage that is named when it ends."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """The time since the last lap was spent on ``stage``."""
        now = time.perf_counter()
        self.seconds[stage] = now - self._last
        self._last = now


def learn(recording: Recording, seed: int, **sampling: Any) -> Learned:
    """Through a CSV file, as a user has it, to subgoals; ``sampling`` are settings of ``sample``."""
    table = pd.DataFrame(recording.positions, columns=list(recording.names)).assign(t=recording.times)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "hand.csv"
        table.to_csv(path, index=False)
        clock = Clock()
        demos = read(path, position=recording.names, time="t", units="m", rate=RATE, period=recording.period)
    clock.lap("read")
    likelihood = action_comparison(demos, epsilon_net(demos, metric=pose_metric(LENGTH, planar=True)))
    clock.lap("table")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        posterior = sample(likelihood, seed=seed, **sampling)
    clock.lap("sample")
    found = subgoals(posterior)
    clock.lap("subgoals")
    return Learned(demos, posterior, found, clock.seconds)


def flown(learned: Learned, **settings: Any) -> Flown:
    """The subgoals flown as waypoints in the order of the demonstration."""
    clock = Clock()
    route = waypoints(learned.posterior, found=learned.found, **settings)
    clock.lap("waypoints")
    flight = fly(route, plane="yz")
    clock.lap("fly")
    return Flown(route, flight, tracking(flight, learned.demonstrations), clock.seconds)


def misses(places: Floats, corners: Floats) -> Floats:
    """(W,) distance of the nearest subgoal (K, 2 or more) to each corner (W, 2); infinity where there are none."""
    if not len(places):
        return np.full(len(corners), np.inf)
    return np.asarray(np.linalg.norm(places[:, None, :2] - corners, axis=-1).min(axis=0))


def over_seeds(seeds: range, one: Callable[[int], Outcome]) -> list[Outcome]:
    """The outcome of each seed, the first of them learned twice: it pays for what is compiled or imported once."""
    one(seeds[0])
    return [one(seed) for seed in seeds]


def stages(each: list[dict[str, float]]) -> Headline:
    """Median seconds of each stage, and the median and greatest sum."""
    total = [sum(seconds.values()) for seconds in each]
    return {
        **{stage: float(np.median([seconds[stage] for seconds in each])) for stage in each[0]},
        "total": float(np.median(total)), "most": max(total),
    }  # fmt: skip
