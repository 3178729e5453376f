"""Three ways to learn by how much a state changes in one step: a ridge, near observations, Gaussian processes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.neighbors import KNeighborsRegressor

from subgoal.gaussian.regression import GaussianProcess, fit
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.seeds import stream

RIDGE = 1e-8
"""Of the mean squares of standardised inputs: enough for inputs that depend on each other, too little to shrink."""
NEIGHBOURS = 5
MOST_POINTS = 600
MOST_FITTED = 200
"""Of the points, how many the hyper-parameters are learned from."""
TILE = 4096


class Model(Protocol):
    """By how much a state changes in one step."""

    def increments(self, at: Floats) -> Floats:
        """(B, d) mean increments at inputs (B, e + k)."""
        ...


@dataclass(frozen=True, eq=False)
class Affine:
    """Increments x W + c: ``weights`` (e + k, d), ``constant`` (d,)."""

    weights: Floats
    constant: Floats

    def increments(self, at: Floats) -> Floats:
        """(B, d)."""
        return np.asarray(at @ self.weights + self.constant)


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Mean increment of the five nearest observations, weighed by 1 / distance, each input in its own spread."""

    regressor: KNeighborsRegressor
    spread: Floats

    def increments(self, at: Floats) -> Floats:
        """(B, d)."""
        return np.asarray(self.regressor.predict(at / self.spread))


@dataclass(frozen=True, eq=False)
class Processes:
    """A Gaussian process for each dimension, its increments in units of ``scale`` (d,) about ``mean`` (d,).

    ``centre`` and ``spread`` (e + k,) standardise the inputs.
    """

    processes: tuple[GaussianProcess, ...]
    centre: Floats
    spread: Floats
    mean: Floats
    scale: Floats

    def increments(self, at: Floats) -> Floats:
        """(B, d)."""
        told = [self._tiled(process.mean, at) for process in self.processes]
        return np.asarray(np.stack(told, axis=1) * self.scale + self.mean)

    def variances(self, at: Floats) -> Floats:
        """(B, d) of an increment that is observed, noise included."""
        told = [self._tiled(process.variance, at) + process.noise for process in self.processes]
        return np.asarray(np.stack(told, axis=1) * self.scale**2)

    def _tiled(self, function: Any, at: Floats) -> Floats:
        tiles = range(0, max(len(at), 1), TILE)
        return np.concatenate([function((at[k : k + TILE] - self.centre) / self.spread) for k in tiles])


def learn_affine(at: Floats, increments: Floats, seed: int) -> Affine:
    """Least squares with a ridge of 1e-8 in standardised inputs."""
    centre, spread = at.mean(axis=0), at.std(axis=0)
    standard = (at - centre) / spread
    mean = increments.mean(axis=0)
    gram = standard.T @ standard / len(at) + RIDGE * np.eye(at.shape[1])
    weights = np.linalg.solve(gram, standard.T @ (increments - mean) / len(at)) / spread[:, None]
    return Affine(weights, mean - centre @ weights)


def learn_neighbours(at: Floats, increments: Floats, seed: int) -> Neighbours:
    """All observations are kept."""
    spread = at.std(axis=0)
    regressor = KNeighborsRegressor(min(NEIGHBOURS, len(at)), weights="distance")
    return Neighbours(regressor.fit(at / spread, increments), spread)


def learn_processes(at: Floats, increments: Floats, seed: int) -> Processes:
    """A squared exponential with a length per input, and noise, of at most 600 observations.

    Half of these are as far apart as can be, half drawn at random. Lengths, variance and noise of each dimension have
    the greatest evidence of 200 of them; the noise is at least 1 % of what the increments vary, in standard deviation.
    """
    centre, spread = at.mean(axis=0), at.std(axis=0)
    mean, scale = increments.mean(axis=0), _positive_spread(increments)
    standard = (at - centre) / spread
    rows = _spread_out(standard, stream(seed, 1))
    points, values = standard[rows], (increments[rows] - mean) / scale
    start = ConstantKernel(1.0, (1e-3, 1e2)) * RBF(np.full(at.shape[1], 2.0), (0.05, 1e3))
    processes = []
    for column in values.T:
        few = fit(points[:MOST_FITTED], column[:MOST_FITTED], start + WhiteKernel(0.01, (1e-4, 2.0)), seed=seed)
        processes.append(fit(points, column, few.covariance, noise=few.noise, optimise=False))
    return Processes(tuple(processes), centre, spread, mean, scale)


def _spread_out(points: Floats, generator: np.random.Generator) -> Ints:
    """Rows of at most 600 points in random order, half of them each the farthest from those before."""
    if len(points) <= MOST_POINTS:
        return generator.permutation(len(points))
    far, kept = np.full(len(points), np.inf), [int(generator.integers(len(points)))]
    while len(kept) < MOST_POINTS // 2:
        far = np.minimum(far, ((points - points[kept[-1]]) ** 2).sum(axis=1))
        kept.append(int(far.argmax()))
    others = np.setdiff1d(np.arange(len(points)), kept)
    drawn = generator.choice(others, MOST_POINTS - len(kept), replace=False)
    return generator.permutation(np.concatenate([kept, drawn]))


def _positive_spread(values: Floats) -> Floats:
    """(d,) standard deviations, 1 where there is none."""
    spread = values.std(axis=0)
    return np.where(spread > 1e-12 * (1 + np.abs(values).max(axis=0)), spread, 1.0)
