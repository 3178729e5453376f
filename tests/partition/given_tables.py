"""Tables of random and awkward numbers for the companions of the mixture."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood


def held(log_table: np.ndarray, prior: np.ndarray | None = None, **fields: object) -> LogLikelihood:
    """A table of given numbers, with a prior over its columns."""
    g_count = np.asarray(log_table).shape[1]
    log_prior = None if prior is None else np.log(prior)
    candidates = Candidates(points=np.arange(g_count, dtype=float)[:, None], log_prior=log_prior)
    return LogLikelihood.from_table(log_table, candidates=candidates, **fields)


def directions(n: int, g_count: int, seed: int, confidence: float = 3.0) -> np.ndarray:
    """(n, G) log densities of noisy planar directions towards a ring of places: neighbours are near-duplicates."""
    generator = np.random.default_rng(seed)
    angle = 2 * np.pi * np.arange(g_count) / g_count
    places = 10 * np.column_stack([np.cos(angle), np.sin(angle)])
    at = generator.normal(scale=4.0, size=(n, 2))
    true = places[generator.choice(g_count, min(3, g_count), replace=False)]
    way = true[generator.integers(len(true), size=n)] - at
    heading = np.arctan2(way[:, 1], way[:, 0]) + generator.normal(scale=0.3, size=n)
    wanted = np.arctan2(places[None, :, 1] - at[:, 1:], places[None, :, 0] - at[:, :1])
    return -confidence * 2 * np.abs(np.sin((heading[:, None] - wanted) / 2))


def problems() -> Iterator[tuple[str, np.ndarray]]:
    """Two dozen (N, G) tables."""
    for seed in range(6):
        generator = np.random.default_rng(seed)
        n, g_count = generator.integers(2, 80), generator.integers(2, 30)
        yield f"normal {seed}", generator.normal(scale=2.0, size=(n, g_count))
    for seed in range(6):
        yield f"directions {seed}", directions(60 + 10 * seed, 20 + 10 * seed, seed)
    for seed in range(3):
        generator = np.random.default_rng(100 + seed)
        table = generator.normal(size=(40, 12))
        yield f"near duplicates {seed}", np.hstack([table, table + 1e-7 * generator.normal(size=table.shape)])
        yield f"duplicates {seed}", np.hstack([table, table[:, ::-1]])
        table = table.copy()
        table[generator.random(table.shape) < 0.6] = -np.inf
        table[np.isneginf(table).all(axis=1), 0] = 0.0
        yield f"impossible {seed}", table
        yield f"fewer observations than candidates {seed}", generator.normal(scale=3.0, size=(5, 40))
    generator = np.random.default_rng(200)
    yield "one candidate", generator.normal(size=(9, 1))
    yield "one observation", generator.normal(size=(1, 9))
    yield "one of each", np.zeros((1, 1))
    yield "flat", np.zeros((7, 5))
    yield "rows of every scale", generator.normal(size=(30, 8)) + generator.uniform(-900, 900, size=(30, 1))
    yield "each its own", np.where(np.eye(12, dtype=bool), 0.0, -np.inf)
