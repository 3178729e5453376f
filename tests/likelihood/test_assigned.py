"""Observations beside one candidate each: densities are entries of the table, scores are differences."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.likelihood.test_noise import KINDS, assignments, made


@pytest.mark.parametrize("kind", KINDS)
def test_assigned_densities_are_entries_of_the_table(kind: str) -> None:
    """At one confidence and at one for each observation; of some observations only."""
    plain = made(kind, 300)
    n, theta = plain.n_observations, assignments(plain)
    told, each = plain.source.assigned(theta), np.random.default_rng(2).uniform(0.3, 8, n)
    rows = np.arange(n)
    wanted = plain.source.log_density(0, n, 2.5)[rows, theta]
    np.testing.assert_allclose(told.log_density(2.5), wanted, rtol=1e-12, atol=1e-12)
    some = np.array([280, 7, 0, 31])
    np.testing.assert_allclose(told.some(some).log_density(2.5), wanted[some], rtol=1e-12, atol=1e-12)
    wanted = [plain.source.log_density(i, i + 1, float(each[i]))[0, theta[i]] for i in range(0, n, 10)]
    np.testing.assert_allclose(told.log_density(each)[::10], wanted, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(told.some(rows[::10]).log_density(each[::10]), wanted, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("kind", ["plain 2-D", "3-D, an angle", "weights", "direction"])
def test_scores_of_directions_are_differences_along_the_sphere(kind: str) -> None:
    """Turn the direction asked for by ±h in each of the tangents: α·cos(φ/2) towards the one taken."""
    plain = made(kind)
    told, h = plain.source.assigned(assignments(plain)), 1e-5
    alpha = np.random.default_rng(1).uniform(0.5, 6, plain.n_observations)
    score = told.score(alpha)
    generator = np.random.default_rng(4)
    for _ in range(3):
        step = generator.normal(size=told.asked.shape)
        step -= (step * told.asked).sum(axis=1)[:, None] * told.asked
        step /= np.linalg.norm(step, axis=1)[:, None]
        ahead, back = (
            replace(told, asked=math.cos(h) * told.asked + s * math.sin(h) * step).log_density(alpha) for s in (1, -1)
        )
        slope = np.where(told.flat, 0.0, (ahead - back) / (2 * h))
        np.testing.assert_allclose((score * step).sum(axis=1), slope, rtol=0, atol=2e-4)
    np.testing.assert_allclose((score * told.asked).sum(axis=1), 0, atol=1e-12)
    assert not score[told.flat].any()


def test_scores_of_actions_are_differences_of_what_is_asked() -> None:
    plain = made("action")
    told, h = plain.source.assigned(assignments(plain)), 1e-5
    alpha = np.random.default_rng(1).uniform(0.5, 6, plain.n_observations)
    score = told.score(alpha)
    for k in range(told.gap.shape[1]):
        step = h * (np.arange(told.gap.shape[1]) == k)
        slope = (replace(told, gap=told.gap - step).log_density(alpha)
                 - replace(told, gap=told.gap + step).log_density(alpha)) / (2 * h)  # fmt: skip
        np.testing.assert_allclose(score[:, k], slope, rtol=0, atol=1e-4)
    flat = replace(told, flat=np.ones_like(told.flat))
    assert not flat.score(2.0).any()
    np.testing.assert_allclose(flat.log_density(2.0), plain.source.log_flat(0, plain.n_observations))


def test_scores_of_values_are_differences_by_the_values() -> None:
    plain = made("planned")
    told, h = plain.source.assigned(assignments(plain)), 1e-6
    alpha = np.random.default_rng(1).uniform(0.5, 6, plain.n_observations)
    score = told.score(alpha)
    for a in range(told.values.shape[1]):
        step = h * (np.arange(told.values.shape[1]) == a)
        slope = (replace(told, values=told.values + step).log_density(alpha)
                 - replace(told, values=told.values - step).log_density(alpha)) / (2 * h)  # fmt: skip
        np.testing.assert_allclose(score[:, a], slope, rtol=0, atol=1e-7)
    np.testing.assert_allclose(score.sum(axis=1), 0, atol=1e-12)
    assert (score[np.isneginf(told.values)] == 0).all()
