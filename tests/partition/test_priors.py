"""Priors of single numbers against scipy, the slice move against the laws it must keep, Dirichlet weights in logs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from subgoal.partition.priors import (
    SMALLEST_LOG,
    Beta,
    Gamma,
    LogNormal,
    concentration_of,
    log_weights,
    probability_of,
    slice_draw,
)
from subgoal.runtime.errors import InputError

LEVEL = 3e-6
GRID = np.geomspace(1e-4, 40, 25)


@pytest.mark.parametrize(("shape", "rate"), [(1.0, 1.0), (0.3, 2.5), (7.0, 0.1)])
def test_gamma_is_scipys(shape: float, rate: float) -> None:
    law, wanted = Gamma(shape, rate), stats.gamma(shape, scale=1 / rate)
    np.testing.assert_allclose([law.log_density(x) for x in GRID], wanted.logpdf(GRID), rtol=1e-12, atol=1e-12)
    assert law.start == pytest.approx(wanted.mean())


@pytest.mark.parametrize(("median", "spread"), [(1.0, 1.0), (3.0, 1.5), (0.02, 0.2)])
def test_log_normal_is_scipys(median: float, spread: float) -> None:
    law, wanted = LogNormal(median, spread), stats.lognorm(spread, scale=median)
    np.testing.assert_allclose([law.log_density(x) for x in GRID], wanted.logpdf(GRID), rtol=1e-10, atol=1e-10)
    assert law.start == pytest.approx(wanted.median())


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (0.4, 3.0), (9.0, 2.0)])
def test_beta_is_scipys(a: float, b: float) -> None:
    law, wanted, grid = Beta(a, b), stats.beta(a, b), np.linspace(1e-3, 1 - 1e-3, 21)
    np.testing.assert_allclose([law.log_density(x) for x in grid], wanted.logpdf(grid), rtol=1e-12, atol=1e-12)
    assert law.start == pytest.approx(wanted.mean())


LAWS = {
    "normal, a slice too narrow": (stats.norm(3, 2), 0.1),
    "normal, a slice too wide": (stats.norm(3, 2), 60.0),
    "skewed": (stats.loggamma(0.5), 1.0),
    "two humps": (None, 1.5),
}


def humps() -> tuple[object, object]:
    """Density and distribution function of ½N(−2, 1) + ½N(2, 0.5)."""
    one, two = stats.norm(-2, 1), stats.norm(2, 0.5)
    return (
        lambda x: float(np.logaddexp(-0.5 * (x + 2) ** 2, math.log(2) - 2 * (x - 2) ** 2)),
        lambda x: (one.cdf(x) + two.cdf(x)) / 2,
    )


@pytest.mark.parametrize("name", LAWS)
def test_a_slice_leaves_the_law_as_it_is(name: str) -> None:
    """3,000 independent exact draws, each moved three times, are still draws (Kolmogorov-Smirnov, 3e-6)."""
    law, width = LAWS[name]
    generator = np.random.default_rng(11)
    if law is None:
        log_density, cdf = humps()
        start = np.where(generator.random(3000) < 0.5, generator.normal(-2, 1, 3000), generator.normal(2, 0.5, 3000))
    else:
        start, cdf = law.rvs(3000, random_state=generator), law.cdf
        log_density = plain(law, name)
    moved = start.copy()
    for _ in range(3):
        moved = np.array([slice_draw(log_density, x, width, generator) for x in moved])
    assert stats.kstest(moved, cdf).pvalue >= LEVEL
    assert (moved != start).mean() >= 0.99
    assert abs(np.corrcoef(moved, start)[0, 1]) <= 0.999


def plain(law: object, name: str) -> object:
    """The log density up to its constant."""
    if name == "skewed":
        return lambda x: 0.5 * x - math.exp(x)
    return lambda x: -0.5 * ((x - 3) / 2) ** 2


def test_from_a_fixed_start_a_slice_reaches_the_law() -> None:
    """From the edge of a truncated law, whose density is −inf outside."""
    generator = np.random.default_rng(5)
    reached = np.empty(3000)
    for k in range(reached.size):
        x = 0.999
        for _ in range(25):
            x = slice_draw(lambda y: 2 * math.log(y) if 0 < y < 1 else -math.inf, x, 0.3, generator)
        reached[k] = x
    assert stats.kstest(reached, stats.beta(3, 1).cdf).pvalue >= LEVEL


@pytest.mark.parametrize("shape", [(0.5, 2.0, 3.5), (0.05, 0.1, 4.0), (30.0, 1.0, 1.0)])
def test_weights_have_the_moments_of_a_dirichlet(shape: tuple[float, ...]) -> None:
    generator, size = np.random.default_rng(7), 20_000
    weights = np.exp([log_weights(np.array(shape), generator) for _ in range(size)])
    assert np.abs(weights.sum(axis=1) - 1).max() <= 1e-12
    for k, a in enumerate(shape):
        law = stats.beta(a, sum(shape) - a)
        # A sample mean of `size` draws, and a Kolmogorov-Smirnov test, each at 3e-6.
        assert abs(weights[:, k].mean() - law.mean()) <= 4.7 * law.std() / math.sqrt(size)
        assert stats.kstest(weights[:, k], law.cdf).pvalue >= LEVEL


def test_tiny_shapes_give_one_weight_and_logarithms_that_are_numbers() -> None:
    """Of shapes far below one, one weight is all but one, and each is that one in proportion to its shape."""
    shape, generator = np.array([1e-4, 2e-4, 1e-12]), np.random.default_rng(3)
    drawn = np.array([log_weights(shape, generator) for _ in range(6000)])
    assert np.isfinite(drawn).all()
    assert drawn.min() == SMALLEST_LOG
    first = (drawn[:, 0] > drawn[:, 1]).sum()
    assert stats.binomtest(int(first), 6000, 1 / 3).pvalue >= LEVEL
    assert (drawn[:, 2] == SMALLEST_LOG).all()


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Gamma(0.0, 1.0), "Gamma shape"),
        (lambda: Gamma(1.0, -1.0), "Gamma rate"),
        (lambda: LogNormal(0.0, 1.0), "LogNormal median"),
        (lambda: LogNormal(1.0, np.nan), "LogNormal spread"),
        (lambda: Beta(np.inf, 1.0), "Beta a"),
        (lambda: Beta(1.0, 0.0), "Beta b"),
        (lambda: concentration_of(0.0), "concentration"),
        (lambda: concentration_of("much"), "concentration"),
        (lambda: probability_of("persistence", 1.0), "persistence"),
        (lambda: probability_of("persistence", -0.1), "persistence"),
    ],
)
def test_bad_numbers_are_named(make: object, word: str) -> None:
    with pytest.raises(InputError, match=word):
        make()


def test_good_numbers_and_laws_pass() -> None:
    assert concentration_of(2) == 2.0
    assert concentration_of(Gamma(2.0, 1.0)) == Gamma(2.0, 1.0)
    assert probability_of("persistence", 0) == 0.0
    assert probability_of("persistence", Beta(2.0, 1.0)) == Beta(2.0, 1.0)
