"""Points and values to learn from, and one covariance as scikit-learn's and as the oracle's."""

from __future__ import annotations

import numpy as np
from sklearn.gaussian_process.kernels import RBF, ConstantKernel

from tests.oracles.gaussian_regression import squared_exponential

DEVIATION, LENGTHS, NOISE = 1.3, (0.8, 1.7), 0.05
SE = ConstantKernel(DEVIATION**2) * RBF(LENGTHS)
ORACLE = squared_exponential(DEVIATION, LENGTHS)


def points(n: int, seed: int = 0, d: int = 2) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-3, 3, size=(n, d))


def values(x: np.ndarray) -> np.ndarray:
    """(n, 2) two smooth functions."""
    return np.column_stack([np.sin(x[:, 0]) + 0.3 * x[:, 1], np.cos(0.7 * x.sum(axis=1))])
