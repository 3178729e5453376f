"""Normalisers of exp(−α·distance): over the unit sphere (directions) and over R^k (any other action)."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid, quad
from scipy.special import gammainc, gammaln

from subgoal.runtime.checks import Floats

SMALL_CONFIDENCE = 1e-3


def log_sphere_area(dimension: int) -> float:
    """log of the area of the unit sphere in ``dimension`` dimensions (2 points in 1-D, 2π in 2-D, 4π in 3-D)."""
    return float(math.log(2) + 0.5 * dimension * math.log(math.pi) - gammaln(dimension / 2))


def log_direction_normalisers(confidence: Floats, dimension: int) -> Floats:
    """``log_direction_normaliser`` of each of several confidences."""
    different, where = np.unique(confidence, return_inverse=True)
    return np.array([log_direction_normaliser(alpha, dimension) for alpha in different.tolist()])[where]


@lru_cache(maxsize=2**16)
def log_direction_normaliser(confidence: float, dimension: int) -> float:
    """log ∫ exp(−α‖u − û‖) du over the unit sphere, for any û.

    1 + e^{−2α} in 1-D; 2π[1 − (1+2α)e^{−2α}]/α² in 3-D, by its series below α = 1e-3; quadrature over the polar angle
    in the other dimensions, where ‖u − û‖ = 2 sin(φ/2).
    """
    if dimension == 1:
        return math.log1p(math.exp(-2 * confidence))
    if dimension == 3:
        return _log_normaliser_3d(confidence)

    def density(angle: float) -> float:
        return math.exp(-2 * confidence * math.sin(angle / 2)) * math.sin(angle) ** (dimension - 2)

    scale = max(dimension - 1, 1) / max(confidence, 1e-300)
    breaks = [point for point in (scale, 5 * scale, 25 * scale) if point < math.pi]
    value, _ = quad(density, 0, math.pi, points=breaks or None, epsabs=0, epsrel=1e-12, limit=200)
    return math.log(value) + log_sphere_area(dimension - 1)


def _log_normaliser_3d(confidence: float) -> float:
    if confidence < SMALL_CONFIDENCE:
        x = 2 * confidence
        return math.log(8 * math.pi * (1 / 2 - x / 3 + x**2 / 8 - x**3 / 30 + x**4 / 144))
    return math.log(2 * math.pi / confidence**2) + math.log(
        -math.expm1(-2 * confidence) - 2 * confidence * math.exp(-2 * confidence)
    )


def log_action_normaliser(confidence: Any, dimension: int, scale: float, log_weights: float) -> Any:
    """log ∫ exp(−α‖w∘(a − a_CL)‖/scale) da over R^k, ``log_weights`` = Σ log w: S_{k−1} Γ(k) (scale/α)^k / Π w."""
    radial = float(gammaln(dimension)) + dimension * (math.log(scale) - np.log(confidence))
    return log_sphere_area(dimension) + radial - log_weights


def log_ball_volume(dimension: int, radius: float, log_weights: float) -> float:
    """log volume of {a : ‖w∘a‖ ≤ radius} in R^k."""
    return log_sphere_area(dimension) - math.log(dimension) + dimension * math.log(radius) - log_weights


def sum_log(weights: Floats) -> float:
    """Σ log w."""
    return float(np.log(weights).sum())


def direction_distance_cdf(distance: Floats, confidence: float, dimension: int) -> Floats:
    """P(‖u − û‖ ≤ r) for r in [0, 2] under exp(−α‖u − û‖) on the unit sphere."""
    if dimension == 1:
        stay = 1 / (1 + math.exp(-2 * confidence))
        return np.where(np.asarray(distance) >= 2, 1.0, stay)
    angle = np.unique(np.concatenate([np.linspace(0, np.pi, 20_001), np.geomspace(1e-14, np.pi, 20_001)]))
    density = np.exp(-2 * confidence * np.sin(angle / 2)) * np.sin(angle) ** (dimension - 2)
    mass = cumulative_trapezoid(density, angle, initial=0)
    at = 2 * np.arcsin(np.clip(np.asarray(distance) / 2, 0, 1))
    return np.asarray(np.interp(at, angle, mass / mass[-1]))


def action_distance_cdf(distance: Floats, confidence: float, dimension: int) -> Floats:
    """P(‖a − a_CL‖/scale ≤ r) under exp(−α r) over R^k: a Gamma law of shape k and rate α."""
    return np.asarray(gammainc(dimension, confidence * np.asarray(distance)))
