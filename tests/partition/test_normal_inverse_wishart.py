"""The conjugate Gaussian cluster against integration, scipy's laws and its own identities."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad
from scipy.stats import chi2, invwishart, kstest, multivariate_normal, multivariate_t

from subgoal.partition.normal_inverse_wishart import NormalInverseWishart
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

LEVEL = 3e-6


def a_prior(d: int) -> NormalInverseWishart:
    generator = stream(5, d)
    root = generator.standard_normal((d, d)) + 2 * np.eye(d)
    return NormalInverseWishart(generator.standard_normal(d), 0.7, root @ root.T, d + 1.3)


def some_points(n: int, d: int) -> np.ndarray:
    return 2 * stream(6, n, d).standard_normal((n, d)) + 1


def student_t_chain(prior: NormalInverseWishart, points: np.ndarray) -> float:
    """Product of predictive densities, each a multivariate t with parameters updated from scratch."""
    d, total = points.shape[1], 0.0
    for n, x in enumerate(points):
        before = points[:n]
        strength, degrees = prior.strength + n, prior.degrees + n
        mean, scale = prior.mean, prior.scale
        if n:
            centre = before.mean(axis=0)
            off = (centre - prior.mean)[:, None]
            mean = (prior.strength * prior.mean + n * centre) / strength
            scale = scale + (before - centre).T @ (before - centre) + prior.strength * n / strength * off @ off.T
        freedom = degrees - d + 1
        shape = scale * (strength + 1) / (strength * freedom)
        total += multivariate_t(mean, shape, df=freedom).logpdf(x)
    return total


@pytest.mark.parametrize("d", [1, 2, 3])
@pytest.mark.parametrize("n", [0, 1, 2, 7])
def test_marginal_is_the_chain_of_student_t_predictives(n, d):
    prior, points = a_prior(d), some_points(n, d)
    assert prior.log_marginal(points) == pytest.approx(student_t_chain(prior, points), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_posterior_update_in_one_go_or_two(d):
    prior, points = a_prior(d), some_points(9, d)
    whole, parts = prior.posterior(points), prior.posterior(points[:4]).posterior(points[4:])
    for name in ("mean", "strength", "scale", "degrees"):
        np.testing.assert_allclose(getattr(whole, name), getattr(parts, name), rtol=1e-12)
    chained = prior.log_marginal(points[:4]) + prior.posterior(points[:4]).log_marginal(points[4:])
    assert prior.log_marginal(points) == pytest.approx(chained, rel=1e-12)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_bayes_rule_holds_at_any_parameter(d):
    """log p(x) = log p(x | θ) + log p(θ) − log p(θ | x), whatever θ."""
    prior, points = a_prior(d), some_points(6, d)
    posterior = prior.posterior(points)
    for k in range(5):
        mean, covariance = prior.draw(stream(7, d, k))
        row = np.concatenate([mean, covariance.ravel()])[None]
        likelihood = prior.log_likelihood(points, row)[:, 0]
        np.testing.assert_allclose(likelihood, multivariate_normal(mean, covariance).logpdf(points), rtol=1e-9)
        right = likelihood.sum() + prior.log_density(mean, covariance) - posterior.log_density(mean, covariance)
        assert prior.log_marginal(points) == pytest.approx(right, rel=1e-9)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_density_against_scipy(d):
    prior = a_prior(d)
    mean, covariance = prior.draw(stream(8, d))
    wanted = invwishart(prior.degrees, prior.scale).logpdf(covariance)
    wanted += multivariate_normal(prior.mean, covariance / prior.strength).logpdf(mean)
    assert prior.log_density(mean, covariance) == pytest.approx(wanted, rel=1e-10)


def test_one_dimension_by_numerical_integration():
    """The prior integrates to one and to the marginal; over μ and log variance."""
    prior, points = NormalInverseWishart([0.3], 0.7, [[1.7]], 4.0), np.array([[0.1], [0.9]])

    def integrand(mean: float, log_variance: float, seen: bool) -> float:
        variance = np.exp(log_variance)
        density = prior.log_density([mean], [[variance]]) + log_variance
        if seen:
            density += prior.log_likelihood(points, np.array([[mean, variance]])).sum()
        return float(np.exp(density))

    def around(log_variance: float, sign: int) -> float:
        return 0.3 + sign * 15 * np.exp(log_variance / 2)

    for seen, wanted in ((False, 1.0), (True, np.exp(prior.log_marginal(points)))):
        found, _ = dblquad(
            integrand, -8, 14, lambda v: around(v, -1), lambda v: around(v, 1), args=(seen,), epsrel=1e-7
        )
        assert found == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("d", [1, 2, 3])
def test_draws_follow_the_law(d):
    """Three pivots per axis, 4,000 draws each: finds a shift of 0.05 in any distribution function."""
    prior, n = a_prior(d), 4_000
    rows = prior.draw_given(np.zeros((n, 1 + d + d * d)), stream(9, d))
    mean, covariance = rows[:, :d], rows[:, d:].reshape(n, d, d)
    precision, off = np.linalg.inv(covariance), mean - prior.mean
    pivot = prior.strength * np.einsum("na,nab,nb->n", off, precision, off)
    assert kstest(pivot, chi2(d).cdf).pvalue > LEVEL
    for k in range(d):
        along = prior.scale[k, k] / covariance[:, k, k]
        assert kstest(along, chi2(prior.degrees - d + 1).cdf).pvalue > LEVEL
        across = precision[:, k, k] / np.linalg.inv(prior.scale)[k, k]
        assert kstest(across, chi2(prior.degrees).cdf).pvalue > LEVEL
    size = np.log(np.linalg.det(prior.scale) / np.linalg.det(covariance))
    wanted = sum(np.log(chi2(prior.degrees - k).rvs(n, random_state=k)) for k in range(d))
    assert kstest(size, wanted).pvalue > LEVEL


def test_many_clusters_at_once_equal_one_by_one():
    prior, points = a_prior(2), some_points(12, 2)
    statistic = prior.statistics(points)
    totals = np.array([statistic[:5].sum(axis=0), statistic[5:].sum(axis=0), 0 * statistic[0]])
    one_by_one = [prior.log_marginal(points[:5]), prior.log_marginal(points[5:]), 0.0]
    np.testing.assert_allclose(prior.log_marginal_of(totals), one_by_one, rtol=1e-12, atol=1e-12)
    drawn = prior.draw_given(totals[:1], stream(3))[0]
    mean, covariance = prior.posterior(points[:5]).draw(stream(3))
    np.testing.assert_allclose(drawn, np.concatenate([mean, covariance.ravel()]), rtol=1e-10)


def test_default_prior_follows_the_units_of_the_data():
    points = some_points(40, 2)
    prior = NormalInverseWishart.from_data(points)
    assert (prior.strength, prior.degrees, prior.dimension) == (0.05, 5.0, 2)
    np.testing.assert_allclose(np.diag(prior.scale), points.var(axis=0))
    stretch = np.array([100.0, 1e-3])
    stretched = NormalInverseWishart.from_data(points * stretch).log_marginal(points * stretch)
    assert stretched + 40 * np.log(stretch).sum() == pytest.approx(prior.log_marginal(points), rel=1e-10)


@pytest.mark.parametrize(
    ("named", "arguments"),
    [
        ("mean", ([np.nan, 0], 1.0, np.eye(2), 4.0)),
        ("mean", ([], 1.0, np.empty((0, 0)), 4.0)),
        ("strength", ([0, 0], 0.0, np.eye(2), 4.0)),
        ("strength", ([0, 0], np.nan, np.eye(2), 4.0)),
        ("scale", ([0, 0], 1.0, np.eye(3), 4.0)),
        ("scale", ([0, 0], 1.0, [[1, 2], [2, 1]], 4.0)),
        ("scale", ([0, 0], 1.0, [[1, 0.5], [0, 1]], 4.0)),
        ("degrees", ([0, 0], 1.0, np.eye(2), 1.0)),
        ("degrees", ([0, 0], 1.0, np.eye(2), np.nan)),
    ],
)
def test_the_record_checks_itself(named, arguments):
    with pytest.raises(InputError, match=named):
        NormalInverseWishart(*arguments)


@pytest.mark.parametrize("points", [[[np.nan, 0]], [[1.0]], [1.0, 2.0], [[np.inf, 0]], "ab"])
def test_points_are_checked(points):
    prior = a_prior(2)
    for call in (prior.posterior, prior.log_marginal, prior.statistics):
        with pytest.raises(InputError, match="points"):
            call(points)


@pytest.mark.parametrize("points", [[[1.0, 2.0]], [[1.0, 2.0], [1.0, 3.0]], np.empty((0, 2))])
def test_default_prior_needs_spread(points):
    with pytest.raises(InputError, match="spread"):
        NormalInverseWishart.from_data(points)


def test_density_checks_its_parameters():
    with pytest.raises(InputError, match="mean"):
        a_prior(2).log_density([0.0], np.eye(2))
    with pytest.raises(InputError, match="covariance"):
        a_prior(2).log_density([0.0, 0.0], -np.eye(2))


def test_the_record_cannot_be_changed():
    scale = np.eye(2)
    prior = NormalInverseWishart([0.0, 0.0], 1.0, scale, 4.0)
    with pytest.raises(ValueError, match="read-only"):
        prior.scale[0, 0] = 2.0
    scale[0, 0] = 3.0
    assert prior.scale[0, 0] == 1.0
    with pytest.raises(AttributeError):
        prior.strength = 2.0
