"""Gaussian-process dynamic programming as it is written down: a goal at a time, a regression at a time, no reuse."""

from __future__ import annotations

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF


def values_of(support, ahead, rewards, actions, discount, length, noise, sweeps):
    """(n,) values of one goal after some sweeps from zero, refitting a Gaussian process in every one of them.

    ``ahead`` (n·actions, e) are the states that actions lead to, ``rewards`` (n·actions,) what they earn.
    """
    values = np.zeros(len(support))
    for _ in range(sweeps):
        process = GaussianProcessRegressor(RBF(length), alpha=noise, optimizer=None).fit(support, values)
        worth = np.empty((len(support), actions))
        for i in range(len(support)):
            after = process.predict(ahead[i * actions : (i + 1) * actions])
            for u in range(actions):
                kept = min(max(after[u], 0.0), 1.0)
                worth[i, u] = (1 - discount) * rewards[i * actions + u] + discount * kept
        values = worth.max(axis=1)
    return values


def riccati(a, b, state_cost, action_cost, discount, sweeps=10_000):
    """P of the value −xᵀPx of min Σ γᵗ(xᵀQx + uᵀRu) under x' = Ax + Bu, by the recursion itself."""
    p = np.zeros_like(state_cost)
    for _ in range(sweeps):
        inner = action_cost + discount * b.T @ p @ b
        gain = np.linalg.solve(inner, discount * b.T @ p @ a)
        new = state_cost + discount * a.T @ p @ a - discount * a.T @ p @ b @ gain
        if np.abs(new - p).max() < 1e-14:
            return new
        p = new
    return p
