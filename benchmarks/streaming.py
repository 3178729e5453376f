"""What one more point of a stream costs, and that beside fitting all anew after it."""

from __future__ import annotations

import time
import warnings

import numpy as np

import subgoal
from benchmarks.common import Row
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats
from subgoal.streaming import Stream, warm
from subgoal.streaming.stream import DRAWS, THIN, WARMUP

PAIRS, RADIUS = 2000, 1.45
RATE, SPEED = 100.0, 10.0
EVERY = 5
"""Subgoals are asked for after so many points."""
SHORT, RUNS = 600, 3
MOST_POINT, MOST_END = 10.0, 100.0


def walk(points: int, seed: int = 0) -> Floats:
    """(points, 2) places of a walker that goes from one of six places to another and trembles."""
    generator = np.random.default_rng(seed)
    places, way = generator.uniform(0, 100, size=(6, 2)), np.empty((points, 2))
    at, goal = places[0], 1
    for k in range(points):
        left = places[goal] - at
        far = np.linalg.norm(left)
        at = at + left / max(far, 1e-9) * min(far, SPEED / RATE)
        goal = int(generator.integers(6)) if far < SPEED / RATE else goal
        way[k] = at
    return way + generator.normal(scale=0.02, size=way.shape)


def milliseconds(stream: Stream, places: Floats) -> Floats:
    """(points, 2) what each point took by the clock and of the processor, with the subgoals after every fifth."""
    taken = np.empty((len(places), 2))
    for k, place in enumerate(places):
        begin = np.array([time.perf_counter(), time.thread_time()])
        stream.add(k / RATE, place)
        if k % EVERY == EVERY - 1:
            stream.subgoals()
        taken[k] = 1e3 * (np.array([time.perf_counter(), time.thread_time()]) - begin)
    return taken


def best_of(runs: int, places: Floats) -> tuple[Stream, Floats]:
    """The stream, and the best of equal runs for each point, as in ``milliseconds``."""
    streams = [Stream(2, radius=RADIUS) for _ in range(runs)]
    return streams[0], np.min([milliseconds(stream, places) for stream in streams], axis=0)


def refit(stream: Stream) -> float:
    """Milliseconds of the same posterior from nothing, with the draws and sweeps of ``Stream.posterior``."""
    begin = time.perf_counter()
    likelihood = subgoal.action_comparison(stream.demonstrations(), stream.candidates())
    subgoal.subgoals(subgoal.sample(likelihood, draws=DRAWS, warmup=WARMUP, thin=THIN))
    return 1e3 * (time.perf_counter() - begin)


def points() -> list[Row]:
    """Up to 2,000 pairs and some 300 candidates, 100 points a second made into 20 pairs a second."""
    warm()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        short = Stream(2, radius=RADIUS)
        milliseconds(short, walk(SHORT))
        begin = time.perf_counter()
        short.lift()
        subgoal.subgoals(short.posterior())
        end = 1e3 * (time.perf_counter() - begin)
        long, taken = best_of(RUNS, walk(int(PAIRS * RATE / 20)))
        anew = refit(long)
    middle, high, most = np.median(taken[:, 0]), np.quantile(taken[:, 0], 0.95), taken[:, 1].max()
    size = f"N to {long.n_pairs:,}, G to {long.candidates().n_candidates}"
    return [
        Row(f"a streamed point, 95 % of them, {size}", f"{high:.1f} ms", "< 10 ms", bool(high < MOST_POINT),
            "fitted anew", float(anew / high)),
        Row("the same, the median", f"{middle:.2f} ms", "< 10 ms", bool(middle < MOST_POINT), "fitted anew",
            float(anew / middle)),
        Row("the same, the slowest, processor time", f"{most:.1f} ms", "< 10 ms", bool(most < MOST_POINT)),
        Row("posterior and subgoals after 600 points", f"{end:.0f} ms", "< 100 ms", end < MOST_END),
    ]  # fmt: skip


if __name__ == "__main__":
    for row in points():
        print(row)
