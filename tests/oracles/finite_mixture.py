"""Slow and obvious laws of the finite Dirichlet mixture: counts and number of distinct candidates. No package code."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np


def count_law(n: int, eta: float, p: float) -> np.ndarray:
    """(n+1,) P(n_1 = k): draw after draw from the urn in which candidate 1 has mass ηp."""
    law = np.array([1.0])
    for i in range(n):
        k = np.arange(law.size)
        hit = (k + eta * p) / (i + eta)
        law = np.append(law * (1 - hit), 0.0) + np.append(0.0, law * hit)
    return law


def distinct_law(n: int, eta: float, prior: Sequence[float]) -> np.ndarray:
    """(G+1,) P(K distinct candidates among n draws), by inclusion and exclusion over the candidates left out."""
    g_count = len(prior)

    def within(subset: tuple[int, ...]) -> float:
        """P(all n draws fall in ``subset``)."""
        mass = eta * sum(prior[g] for g in subset)
        return math.prod((mass + i) / (eta + i) for i in range(n))

    law = np.zeros(g_count + 1)
    for size in range(1, g_count + 1):
        for subset in itertools.combinations(range(g_count), size):
            for inner_size in range(1, size + 1):
                for inner in itertools.combinations(subset, inner_size):
                    law[size] += (-1) ** (size - inner_size) * within(inner)
    return law


def draw_assignment(n: int, eta: float, prior: np.ndarray, generator: np.random.Generator) -> np.ndarray:
    """(n,) candidates from the prior, through the weights: w ~ Dirichlet(ηp), θ_i ~ w."""
    shape = eta * np.asarray(prior)
    # Gamma(a) = Gamma(a + 1)·U^{1/a} in logs, for tiny a.
    log_weight = np.log(generator.gamma(shape + 1)) + np.log(generator.random(shape.size)) / shape
    weight = np.exp(log_weight - log_weight.max())
    return generator.choice(shape.size, size=n, p=weight / weight.sum())


def log_joint(theta: np.ndarray, log_table: np.ndarray, eta: float, prior: np.ndarray) -> tuple[float, float]:
    """log p(θ, O) and log p(O | θ)."""
    fit = float(sum(log_table[i, g] for i, g in enumerate(theta)))
    value = fit
    seen: dict[int, int] = {}
    for i, g in enumerate(theta.tolist()):
        value += math.log((seen.get(g, 0) + eta * prior[g]) / (i + eta))
        seen[g] = seen.get(g, 0) + 1
    return value, fit
