"""A base with finitely many parameters, so that every state of a sampler can be listed."""

from __future__ import annotations

from typing import Any

import numpy as np


class FiniteBase:
    """Candidates g with probability p_g and a table of log likelihoods (N, G); a point is its row number (N, 1)."""

    def __init__(self, table: np.ndarray, prior: np.ndarray) -> None:
        self.table, self.prior = table, prior
        self.points = np.arange(float(len(table)))[:, None]
        self.parameters = np.arange(float(len(prior)))[:, None]

    def statistics(self, points: Any) -> np.ndarray:
        return self.table[points[:, 0].astype(int)]

    def _posterior(self, totals: np.ndarray) -> np.ndarray:
        return np.exp(totals) * self.prior

    def log_marginal_of(self, totals: np.ndarray) -> np.ndarray:
        return np.log(self._posterior(totals).sum(axis=1))

    def draw_given(self, totals: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        edges = np.cumsum(self._posterior(totals), axis=1)
        return (generator.random((len(totals), 1)) * edges[:, -1:] > edges).sum(axis=1, keepdims=True).astype(float)

    def log_likelihood(self, points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        return self.statistics(points)[:, parameters[:, 0].astype(int)]


def a_base(n: int, candidates: int) -> FiniteBase:
    """A committed table: peaked, so that wrong moves show."""
    rows, columns = np.indices((n, candidates))
    table = -3.0 * np.abs(np.sin(1.3 * rows + 2.1 * columns + 0.4 * rows * columns))
    weights = np.arange(1.0, candidates + 1)
    return FiniteBase(table, weights / weights.sum())
