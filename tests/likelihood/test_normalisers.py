"""Normalisers and distance laws against closed forms and independent integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.special import gammainc, i0e, modstruve

from subgoal.likelihood import normalisers
from tests.oracles import directions as oracle

CONFIDENCES = [1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0, 50.0]


def z(confidence: float, dimension: int) -> float:
    return math.exp(normalisers.log_direction_normaliser(confidence, dimension))


@pytest.mark.parametrize("alpha", CONFIDENCES)
def test_one_dimension_sums_over_two_directions(alpha: float) -> None:
    assert z(alpha, 1) == pytest.approx(math.exp(-alpha * 0) + math.exp(-alpha * 2), rel=1e-14)


@pytest.mark.parametrize("alpha", [a for a in CONFIDENCES if a <= 10])
def test_two_dimensions_is_bessel_minus_struve(alpha: float) -> None:
    """Z = 2π[I0(2α) − L0(2α)]; the difference cancels e^{2α}, which costs the digits the tolerance gives up."""
    wanted = 2 * math.pi * (i0e(2 * alpha) * math.exp(2 * alpha) - modstruve(0, 2 * alpha))
    assert z(alpha, 2) == pytest.approx(wanted, rel=max(1e-11, 1e-15 * math.exp(2 * alpha)))


@pytest.mark.parametrize("alpha", CONFIDENCES)
def test_three_dimensions_against_the_chord(alpha: float) -> None:
    """In 3-D the chord r has density ∝ r: Z = 2π ∫_0^2 r exp(−αr) dr; rel 1e-9, what cancellation leaves at 1e-3."""
    integral, _ = quad(lambda r: r * math.exp(-alpha * r), 0, 2, epsabs=0, epsrel=1e-13, points=[min(1.9, 5 / alpha)])
    assert z(alpha, 3) == pytest.approx(2 * math.pi * integral, rel=1e-9)


def test_series_and_closed_form_meet() -> None:
    """Across the seam at 1e-3 the slope of log Z is −E‖u − û‖ = −4/3, so steps of 1e-9 move it by 1.3e-9."""
    below, above = (normalisers.log_direction_normaliser(a, 3) for a in (1e-3 * (1 - 1e-6), 1e-3 * (1 + 1e-6)))
    assert below - above == pytest.approx(2e-9 * 4 / 3, abs=1e-10)


def test_four_dimensions_by_double_quadrature() -> None:
    """Polar angles φ, ψ of the 3-sphere: measure 2π sin²φ sin ψ."""
    for alpha in (0.5, 3.0):
        value, _ = dblquad(
            lambda psi, phi, a=alpha: 2 * math.pi * math.exp(-2 * a * math.sin(phi / 2)) * math.sin(phi) ** 2
            * math.sin(psi), 0, math.pi, 0, math.pi, epsabs=0, epsrel=1e-10,
        )  # fmt: skip
        assert z(alpha, 4) == pytest.approx(value, rel=1e-9)


@pytest.mark.parametrize("dimension", [1, 2, 3, 4, 7])
def test_no_confidence_is_the_area_of_the_sphere(dimension: int) -> None:
    area = {1: 2.0, 2: 2 * math.pi, 3: 4 * math.pi, 4: 2 * math.pi**2, 7: 16 * math.pi**3 / 15}[dimension]
    assert math.exp(normalisers.log_sphere_area(dimension)) == pytest.approx(area, rel=1e-13)
    assert z(1e-12, dimension) == pytest.approx(area, rel=1e-10)


@pytest.mark.parametrize("dimension", [2, 3, 4, 6])
@pytest.mark.parametrize("alpha", [1e3, 1e5])
def test_large_confidence_is_the_flat_tangent_space(alpha: float, dimension: int) -> None:
    """Z → S_{d−2} Γ(d−1) α^{1−d}, with a relative error of order d³/α²."""
    flat = normalisers.log_sphere_area(dimension - 1) + math.lgamma(dimension - 1) - (dimension - 1) * math.log(alpha)
    gap = abs(normalisers.log_direction_normaliser(alpha, dimension) - flat)
    assert gap <= dimension**3 / alpha**2 + 1e-11


@pytest.mark.parametrize("dimension", [2, 3, 4])
def test_density_integrates_to_one_over_the_sphere(dimension: int) -> None:
    for alpha in (0.3, 3.0, 20.0):
        log_z = normalisers.log_direction_normaliser(alpha, dimension)
        assert oracle.integral_over_sphere(alpha, log_z, dimension) == pytest.approx(1.0, rel=1e-9)


def test_action_normaliser_in_one_and_two_dimensions() -> None:
    """∫ exp(−α‖w∘a‖/s) da by plain integration over a box beyond which e^−40 is left."""
    alpha, scale = 2.5, 0.7
    w1 = np.array([3.0])
    reach = 40 * scale / alpha
    value, _ = quad(lambda a: math.exp(-alpha * abs(w1[0] * a) / scale), -reach, reach, points=[0], epsrel=1e-12)
    got = normalisers.log_action_normaliser(alpha, 1, scale, normalisers.sum_log(w1))
    assert math.exp(got) == pytest.approx(value, rel=1e-10)
    w2 = np.array([0.5, 2.0])
    value, _ = dblquad(
        lambda y, x: 4 * math.exp(-alpha * math.hypot(w2[0] * x, w2[1] * y) / scale),
        0, reach / w2[0], 0, reach / w2[1], epsabs=0, epsrel=1e-9,
    )  # fmt: skip
    got = normalisers.log_action_normaliser(alpha, 2, scale, normalisers.sum_log(w2))
    assert math.exp(got) == pytest.approx(value, rel=1e-7)


def test_action_normaliser_in_three_dimensions_is_the_radial_integral() -> None:
    alpha, scale, weights = 1.7, 2.0, np.array([1.0, 2.0, 4.0])
    radial, _ = quad(lambda r: 4 * math.pi * r**2 * math.exp(-alpha * r / scale), 0, np.inf, epsrel=1e-12)
    got = normalisers.log_action_normaliser(alpha, 3, scale, normalisers.sum_log(weights))
    assert math.exp(got) == pytest.approx(radial / weights.prod(), rel=1e-9)


def test_volume_of_weighted_balls() -> None:
    w = np.array([2.0, 5.0, 0.1])
    for k, wanted in ((1, 2 * 3.0), (2, math.pi * 9), (3, 4 / 3 * math.pi * 27)):
        got = normalisers.log_ball_volume(k, 3.0, normalisers.sum_log(w[:k]))
        assert math.exp(got) == pytest.approx(wanted / w[:k].prod(), rel=1e-12)


@pytest.mark.parametrize("dimension", [2, 3, 4])
def test_law_of_the_chord(dimension: int) -> None:
    """P(‖u − û‖ ≤ r) by integrating the density up to the angle of r; 1e-7 is the error of 20,000 trapezes."""
    alpha = 3.0
    log_z = normalisers.log_direction_normaliser(alpha, dimension)
    r = np.array([0.0, 0.1, 0.5, 1.0, 1.7, 2.0])
    wanted = [oracle.integral_over_sphere(alpha, log_z, dimension, up_to=2 * math.asin(x / 2)) for x in r]
    np.testing.assert_allclose(normalisers.direction_distance_cdf(r, alpha, dimension), wanted, atol=1e-7)


def test_law_of_the_distance_in_one_dimension_and_of_actions() -> None:
    stay = 1 / (1 + math.exp(-4.0))
    np.testing.assert_allclose(normalisers.direction_distance_cdf(np.array([0.0, 1.9, 2.0]), 2.0, 1), [stay, stay, 1])
    r = np.array([0.0, 0.5, 2.0])
    wanted = [1 - math.exp(-3 * x) * (1 + 3 * x) for x in r]
    np.testing.assert_allclose(normalisers.action_distance_cdf(r, 3.0, 2), wanted, atol=1e-14)


@pytest.mark.parametrize("confidence", [1e2, 1e4, 1e6])
def test_law_of_the_chord_at_high_confidence(confidence: float) -> None:
    """Far from the poles the sphere is flat: a Gamma law of shape d − 1, to about 1/α² and the grid's 1e-6."""
    for dimension in (2, 3, 4):
        chord = np.array([0.5, 1.0, 3.0]) / confidence
        wanted = gammainc(dimension - 1, [0.5, 1.0, 3.0])
        found = normalisers.direction_distance_cdf(chord, confidence, dimension)
        np.testing.assert_allclose(found, wanted, atol=2e-6 + 10 / confidence**2)
