"""Hand-held demonstrations of a square and of a flip, and posteriors made of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.poses import pose_metric
from subgoal.flight import Waypoints
from subgoal.posterior.posterior import Posterior
from tests.answers.made import posterior_of
from tests.posterior.worlds import quiet_sample

TURN = 2 * np.pi
SIDE, SPEED, LEAST, RATE = 1.5, 0.4, 0.5, 20.0
CORNERS = np.array([[0.0, 0.0], [SIDE, 0.0], [SIDE, SIDE], [0.0, SIDE]]) + np.array([0.0, LEAST])
RADIUS = 0.45


def recorded(positions: np.ndarray, names: tuple[str, ...], period: tuple[float, ...] = ()) -> subgoal.Recording:
    """Positions (M, d) at 20 Hz as one recording in metres."""
    times = np.arange(len(positions)) / RATE
    return subgoal.Recording(positions, times, np.array([0, len(times)]), names, "m", period=period)


def along(corners: np.ndarray, seed: int = 0) -> np.ndarray:
    """(M, d) from corner to corner (W, d) at even speed, with 2 mm of tremor."""
    legs = []
    for a, b in pairwise(corners):
        steps = int(np.linalg.norm(b - a) / SPEED * RATE)
        legs.append(a + (b - a) * np.arange(steps)[:, None] / steps)
    path = np.vstack([*legs, corners[-1:]])
    return path + 0.002 * np.random.default_rng(seed).standard_normal(path.shape)


def square_path(rounds: int = 1) -> np.ndarray:
    """(M, 2) around the square, from the first corner back to it."""
    return along(CORNERS[np.append(np.tile(np.arange(4), rounds), 0)])


def flip_path(rounds: int = 1, turn: int = 1, width: float = RADIUS) -> np.ndarray:
    """(M, 3) round a loop by hand: y, z and an angle that is that of the loop; level for a second at its ends."""
    angle = np.concatenate([np.zeros(20), np.linspace(0, TURN * rounds, 90 * rounds), np.full(20, TURN * rounds)])
    noise = np.random.default_rng(1).standard_normal((angle.size, 3)) * [0.002, 0.002, 0.01]
    return np.column_stack([
        turn * width * np.sin(angle), LEAST + RADIUS - RADIUS * np.cos(angle), turn * angle
    ]) + noise  # fmt: skip


@cache
def square(rounds: int = 1) -> Posterior:
    """Posterior of the square."""
    demos = subgoal.demonstrate(recorded(square_path(rounds), ("y", "z")))
    table = subgoal.action_comparison(demos, subgoal.epsilon_net(demos, 0.1), confidence=5.0)
    return quiet_sample(table, draws=60, warmup=60, thin=1, seed=0)


@cache
def flip(rounds: int = 1, turn: int = 1, width: float = RADIUS) -> Posterior:
    """Posterior of the flip, places at the bottom, at the top and half-way up."""
    metric = pose_metric(0.3, planar=True)
    demos = subgoal.demonstrate(recorded(flip_path(rounds, turn, width), ("y", "z", "angle"), tuple(metric.period)))
    table = subgoal.action_comparison(demos, subgoal.epsilon_net(demos, 0.25, metric=metric), confidence=5.0)
    return quiet_sample(table, draws=60, warmup=60, thin=1, seed=0)


def served(runs: str, points: np.ndarray, *, angles: bool = False, offset: list[int] | None = None) -> Posterior:
    """A posterior sure of itself: "0*9 2*1 1*9" is nine observations that serve place 0, one that serves 2, and so on.

    Each run is a straight way from where the last one ended, at the place it serves; the last of ``points`` (G, d) is
    where the first begins.
    """
    steps = [tuple(map(int, run.split("*"))) for run in runs.split()]
    theta = np.repeat([g for g, _ in steps], [n for _, n in steps])
    here, parts = points[-1], []
    for g, n in steps:
        parts.append(here + (points[g] - here) * np.arange(1, n + 1)[:, None] / n)
        here = points[g]
    states = np.vstack([points[-1:], *parts])[:-1]
    period = np.array([np.inf, np.inf, TURN]) if angles else np.full(points.shape[1], np.inf)
    metric = Metric(np.ones(points.shape[1]), period)
    made = posterior_of(theta[None], Candidates(points[:-1], metric=metric))
    demos = subgoal.Demonstrations.from_arrays(
        states, np.ones_like(states), [0, len(theta)] if offset is None else offset, units="m",
        names=("y", "z", "angle")[: points.shape[1]],
    )  # fmt: skip
    return replace(made, demonstrations=demos)


def loop(turn: int = 1, radius: float = RADIUS, roundness: float = 1.0) -> Waypoints:
    """Bottom and top of a loop, level and inverted."""
    return Waypoints(
        np.array([[0.0, LEAST, 0.0], [0.0, LEAST + 2 * radius, np.pi]]), cyclic=True, dimensions=("y", "z", "angle"),
        units="m", period=(np.inf, np.inf, TURN), turns=np.array([turn * np.pi, turn * np.pi]),
        roundness=roundness,
    )  # fmt: skip
