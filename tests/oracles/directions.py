"""Slow and obvious: directions and actions compared one pair at a time. Imports nothing from the package."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import quad


def sphere_area(dimension: int) -> float:
    """2 π^{d/2} / Γ(d/2)."""
    return 2 * math.pi ** (dimension / 2) / math.gamma(dimension / 2)


def integral_over_sphere(alpha: float, log_z: float, dimension: int, up_to: float = math.pi) -> float:
    """∫ exp(−α‖u − û‖ − log Z) over the cap of angle ``up_to`` around û, d at least 2."""
    shell = sphere_area(dimension - 1)

    def density(angle: float) -> float:
        chord = math.hypot(1 - math.cos(angle), math.sin(angle))
        return shell * math.sin(angle) ** (dimension - 2) * math.exp(-alpha * chord - log_z)

    middle = up_to * min(0.5, 1 / alpha)
    return sum(quad(density, a, b, epsabs=1e-13, epsrel=1e-12)[0] for a, b in ((0, middle), (middle, up_to)))


def log_direction_normaliser(alpha: float, dimension: int) -> float:
    """log ∫ exp(−α‖u − û‖) du over the unit sphere."""
    if dimension == 1:
        return math.log(1 + math.exp(-2 * alpha))
    return math.log(integral_over_sphere(alpha, 0.0, dimension))


def log_direction_density(state, action, goal, alpha, weights, period, radius) -> float:
    """(5.1) with (5.2), complete: all scaled by ``weights``, periodic dimensions the shorter way round."""
    way = []
    for s, g, w, p in zip(state, goal, weights, period, strict=True):
        gap = g - s
        if math.isfinite(p):
            gap = min((gap + turn * p for turn in range(-5, 6)), key=abs)
        way.append(w * gap)
    distance = math.hypot(*way)
    if distance <= radius / 2:
        return -math.log(sphere_area(len(way)))
    done = [w * a for w, a in zip(weights, action, strict=True)]
    speed = math.hypot(*done)
    chord = math.hypot(*(a / speed - b / distance for a, b in zip(done, way, strict=True)))
    return -alpha * chord - log_direction_normaliser(alpha, len(way))


def log_sum(values: np.ndarray, log_prior: np.ndarray) -> float:
    """log Σ_g p_g exp(value_g) with every term in extended precision."""
    terms = np.asarray(values, np.longdouble) + np.asarray(log_prior, np.longdouble)
    return float(np.log(np.exp(terms - terms.max()).sum()) + terms.max())
