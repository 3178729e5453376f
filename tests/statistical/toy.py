"""A discrete world whose every law is known: outcomes y_i ~ B[θ_i], candidates from the finite Dirichlet mixture.

Imports nothing from the package.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.oracles.finite_mixture import draw_assignment


@dataclass(frozen=True)
class PlainTable:
    """What a sampler sees of a likelihood, as bare arrays: (N, G) log densities and the (G,) prior."""

    dense: np.ndarray
    log_prior: np.ndarray

    @property
    def n_observations(self) -> int:
        return len(self.dense)

    @property
    def n_candidates(self) -> int:
        return self.dense.shape[1]

    @property
    def relative(self) -> np.ndarray:
        likelihood = np.exp(self.dense)
        return likelihood / (likelihood @ np.exp(self.log_prior))[:, None]

    @property
    def edges(self) -> np.ndarray:
        """Two blocks of rows."""
        return np.array([0, len(self.dense) // 2, len(self.dense)])

    def relative_tile(self, start: int, tile: np.ndarray) -> np.ndarray:
        return self.relative[start : start + len(tile)]

    def tiles(self) -> Iterator[tuple[int, np.ndarray]]:
        for start, stop in pairwise(self.edges.tolist()):
            yield start, self.dense[start:stop]


@dataclass(frozen=True)
class Toy:
    """``emission`` (G, M) P(y | g), ``prior`` (G,), η and N."""

    emission: np.ndarray
    prior: np.ndarray
    eta: float
    n: int

    def theta(self, generator: np.random.Generator) -> np.ndarray:
        return draw_assignment(self.n, self.eta, self.prior, generator)

    def outcomes(self, theta: np.ndarray, generator: np.random.Generator) -> np.ndarray:
        """(N,) one outcome per observation."""
        cumulative = np.cumsum(self.emission[theta], axis=1)
        return (generator.random(self.n)[:, None] * cumulative[:, -1:] > cumulative).sum(axis=1)

    def table(self, outcomes: np.ndarray) -> PlainTable:
        return PlainTable(np.ascontiguousarray(np.log(self.emission[:, outcomes]).T), np.log(self.prior))

    def log_joint(self, theta: np.ndarray, outcomes: np.ndarray) -> tuple[float, float]:
        """log p(θ, y) and log p(y | θ), by the urn."""
        fit = float(np.log(self.emission[theta, outcomes]).sum())
        seen = np.zeros(self.prior.size)
        prior = 0.0
        for i, g in enumerate(theta):
            prior += np.log((seen[g] + self.eta * self.prior[g]) / (i + self.eta))
            seen[g] += 1
        return fit + prior, fit

    def summaries(self, theta: np.ndarray, outcomes: np.ndarray) -> tuple[float, float, float, float, float]:
        """log joint, log likelihood, K, n_1, and the number of equal neighbours (order matters to it)."""
        joint, fit = self.log_joint(theta, outcomes)
        return joint, fit, np.unique(theta).size, (theta == 0).sum(), (theta[1:] == theta[:-1]).sum()


NAMES = ("log joint", "log likelihood", "K", "n_1", "equal neighbours")


def peaked(g_count: int, outcomes: int, n: int, eta: float) -> Toy:
    """Candidate g mostly gives outcome g mod M; an uneven prior."""
    emission = np.full((g_count, outcomes), 0.3 / (outcomes - 1))
    emission[np.arange(g_count), np.arange(g_count) % outcomes] = 0.7
    emission *= np.random.default_rng(0).uniform(0.6, 1.4, emission.shape)
    prior = np.arange(g_count, 0, -1.0)
    return Toy(emission / emission.sum(axis=1, keepdims=True), prior / prior.sum(), eta, n)
