"""Sweeps of the persistent model: linear in N, and against the same forward filter and backward draw in NumPy."""

from __future__ import annotations

import numpy as np

from benchmarks.common import Row, seconds
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.table import LogLikelihood
from subgoal.models import Persistent
from subgoal.partition.protocol import Chain
from subgoal.runtime.checks import Floats

LARGE, SMALL, G = 100_000, 10_000, 300
SWEEPS, WARMUP = 5, 10
KEEP, STEPS = 0.9, 20
LONGEST, MOST_GROWTH = 1.0, 12.0


def table(n: int) -> LogLikelihood:
    """Directions towards one of 6 of 300 places with some noise, for some 20 steps each: one trajectory."""
    generator = np.random.default_rng(0)
    points, states = generator.uniform(0, 100, (G, 2)), generator.uniform(0, 100, (n, 2))
    leg = np.cumsum(generator.random(n) < 1 / STEPS)
    way = points[generator.integers(6, size=n)[leg]] - states
    angle = np.arctan2(way[:, 1], way[:, 0]) + generator.normal(scale=0.2, size=n)
    demos = Demonstrations.from_arrays(states, np.column_stack([np.cos(angle), np.sin(angle)]), [0, n])
    likelihood = action_comparison(demos, Candidates(points, radius=2.0), confidence=5)
    likelihood.relative  # noqa: B018  (made once, before the clock starts)
    return likelihood


def sweep_seconds(likelihood: LogLikelihood, count: int) -> float:
    """Seconds of one sweep, after ``WARMUP``, over ``count`` sweeps."""
    model = Persistent()
    state = model(Chain(likelihood, 1.0, np.random.default_rng(0)), np.zeros(WARMUP, bool)).state

    def ours() -> None:
        model(Chain(likelihood, 1.0, np.random.default_rng(1), state), np.zeros(count, bool))

    return seconds(ours) / count


def numpy_pass(relative: Floats, weights: Floats, generator: np.random.Generator) -> np.ndarray:
    """θ given the weights, O(G) a step, as one would write it in NumPy."""
    n = len(relative)
    filtered, theta = np.empty(relative.shape), np.empty(n, np.int64)
    law = weights
    for i in range(n):
        law = (law if i == 0 else KEEP * law + (1 - KEEP) * weights) * relative[i]
        law /= law.sum()
        filtered[i] = law
    for i in range(n - 1, -1, -1):
        law = filtered[i] * (1 if i == n - 1 else (1 - KEEP) * weights[theta[i + 1]])
        if i < n - 1:
            law[theta[i + 1]] += filtered[i, theta[i + 1]] * KEEP
        theta[i] = np.searchsorted(np.cumsum(law), generator.random() * law.sum(), side="right")
    return theta


def sweeps() -> list[Row]:
    """N = 100,000 and 10,000, G = 300."""
    small = table(SMALL)
    relative = small.relative
    if relative is None:
        raise ValueError("the comparison needs a dense table")
    weights, generator = np.exp(small.log_prior), np.random.default_rng(0)
    alternative = seconds(lambda: numpy_pass(relative, weights, generator), repeats=2, warm=False)
    short, long = sweep_seconds(small, 10 * SWEEPS), sweep_seconds(table(LARGE), SWEEPS)
    return [
        Row("a sweep of Persistent, N = 100,000, G = 300", f"{long * 1e3:.0f} ms", "< 1 s", long < LONGEST,
            "NumPy at N = 10,000", alternative / short),
        Row("the same over that of N = 10,000", f"{long / short:.1f} x", "< 12 x", long / short < MOST_GROWTH),
    ]  # fmt: skip
