"""The gradient of the evidence against central differences, and covariances taken apart."""

from __future__ import annotations

import numpy as np
import pytest
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern, RationalQuadratic, WhiteKernel

from subgoal.gaussian.covariances import noisy_covariance
from subgoal.gaussian.evidence import evidence_slope, log_evidence
from subgoal.gaussian.factor import factorise
from tests.gaussian.functions import points, values

X = points(15)
Y = values(X)
COVARIANCES = [
    ConstantKernel(1.4) * RBF([0.8, 1.9]) + WhiteKernel(0.1),
    WhiteKernel(0.2) + Matern(1.3, nu=2.5),
    ConstantKernel(0.7, "fixed") * RationalQuadratic(0.9, 1.2) + ConstantKernel(0.3) + WhiteKernel(0.1, "fixed"),
]


@pytest.mark.parametrize("covariance", COVARIANCES, ids=str)
def test_gradient_is_that_of_central_differences(covariance) -> None:
    model, step = noisy_covariance(covariance, 0.0, X), 1e-5
    value, slope = evidence_slope(model, X, Y)
    assert value == pytest.approx(log_evidence(factorise(model.matrix(X), 0.0), Y).sum(), rel=1e-12)
    for k, along in enumerate(np.eye(model.theta.size) * step):
        up, down = (evidence_slope(model.at(model.theta + sign * along), X, Y)[0] for sign in (1, -1))
        assert slope[k] == pytest.approx((up - down) / (2 * step), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("covariance", COVARIANCES, ids=str)
def test_a_covariance_taken_apart_is_the_whole(covariance) -> None:
    model = noisy_covariance(covariance, 0.0, X)
    np.testing.assert_allclose(model.matrix(X), covariance(X), rtol=1e-14)
    np.testing.assert_allclose(np.sort(model.theta), np.sort(covariance.theta), rtol=1e-14)
    assert len(model.names) == len(model.bounds) == model.theta.size
    moved = model.at(model.theta + 0.1)
    np.testing.assert_allclose(moved.theta, model.theta + 0.1, rtol=1e-12)


def test_names_say_the_dimension_and_leave_out_what_is_fixed() -> None:
    first, _, third = (noisy_covariance(covariance, 0.0, X).names for covariance in COVARIANCES)
    assert first == ("k1__constant_value", "k2__length_scale[0]", "k2__length_scale[1]", "noise")
    assert third == ("k1__k2__alpha", "k1__k2__length_scale", "k2__constant_value")


def test_evidence_of_a_singular_covariance_is_minus_infinity() -> None:
    x = np.linspace(0, 1, 60)[:, None]
    value, slope = evidence_slope(noisy_covariance(RBF(10.0), 0.0, x), x, x)
    assert value == -np.inf and (slope == 0).all()
