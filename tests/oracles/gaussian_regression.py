"""Slow and obvious: Gaussian-process regression by explicit inverses and determinants. Imports nothing of the package.

Covariances are plain functions of two points.
"""

from __future__ import annotations

import math

import numpy as np


def squared_exponential(deviation, lengths):
    """(2.14) as a function of two points."""

    def covariance(x, y):
        return deviation**2 * math.exp(-0.5 * sum(((a - b) / s) ** 2 for a, b, s in zip(x, y, lengths, strict=True)))

    return covariance


def gram(covariance, left, right):
    """Entry by entry."""
    return np.array([[covariance(x, y) for y in right] for x in left])


def weights(covariance, points, noise, at):
    """K(at, X)(K + σ²I)⁻¹."""
    inverse = np.linalg.inv(gram(covariance, points, points) + noise * np.eye(len(points)))
    return gram(covariance, at, points) @ inverse


def mean(covariance, points, values, noise, at, centre=0.0):
    """(2.12)."""
    return centre + weights(covariance, points, noise, at) @ (values - centre)


def variance(covariance, points, noise, at):
    """(2.13), one place at a time."""
    inverse = np.linalg.inv(gram(covariance, points, points) + noise * np.eye(len(points)))
    found = []
    for x in at:
        k = gram(covariance, [x], points)[0]
        found.append(covariance(x, x) - k @ inverse @ k)
    return np.array(found)


def log_normal(values, matrix):
    """log N(values | 0, matrix)."""
    quadratic = values @ np.linalg.inv(matrix) @ values
    return -0.5 * (quadratic + math.log(np.linalg.det(matrix)) + len(values) * math.log(2 * math.pi))


def log_evidence(covariance, points, values, noise, centre=0.0):
    """(2.15) of one column, with its constant."""
    return log_normal(values - centre, gram(covariance, points, points) + noise * np.eye(len(points)))


def projected(covariance, points, inducing, at=None):
    """Q = K(at, Z) K(Z, Z)⁻¹ K(Z, X): what the inducing points carry."""
    left = points if at is None else at
    inner = np.linalg.inv(gram(covariance, inducing, inducing))
    return gram(covariance, left, inducing) @ inner @ gram(covariance, inducing, points)


def evidence_bound(covariance, points, values, noise, inducing, centre=0.0):
    """Titsias (2009): log N(y | m, Q + σ²I) − tr(K − Q)/(2σ²)."""
    carried = projected(covariance, points, inducing)
    lost = sum(covariance(x, x) for x in points) - np.trace(carried)
    return log_normal(values - centre, carried + noise * np.eye(len(points))) - lost / (2 * noise)


def sparse_mean(covariance, points, values, noise, inducing, at, centre=0.0):
    """Q(at, X)(Q + σ²I)⁻¹(y − m) + m."""
    matrix = projected(covariance, points, inducing) + noise * np.eye(len(points))
    return centre + projected(covariance, points, inducing, at) @ np.linalg.inv(matrix) @ (values - centre)


def sparse_variance(covariance, points, noise, inducing, at):
    """k(x, x) − Q(x, x) + what the data leave open of the inducing values: K(x, Z)(K_ZZ + K_ZX K_XZ/σ²)⁻¹K(Z, x)."""
    crossed = gram(covariance, inducing, points)
    inner = gram(covariance, inducing, inducing)
    left = np.linalg.inv(inner + crossed @ crossed.T / noise)
    found = []
    for x in at:
        k = gram(covariance, [x], inducing)[0]
        found.append(covariance(x, x) - k @ np.linalg.inv(inner) @ k + k @ left @ k)
    return np.array(found)


def greedily_kept(matrix, noise, values):
    """Rows kept, in order, and the mean they give: ends first, then the worst, until none is off by more than 1."""
    n, kept = len(values), []
    mean_now = np.zeros_like(values)
    while len(kept) < n and (len(kept) < 2 or np.abs(values - mean_now).max() > 1):
        error = np.abs(values - mean_now).max(axis=1)
        error[kept] = -1
        kept.append([0, n - 1][len(kept)] if len(kept) < 2 else int(error.argmax()))
        inverse = np.linalg.inv(matrix[np.ix_(kept, kept)] + noise * np.eye(len(kept)))
        mean_now = matrix[:, kept] @ inverse @ values[kept]
    return kept, mean_now
