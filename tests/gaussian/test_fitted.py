"""What a fit says of its hyper-parameters: found, on a bound, unfinished, or told by no point."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process.kernels import (
    RBF,
    ConstantKernel,
    WhiteKernel,
)

from subgoal.gaussian import Fitted, RegressionWarning, SingularError, fit
from tests.gaussian.functions import NOISE, SE, points, values

X, AT = points(25), points(11, seed=1)
Y = values(X)


def made(x=X, y=Y, covariance=SE, **options):
    return fit(x, y, covariance, **{"noise": NOISE, "optimise": False, **options})


def test_iterations_are_counted_and_running_out_of_them_is_told() -> None:
    process = made(optimise=True, most_iterations=1)
    assert process.fitted is Fitted.OUT_OF_ITERATIONS
    assert process.pooled_log_evidence > made().pooled_log_evidence


def test_a_value_on_its_bound_is_told() -> None:
    covariance = ConstantKernel(1.0, (0.5, 1.1)) * RBF(1.0)
    assert made(y=10 * Y, covariance=covariance, optimise=True).fitted is Fitted.AT_BOUND


def test_what_is_fixed_stays_and_nothing_free_is_as_given() -> None:
    covariance = ConstantKernel(2.0, "fixed") * RBF(1.0, "fixed") + WhiteKernel(0.1, "fixed")
    process = made(covariance=covariance, noise=0.0, optimise=True)
    assert process.fitted is Fitted.GIVEN and process.noise == 0.1
    partly = made(covariance=ConstantKernel(2.0, "fixed") * RBF(1.0), optimise=True)
    assert partly.covariance.k1.constant_value == 2.0 and partly.covariance.k2.length_scale != 1.0


def test_one_point_tells_no_length_and_the_one_given_stays() -> None:
    """E30: the evidence of one value r is greatest at ν² + σ² = r², whatever the length."""
    with pytest.warns(RegressionWarning, match=r"UNIDENTIFIED.*length_scale"):
        process = fit([[1.0, 2.0]], [3.0], ConstantKernel(1.0) * RBF(0.7), restarts=3)
    assert process.fitted is Fitted.UNIDENTIFIED and process.unidentified == ("k2__length_scale",)
    assert process.covariance.k2.length_scale == pytest.approx(0.7, rel=1e-12)
    assert process.covariance.k1.constant_value == pytest.approx(9.0, rel=1e-4)


def test_one_point_does_not_tell_noise_from_the_function() -> None:
    with pytest.warns(RegressionWarning, match="UNIDENTIFIED"):
        process = fit([[1.0]], [3.0], ConstantKernel(1.0) * RBF(0.7) + WhiteKernel(1.0))
    assert process.unidentified == ("k1__constant_value", "k2__length_scale", "noise")
    assert process.covariance.k1.constant_value + process.noise == pytest.approx(9.0, rel=1e-4)


def test_a_dimension_without_spread_tells_no_length() -> None:
    x = np.column_stack([np.linspace(0, 5, 12), np.full(12, 2.0)])
    with pytest.warns(RegressionWarning, match="UNIDENTIFIED"):
        process = fit(x, np.sin(x[:, 0]), RBF([1.0, 3.0]), noise=0.01)
    assert process.unidentified == ("length_scale[1]",)
    assert process.covariance.length_scale[1] == pytest.approx(3.0, rel=1e-12)


def test_restarts_find_a_better_length_and_the_same_seed_the_same() -> None:
    x = np.linspace(0, 10, 40)[:, None]
    y = np.sin(3 * x[:, 0])
    covariance = RBF(1e3) + WhiteKernel(1.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        alone = fit(x, y, covariance)
        helped, again = (fit(x, y, covariance, restarts=8, seed=5) for _ in range(2))
    assert helped.log_evidence > alone.log_evidence + 10
    assert (helped.covariance.theta == again.covariance.theta).all()


def test_a_search_that_begins_where_all_is_singular_says_so() -> None:
    x = np.linspace(0, 1, 60)[:, None]
    with pytest.raises(SingularError, match="optimise=False"):
        fit(x, x[:, 0], RBF(10.0))
