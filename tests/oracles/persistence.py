"""Subgoals that persist, by enumeration: every path, and every choice of where it redraws. No package code."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from tests.oracles.partitions import urn_probability

State = tuple[tuple[int, ...], tuple[bool, ...]]


def paths(n: int, g_count: int, starts: Sequence[int]) -> list[State]:
    """All (θ, redrawn) that are possible: a step that keeps has the subgoal of the step before."""
    found = []
    for theta in itertools.product(range(g_count), repeat=n):
        for redrawn in itertools.product((False, True), repeat=n):
            if all(redrawn[i] for i in starts) and all(redrawn[i] or theta[i] == theta[i - 1] for i in range(n)):
                found.append((theta, redrawn))
    return found


def step_probability(state: State, starts: Sequence[int], keep: float, keep_there: float, arrived: np.ndarray) -> float:
    """Π of ρ for steps that keep and 1 − ρ for steps that redraw, first steps left out."""
    theta, redrawn = state
    value = 1.0
    for i in range(len(theta)):
        if i not in starts:
            stay = keep_there if arrived[i, theta[i - 1]] else keep
            value *= 1 - stay if redrawn[i] else stay
    return value


def beta_probability(state: State, starts: Sequence[int], a: float, b: float) -> float:
    """The same with ρ ~ Beta(a, b) integrated out, the same everywhere."""
    kept = sum(not r for r in state[1])
    left = sum(r for i, r in enumerate(state[1]) if i not in starts)
    return math.exp(
        math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b)
        + math.lgamma(a + kept) + math.lgamma(b + left) - math.lgamma(a + b + kept + left)
    )  # fmt: skip


def fit(theta: Sequence[int], log_table: np.ndarray) -> float:
    """Π L_ig."""
    return math.exp(sum(log_table[i, g] for i, g in enumerate(theta)))


def redraw_probability(state: State, eta: float, prior: Sequence[float]) -> float:
    """The urn over the redrawn subgoals, the weights integrated out."""
    theta, redrawn = state
    return urn_probability([g for g, r in zip(theta, redrawn, strict=True) if r], eta, prior)


def given_weights(
    log_table: np.ndarray, starts: Sequence[int], weights: np.ndarray, keep: float, keep_there: float,
    arrived: np.ndarray,
) -> dict[State, float]:  # fmt: skip
    """p(θ, redrawn | O, w, ρ)."""
    n, g_count = log_table.shape
    value = {
        state: fit(state[0], log_table) * step_probability(state, starts, keep, keep_there, arrived)
        * math.prod(weights[g] for g, r in zip(*state, strict=True) if r)
        for state in paths(n, g_count, starts)
    }  # fmt: skip
    total = sum(value.values())
    return {state: p / total for state, p in value.items()}


def posterior(
    log_table: np.ndarray, starts: Sequence[int], eta: float, prior: Sequence[float], step: object
) -> dict[State, float]:
    """p(θ, redrawn | O) with the weights integrated out; ``step(state)`` is the probability of its redraws."""
    n, g_count = log_table.shape
    value = {
        state: fit(state[0], log_table) * step(state) * redraw_probability(state, eta, prior)  # type: ignore[operator]
        for state in paths(n, g_count, starts)
    }
    total = sum(value.values())
    return {state: p / total for state, p in value.items()}
