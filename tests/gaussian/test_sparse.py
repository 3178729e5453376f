"""The sparse form: the dense one where every point is an inducing point, explicit inverses elsewhere."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, Matern, WhiteKernel

from subgoal.gaussian import (
    Fitted,
    RegressionWarning,
    SingularError,
    Status,
    farthest_points,
    fit,
    fit_sparse,
    k_means_centres,
)
from subgoal.gaussian.covariances import noisy_covariance
from subgoal.gaussian.evidence_bound import bound_slope
from subgoal.runtime.errors import InputError
from tests.gaussian.functions import NOISE, ORACLE, SE, points, values
from tests.oracles import gaussian_regression as oracle

X, AT = points(40), points(9, seed=1)
Y = values(X)
Z = points(7, seed=2)


def made(inducing=Z, x=X, y=Y, covariance=SE, **options):
    return fit_sparse(x, y, covariance, inducing, **{"noise": NOISE, "optimise": False, **options})


def test_against_explicit_inverses() -> None:
    process = made(mean=[0.4, -1.0])
    for column, centre in enumerate((0.4, -1.0)):
        wanted = oracle.sparse_mean(ORACLE, X, Y[:, column], NOISE, Z, AT, centre)
        np.testing.assert_allclose(process.mean(AT)[:, column], wanted, atol=1e-9)
        bound = oracle.evidence_bound(ORACLE, X, Y[:, column], NOISE, Z, centre)
        assert process.log_evidence[column] == pytest.approx(bound, abs=1e-8)
    np.testing.assert_allclose(process.variance(AT), oracle.sparse_variance(ORACLE, X, NOISE, Z, AT), atol=1e-9)
    assert process.pooled_log_evidence == pytest.approx(process.log_evidence.sum())
    assert (process.status, process.fitted, process.jitter) == (Status.EXACT, Fitted.GIVEN, 0.0)


def test_with_every_point_it_is_the_dense_form() -> None:
    covariance = ConstantKernel(1.5) * Matern([0.8, 1.7], nu=1.5)
    dense, sparse = fit(X, Y, covariance, noise=NOISE, optimise=False), made(X, covariance=covariance)
    np.testing.assert_allclose(sparse.mean(AT), dense.mean(AT), atol=1e-8)
    np.testing.assert_allclose(sparse.variance(AT), dense.variance(AT), atol=1e-8)
    np.testing.assert_allclose(sparse.weights(AT), dense.weights(AT), atol=1e-8)
    np.testing.assert_allclose(sparse.log_evidence, dense.log_evidence, atol=1e-8)


def test_with_every_point_it_learns_what_the_dense_form_learns() -> None:
    covariance = ConstantKernel(1.0) * Matern([1.0, 1.0], nu=1.5) + WhiteKernel(0.1)
    y = Y + 0.2 * np.random.default_rng(4).standard_normal(Y.shape)
    dense, sparse = fit(X, y, covariance), made(X, y=y, covariance=covariance, noise=0.0, optimise=True)
    assert sparse.pooled_log_evidence == pytest.approx(dense.pooled_log_evidence, abs=1e-4)
    assert sparse.fitted is Fitted.CONVERGED


@pytest.mark.parametrize("inducing", [Z, points(60, seed=3)[:13], X[:40:3]], ids=["few", "other", "some"])
@pytest.mark.parametrize(
    "covariance",
    [SE + WhiteKernel(0.07), Matern(1.3, nu=2.5) + WhiteKernel(0.3), SE + ConstantKernel(0.4) + WhiteKernel(0.1)],
    ids=str,
)
def test_gradient_of_the_bound_is_that_of_central_differences(inducing, covariance) -> None:
    model, step = noisy_covariance(covariance, 0.0, X), 1e-5
    _, slope = bound_slope(model, X, Y, inducing, 0.0)
    for k, along in enumerate(np.eye(model.theta.size) * step):
        up, down = (bound_slope(model.at(model.theta + sign * along), X, Y, inducing, 0.0)[0] for sign in (1, -1))
        assert slope[k] == pytest.approx((up - down) / (2 * step), rel=1e-4, abs=1e-4)


def test_gradient_with_noise_as_given() -> None:
    free, given_noise = noisy_covariance(SE + WhiteKernel(NOISE), 0.0, X), noisy_covariance(SE, NOISE, X)
    value, slope = bound_slope(free, X, Y, Z, 0.0)
    same, shorter = bound_slope(given_noise, X, Y, Z, 0.0)
    assert same == pytest.approx(value, rel=1e-12)
    np.testing.assert_allclose(shorter, slope[:-1], rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-2, 1.0), st.floats(0.3, 1.5))
def test_the_bound_is_below_the_evidence_and_rises_with_every_inducing_point(seed, noise, length) -> None:
    generator = np.random.default_rng(seed)
    x, y, z = generator.standard_normal((15, 2)), generator.standard_normal(15), generator.standard_normal((6, 2))
    evidence, before = fit(x, y, RBF(length), noise=noise, optimise=False).log_evidence, -np.inf
    for m in range(1, 7):
        bound = fit_sparse(x, y, RBF(length), z[:m], noise=noise, optimise=False, most_jitter=1e-10).log_evidence
        assert before - 1e-6 <= bound <= evidence + 1e-6
        before = bound


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-2, 1.0))
def test_weights_make_the_mean_and_variance_is_between_nothing_and_the_prior(seed, noise) -> None:
    generator = np.random.default_rng(seed)
    x, at, z = (generator.standard_normal((n, 2)) for n in (15, 8, 5))
    y = generator.standard_normal(15)
    sparse = fit_sparse(x, y, RBF(0.8), z, noise=noise, optimise=False)
    np.testing.assert_allclose(sparse.weights(at) @ y, sparse.mean(at), atol=1e-8)
    assert (sparse.variance(at) >= 0).all()
    assert (sparse.variance(at) <= 1 + 1e-8).all()


@pytest.mark.filterwarnings("ignore::subgoal.gaussian.RegressionWarning")
def test_learning_raises_the_bound() -> None:
    covariance = ConstantKernel(1.0) * RBF([1.0, 1.0]) + WhiteKernel(0.1)
    before = made(covariance=covariance, noise=0.0)
    after = made(covariance=covariance, noise=0.0, optimise=True)
    assert after.pooled_log_evidence > before.pooled_log_evidence + 1
    assert made(covariance=covariance, noise=0.0, optimise=True, most_iterations=1).fitted is Fitted.OUT_OF_ITERATIONS


def test_close_inducing_points_are_jittered_and_said_to_be() -> None:
    close = np.column_stack([np.linspace(0, 0.1, 12), np.zeros(12)])
    with pytest.warns(RegressionWarning, match="JITTERED"):
        process = made(close)
    assert process.status is Status.JITTERED and process.jitter > 0
    with pytest.raises(SingularError):
        made(close, most_jitter=0.0)


def test_the_bound_of_singular_inducing_points_is_minus_infinity() -> None:
    close = np.column_stack([np.linspace(0, 0.1, 12), np.zeros(12)])
    value, slope = bound_slope(noisy_covariance(SE, NOISE, X), X, Y, close, 0.0)
    assert value == -np.inf and (slope == 0).all()


def test_a_sparse_process_tells_itself() -> None:
    told = f"SparseGaussianProcess(40 observations through 7 points, {SE}, noise 0.05: EXACT, GIVEN)"
    assert repr(made()) == told


def test_little_noise_is_ill_conditioned_and_said_to_be() -> None:
    with pytest.warns(RegressionWarning, match="ILL-CONDITIONED"):
        process = made(np.vstack([Z, [50.0, 50.0]]), noise=1e-12)
    assert process.status is Status.ILL_CONDITIONED and process.condition > 1e10


@pytest.mark.parametrize(
    ("named", "change"),
    [
        ("inducing", {"inducing": np.zeros((0, 2))}),
        ("inducing", {"inducing": np.zeros((3, 3))}),
        ("inducing", {"inducing": [[np.nan, 0.0]]}),
        (r"inducing at row 7: found a place given before", {"inducing": np.vstack([Z, Z[2]])}),
        ("noise", {"noise": 0.0}),
        ("noise", {"noise": np.nan}),
        ("points", {"x": X[:0], "y": Y[:0]}),
        ("values", {"y": Y[:3]}),
        ("most_jitter", {"most_jitter": np.nan}),
    ],
)
def test_bad_input_is_named(named, change) -> None:
    with pytest.raises(InputError, match=named):
        made(**change)


def test_places_are_checked() -> None:
    for ask in (made().mean, made().variance, made().weights):
        with pytest.raises(InputError, match="at"):
            ask([[0.0, 0.0, 0.0]])


def test_farthest_points_are_each_the_farthest_from_those_before() -> None:
    chosen = farthest_points(X, 6)
    np.testing.assert_array_equal(chosen[0], X[0])
    for k in range(1, 6):
        gap = np.linalg.norm(X[:, None] - chosen[None, :k], axis=2).min(axis=1)
        np.testing.assert_array_equal(chosen[k], X[gap.argmax()])


def test_farthest_points_measure_by_the_scale() -> None:
    line = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 2.0]])
    np.testing.assert_array_equal(farthest_points(line, 2)[1], line[1])
    np.testing.assert_array_equal(farthest_points(line, 2, scale=[3.0, 1.0])[1], line[2])


def test_all_distinct_points_can_be_had_and_no_more() -> None:
    twice = np.vstack([X, X])
    np.testing.assert_array_equal(np.unique(farthest_points(twice, 40), axis=0), np.unique(X, axis=0))
    for choose in (farthest_points, k_means_centres):
        with pytest.raises(InputError, match=r"count.*at most 40"):
            choose(twice, 41)


def test_k_means_centres_are_in_the_middle_and_the_same_each_time() -> None:
    clusters = np.vstack([c + 0.01 * X for c in ([0.0, 0.0], [1.0, 5.0], [9.0, -3.0])])
    found = k_means_centres(clusters, 3, seed=1)
    wanted = np.array([clusters[40 * k : 40 * (k + 1)].mean(axis=0) for k in range(3)])
    np.testing.assert_allclose(found[np.argsort(found[:, 0])], wanted, atol=1e-8)
    np.testing.assert_array_equal(k_means_centres(X, 12, seed=1), k_means_centres(X, 12, seed=1))


@pytest.mark.parametrize("choose", [farthest_points, k_means_centres])
@pytest.mark.parametrize(
    ("named", "arguments", "options"),
    [
        ("points", ([[np.nan, 1.0]], 1), {}),
        ("count", (X, 0), {}),
        ("count", (np.zeros((0, 2)), 1), {}),
        ("scale", (X, 2), {"scale": [1.0, 0.0]}),
        ("scale", (X, 2), {"scale": [1.0, 1.0, 1.0]}),
    ],
)
def test_choosers_check_their_input(choose, named, arguments, options) -> None:
    with pytest.raises(InputError, match=named):
        choose(*arguments, **options)
