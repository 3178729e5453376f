"""Slow and obvious: blocked draws of rows from given weights and uniform numbers. Imports nothing from the package."""

from __future__ import annotations

import numpy as np


def assignment_law(log_row: np.ndarray, log_weights: np.ndarray) -> np.ndarray:
    """(G,) P(θ = g) ∝ w_g L_g, in extended precision."""
    terms = np.asarray(log_row, np.longdouble) + np.asarray(log_weights, np.longdouble)
    share = np.exp(terms - terms.max())
    return np.asarray(share / share.sum(), float)


def inverse_draw(log_row: np.ndarray, log_weights: np.ndarray, uniform: float) -> int:
    """The candidate at which the distribution function passes ``uniform``."""
    return int(np.searchsorted(np.cumsum(assignment_law(log_row, log_weights)), uniform, side="right"))


def draw_all(log_table: np.ndarray, log_weights: np.ndarray, uniforms: np.ndarray) -> tuple[np.ndarray, float]:
    """Counts (G,) and Σ ℓ[i, θ_i] of one chain."""
    theta = [inverse_draw(row, log_weights, u) for row, u in zip(log_table, uniforms, strict=True)]
    fit = sum(float(row[g]) for row, g in zip(log_table, theta, strict=True))
    return np.bincount(theta, minlength=log_table.shape[1]), fit


def direction_log_share(state, unit, goal, alpha: float, near: float, log_uniform_share: float) -> float:
    """−α‖u − û‖, or the given number near the goal and for a direction of length 0."""
    way = np.asarray(goal, float) - np.asarray(state, float)
    distance = float(np.sqrt((way**2).sum()))
    if distance <= near or not np.any(unit):
        return log_uniform_share
    return -alpha * float(np.sqrt(((np.asarray(unit) - way / distance) ** 2).sum()))
