"""Priors of rewards: densities against scipy's and against quadrature, supports, modes, and what is refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats
from scipy.integrate import quad

from subgoal.irl.reward_priors import Beta, Gaussian, Laplace, ThreePeaks, Uniform
from subgoal.runtime.errors import InputError

INF = np.inf
PRIORS = {
    "gaussian": (Gaussian(0.3), -INF, INF),
    "laplace": (Laplace(2.0), -INF, INF),
    "uniform": (Uniform(-0.01, 0.02), -0.01, 0.02),
    "beta": (Beta(2.0, 3.0, -1.0, 0.5), -1.0, 0.5),
    "beta, unbounded density": (Beta(0.5, 0.5, -1.0, 1.0), -1.0, 1.0),
    "three peaks as printed": (ThreePeaks(-0.01, 0.01), -INF, INF),
    "three peaks as printed, bounded": (ThreePeaks(-0.01, 0.01, bounded=True), -0.01, 0.01),
    "three peaks, scaled": (ThreePeaks.scaled(0.01), -INF, INF),
    "three peaks, scaled and bounded": (ThreePeaks.scaled(0.01, bounded=True), -0.01, 0.01),
    "three uneven peaks, bounded": (ThreePeaks(-1.0, 2.0, 3.0, (0.1, 1.0, 0.7), bounded=True), -1.0, 2.0),
}
SIZE = {"gaussian": 0.3, "laplace": 2.0, "three peaks as printed": 22.4, "three peaks, scaled": 0.01}
"""Of what is integrated in pieces where the support has no ends."""


@pytest.mark.parametrize("name", PRIORS)
def test_densities_integrate_to_one(name: str) -> None:
    prior, low, high = PRIORS[name]
    ends = np.linspace(low, high, 9) if name not in SIZE else SIZE[name] * np.linspace(-40, 40, 41)
    mass = sum(
        quad(lambda x: float(np.exp(prior.log_density(x))), a, b, epsabs=1e-12)[0] for a, b in itertools.pairwise(ends)
    )
    assert mass == pytest.approx(1, abs=1e-8)


@pytest.mark.parametrize("name", PRIORS)
def test_nothing_lies_outside_the_support(name: str) -> None:
    prior, low, high = PRIORS[name]
    if low == -INF:
        assert np.isfinite(prior.log_density([-100 * SIZE[name], 100 * SIZE[name]])).all()
    else:
        gap = 1e-9 * (high - low)
        assert (prior.log_density([low - gap, high + gap, -INF, INF]) == -INF).all()
        assert np.isfinite(prior.log_density([low + gap, high - gap])).all()


@pytest.mark.parametrize("name", PRIORS)
def test_a_chain_can_start_where_they_say(name: str) -> None:
    prior, _, _ = PRIORS[name]
    assert np.isfinite(prior.log_density(prior.start))


@pytest.mark.parametrize(
    ("prior", "wanted"),
    [
        (Gaussian(0.7), stats.norm(0, 0.7)),
        (Laplace(0.7), stats.laplace(0, 0.7)),
        (Uniform(-2, 0.5), stats.uniform(-2, 2.5)),
        (Beta(0.5, 2.0, -2, 0.5), stats.beta(0.5, 2.0, loc=-2, scale=2.5)),
        (Beta(1.0, 1.0, -2, 0.5), stats.beta(1.0, 1.0, loc=-2, scale=2.5)),
        (ThreePeaks(-2, 2, 0.5, (1.0, 1e-12, 1e-12)), stats.norm(-2, 1)),
        (ThreePeaks(-2, 2, 0.5, (1e-12, 1.0, 1e-12)), stats.norm(2, 1)),
        (ThreePeaks(-2, 2, 0.5, (1e-12, 1e-12, 1.0)), stats.norm(0, 1)),
        (ThreePeaks(-2, 2, 0.5, (1e-12, 1.0, 1e-12), bounded=True), stats.truncnorm(-4, 0, loc=2)),
    ],
)  # fmt: skip
def test_densities_are_scipys(prior, wanted) -> None:
    values = np.linspace(-1.99, 0.49, 23)
    np.testing.assert_allclose(prior.log_density(values), wanted.logpdf(values), rtol=1e-7, atol=1e-7)


def test_three_peaks_are_in_the_proportions_of_the_thesis() -> None:
    """(3.8) to a constant, where the peaks do not reach each other."""
    prior = ThreePeaks.scaled(2.0, steepness=100)
    low, middle, high, between = np.exp(prior.log_density([-2.0, 0.0, 2.0, 1.0]))
    assert low / middle == pytest.approx(0.4) and high / middle == pytest.approx(0.4)
    assert between / middle < 1e-10
    assert prior.steepness == 25


def test_as_printed_the_prior_is_flat() -> None:
    """Over all rewards of the world of thesis 3.2.1, and even over a hundred times as many."""
    density = ThreePeaks(-0.01, 0.01).log_density(np.linspace(-1, 1, 201))
    assert np.ptp(density) < 2e-3
    assert np.ptp(ThreePeaks(-0.01, 0.01).log_density([-0.01, 0.0, 0.01])) < 2e-7


@pytest.mark.parametrize(
    ("prior", "wanted"),
    [
        (Gaussian(1.0), 0.0),
        (Laplace(1.0), 0.0),
        (Uniform(-1, 1), 0.0),
        (Uniform(2, 3), 2.0),
        (Uniform(-3, -2), -2.0),
        (Beta(3.0, 2.0, -1.0, 2.0), 1.0),
        (Beta(1.0, 1.0, -1.0, 2.0), 0.0),
        (Beta(1.0, 1.0, 1.0, 2.0), 1.0),
        (Beta(2.0, 1.0, -1.0, 2.0), 2.0),
        (Beta(0.5, 0.5, -1.0, 3.0), 1.0),
        (ThreePeaks(-0.01, 0.01), 0.0),
        (ThreePeaks.scaled(0.01, bounded=True), 0.0),
        (ThreePeaks(-1.0, 4.0, 1e-9), 1.2 / 1.8),
        (ThreePeaks(-1.0, 1.0, 9.0, (1.0, 1e-99, 1e-99)), -1.0),
        (ThreePeaks(0.0, 1.0, 9.0, (1e-99, 1.0, 1e-99)), 1.0),
    ],
)  # fmt: skip
def test_modes(prior, wanted: float) -> None:
    assert prior.start == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize(
    ("low", "high", "weights"), [(-1, 2, (2, 0.5, 0.2)), (-1, 3, (1, 1, 0.01)), (-3, 1, (1, 1, 0.01))]
)
def test_of_several_modes_it_is_the_nearest_to_zero(low, high, weights) -> None:
    prior = ThreePeaks(low, high, 4.0, weights)
    grid = np.linspace(low - 0.1, high + 0.1, 300_001)
    height = prior.log_density(grid)
    tops = grid[1:-1][(height[1:-1] > height[:-2]) & (height[1:-1] > height[2:])]
    assert len(tops) > 1
    assert prior.start == pytest.approx(min(tops, key=abs), abs=1e-4)


@pytest.mark.parametrize("name", PRIORS)
def test_shapes_are_kept_and_nan_fails(name: str) -> None:
    prior, _, _ = PRIORS[name]
    assert prior.log_density(np.zeros((2, 3))).shape == (2, 3)
    assert prior.log_density(0.001).shape == ()
    with pytest.raises(InputError, match=r"reward at index \(1,\): found nan"):
        prior.log_density([0.0, float("nan")])


NAN = float("nan")


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: Gaussian(0), "Gaussian deviation"),
        (lambda: Gaussian(NAN), "Gaussian deviation"),
        (lambda: Laplace(-1), "Laplace scale"),
        (lambda: Uniform(1, 1), "Uniform low and high: found 1 and 1"),
        (lambda: Uniform(NAN, 1), "Uniform low and high"),
        (lambda: Uniform(0, INF), "Uniform low and high"),
        (lambda: Beta(0, 1, 0, 1), "Beta a"),
        (lambda: Beta(1, NAN, 0, 1), "Beta b"),
        (lambda: Beta(1, 1, 1, 0), "Beta low and high"),
        (lambda: ThreePeaks(1, 2), "zero between them"),
        (lambda: ThreePeaks(-1, 1, 0), "ThreePeaks steepness"),
        (lambda: ThreePeaks(-1, 1, NAN), "ThreePeaks steepness"),
        (lambda: ThreePeaks(-1, 1, 1, (1, 1)), "three numbers above 0"),
        (lambda: ThreePeaks(-1, 1, 1, (1, 1, 0)), "three numbers above 0"),
        (lambda: ThreePeaks.scaled(0), "magnitude"),
        (lambda: ThreePeaks.scaled(1, steepness=NAN), "steepness"),
    ],
)
def test_what_is_refused(make, match: str) -> None:
    with pytest.raises(InputError, match=match):
        make()
