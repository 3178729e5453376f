"""Gaussian-process regression against explicit inverses, scikit-learn and its own identities."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import (
    RBF,
    CompoundKernel,
    ConstantKernel,
    DotProduct,
    Matern,
    RationalQuadratic,
    WhiteKernel,
)

import subgoal.gaussian
from subgoal.gaussian import Fitted, RegressionWarning, SingularError, Status, fit
from subgoal.runtime.errors import InputError
from tests.gaussian.functions import NOISE, ORACLE, SE, points, values
from tests.oracles import gaussian_regression as oracle

X, AT = points(25), points(11, seed=1)
Y = values(X)


def made(x=X, y=Y, covariance=SE, **options):
    return fit(x, y, covariance, **{"noise": NOISE, "optimise": False, **options})


def test_mean_variance_weights_and_evidence_against_explicit_inverses() -> None:
    process = made(mean=[0.4, -1.0])
    for column, centre in enumerate((0.4, -1.0)):
        wanted = oracle.mean(ORACLE, X, Y[:, column], NOISE, AT, centre)
        np.testing.assert_allclose(process.mean(AT)[:, column], wanted, atol=1e-9)
        evidence = oracle.log_evidence(ORACLE, X, Y[:, column], NOISE, centre)
        assert process.log_evidence[column] == pytest.approx(evidence, abs=1e-9)
    np.testing.assert_allclose(process.variance(AT), oracle.variance(ORACLE, X, NOISE, AT), atol=1e-9)
    np.testing.assert_allclose(process.weights(AT), oracle.weights(ORACLE, X, NOISE, AT), atol=1e-9)
    assert process.pooled_log_evidence == pytest.approx(process.log_evidence.sum())
    assert (process.status, process.fitted, process.jitter, process.merged) == (Status.EXACT, Fitted.GIVEN, 0.0, 0)


def test_one_function_is_a_column_of_several() -> None:
    several, one = made(), made(y=Y[:, 0])
    np.testing.assert_allclose(one.mean(AT), several.mean(AT)[:, 0], rtol=1e-12)
    assert one.log_evidence == pytest.approx(several.log_evidence[0], rel=1e-12)
    assert one.mean(AT).shape == (11,) and several.mean(AT).shape == (11, 2)


@pytest.mark.parametrize(
    "covariance",
    [
        SE,
        Matern([1.0, 2.0], nu=1.5),
        2.0 * RationalQuadratic(1.0, 0.5) + 0.1 * DotProduct(1.0),
        RBF(1.0) * ConstantKernel(0.5) + Matern(2.0, nu=2.5),
    ],
    ids=str,
)
def test_against_scikit_learn(covariance) -> None:
    ours = made(covariance=covariance)
    theirs = GaussianProcessRegressor(covariance, alpha=NOISE, optimizer=None).fit(X, Y)
    mean, deviation = theirs.predict(AT, return_std=True)
    np.testing.assert_allclose(ours.mean(AT), mean, atol=1e-7)
    np.testing.assert_allclose(ours.variance(AT), deviation[:, 0] ** 2, atol=1e-7)
    assert ours.pooled_log_evidence == pytest.approx(theirs.log_marginal_likelihood(covariance.theta), abs=1e-7)


def test_noise_that_is_learned_is_no_part_of_the_function() -> None:
    """scikit-learn adds the noise of a WhiteKernel to what it predicts; (2.13) is that of the function."""
    inside, beside = made(covariance=SE + WhiteKernel(NOISE), noise=0.0), made()
    np.testing.assert_allclose(inside.variance(AT), beside.variance(AT), rtol=1e-12)
    np.testing.assert_allclose(inside.mean(AT), beside.mean(AT), rtol=1e-10)
    assert inside.noise == NOISE and "White" not in str(inside.covariance)


def test_hyper_parameters_of_greatest_evidence_as_scikit_learn_finds_them() -> None:
    y = Y + 0.1 * np.random.default_rng(2).standard_normal(Y.shape)
    covariance = ConstantKernel(1.0) * RBF([1.0, 1.0]) + WhiteKernel(0.1)
    ours = made(y=y, covariance=covariance, noise=0.0, optimise=True)
    theirs = GaussianProcessRegressor(covariance, alpha=0.0).fit(X, y)
    assert ours.pooled_log_evidence == pytest.approx(theirs.log_marginal_likelihood_value_, abs=1e-6)
    np.testing.assert_allclose(ours.mean(AT), theirs.predict(AT), atol=1e-3)
    assert ours.fitted is Fitted.CONVERGED
    assert ours.pooled_log_evidence > made(y=y, covariance=covariance, noise=0.0).pooled_log_evidence + 1


def test_without_noise_the_mean_goes_through_the_observations() -> None:
    process = made(covariance=Matern(1.0, nu=1.5), noise=0.0)
    np.testing.assert_allclose(process.mean(X), Y, atol=1e-9)
    np.testing.assert_allclose(process.variance(X), 0, atol=1e-9)
    assert process.status is Status.EXACT


def test_far_from_the_points_there_is_only_the_prior() -> None:
    process, far = made(mean=[3.0, -2.0]), np.full((1, 2), 1e3)
    np.testing.assert_allclose(process.mean(far), [[3.0, -2.0]], atol=1e-12)
    np.testing.assert_allclose(process.variance(far), SE.diag(far), rtol=1e-12)


def test_repeated_points_that_agree_are_merged_without_noise_and_said_to_be() -> None:
    covariance, twice = Matern(1.0, nu=1.5), [*range(25), 3, 3, 7]
    once, merged = made(covariance=covariance, noise=0.0), made(X[twice], Y[twice], covariance, noise=0.0)
    assert merged.status is Status.MERGED and merged.merged == 3 and merged.jitter == 0
    np.testing.assert_allclose(merged.mean(AT), once.mean(AT), atol=1e-9)
    np.testing.assert_allclose(merged.variance(AT), once.variance(AT), atol=1e-9)
    np.testing.assert_allclose(merged.weights(AT) @ Y[twice], merged.mean(AT), atol=1e-9)
    np.testing.assert_allclose(merged.weights(AT)[:, [3, 25, 26]] * 3, once.weights(AT)[:, [3, 3, 3]], atol=1e-9)
    np.testing.assert_allclose(merged.log_evidence, once.log_evidence, atol=1e-9)


def test_repeated_points_with_noise_are_observations_of_their_own() -> None:
    twice = [*range(25), 3, 3, 7]
    process = made(X[twice], Y[twice])
    assert process.status is Status.EXACT and process.merged == 0
    np.testing.assert_allclose(process.mean(AT)[:, 0], oracle.mean(ORACLE, X[twice], Y[twice, 0], NOISE, AT), atol=1e-9)


def test_repeated_points_that_contradict_each_other_are_refused_without_noise() -> None:
    x, y = np.vstack([X, X[4]]), np.vstack([Y, Y[4] + [0, 1e-6]])
    with pytest.raises(InputError, match=r"rows 4 and 25.*one value at each point"):
        made(x, y, noise=0.0)


def test_a_singular_covariance_is_jittered_and_said_to_be() -> None:
    x = np.linspace(0, 1, 40)[:, None]
    with pytest.warns(RegressionWarning, match="JITTERED"):
        process = made(x, np.sin(x[:, 0]), RBF(1.0), noise=0.0)
    assert process.status is Status.JITTERED and 0 < process.jitter <= 1e-6
    assert "noise" in process.status.value
    np.testing.assert_allclose(process.mean(x), np.sin(x[:, 0]), atol=1e-4)
    with pytest.warns(RegressionWarning, match="ILL-CONDITIONED"):
        wanted = made(x, np.sin(x[:, 0]), RBF(1.0), noise=process.jitter)
    np.testing.assert_allclose(process.mean(x), wanted.mean(x), atol=1e-9)


def test_no_variance_is_added_where_none_is_allowed() -> None:
    x = np.linspace(0, 1, 40)[:, None]
    with pytest.raises(SingularError, match="Try: noise"):
        made(x, x[:, 0], RBF(1.0), noise=0.0, most_jitter=0.0)


def test_an_ill_conditioned_covariance_is_said_to_be_and_left_as_it_is() -> None:
    x = np.linspace(0, 1, 8)[:, None]
    with pytest.warns(RegressionWarning, match="ILL-CONDITIONED"):
        process = made(x, x[:, 0], RBF(0.9), noise=0.0)
    assert process.status is Status.ILL_CONDITIONED and process.jitter == 0


@pytest.mark.parametrize("length", [0.3, 1.0, 2.0])
def test_condition_is_that_of_the_matrix(length) -> None:
    x = np.linspace(0, 3, 9)[:, None]
    process = made(x, x[:, 0], RBF(length), noise=1e-6)
    wanted = np.linalg.cond(RBF(length)(x) + 1e-6 * np.eye(9), 1)
    assert wanted / 3 <= process.condition <= 1.001 * wanted


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(-3, 3), st.floats(1e-3, 1.0), st.floats(0.3, 3.0))
def test_mean_is_linear_in_the_values_and_is_what_the_weights_make(seed, factor, noise, length) -> None:
    generator = np.random.default_rng(seed)
    x, at = generator.standard_normal((12, 2)), generator.standard_normal((5, 2))
    u, v = generator.standard_normal((2, 12))

    def process(y):
        return made(x, y, RBF(length), noise=noise)

    np.testing.assert_allclose(
        process(u + factor * v).mean(at), process(u).mean(at) + factor * process(v).mean(at), atol=1e-8
    )
    np.testing.assert_allclose(process(u).weights(at) @ u, process(u).mean(at), atol=1e-8)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1e-3, 1.0), st.floats(0.3, 3.0))
def test_variance_is_not_negative_and_falls_with_every_observation(seed, noise, length) -> None:
    generator = np.random.default_rng(seed)
    x, at = generator.standard_normal((12, 2)), generator.standard_normal((20, 2))
    before = RBF(length).diag(at)
    for n in range(1, 13):
        after = made(x[:n], x[:n, 0], RBF(length), noise=noise).variance(at)
        assert (after >= 0).all()
        assert (after <= before + 1e-10).all()
        before = after


def test_order_of_observations_does_not_matter() -> None:
    order = np.random.default_rng(3).permutation(25)
    process = made(X[order], Y[order])
    np.testing.assert_allclose(process.mean(AT), made().mean(AT), atol=1e-10)
    np.testing.assert_allclose(process.weights(AT), made().weights(AT)[:, order], atol=1e-10)


@pytest.mark.parametrize(
    ("named", "change"),
    [
        ("points", {"x": np.where(np.arange(50).reshape(25, 2) == 7, np.nan, X)}),
        ("points", {"x": np.where(np.arange(50).reshape(25, 2) == 7, np.inf, X)}),
        ("points", {"x": X[:, 0]}),
        ("points", {"x": np.zeros((0, 2)), "y": np.zeros(0)}),
        ("points", {"x": np.zeros((25, 0))}),
        ("points", {"x": "ab"}),
        ("values", {"y": np.where(np.arange(50).reshape(25, 2) == 7, np.nan, Y)}),
        ("values", {"y": Y[:24]}),
        ("values", {"y": np.zeros((25, 0))}),
        ("noise", {"noise": -1e-9}),
        ("noise", {"noise": np.nan}),
        ("noise", {"covariance": SE + WhiteKernel(0.1)}),
        ("noise", {"covariance": SE + WhiteKernel(0.1) + WhiteKernel(0.1), "noise": 0.0}),
        ("covariance", {"covariance": SE * WhiteKernel(0.1)}),
        ("covariance", {"covariance": WhiteKernel(0.1), "noise": 0.0}),
        ("covariance", {"covariance": RBF([1.0, 1.0, 1.0])}),
        ("covariance", {"covariance": lambda x, y: 1.0}),
        ("mean", {"mean": np.nan}),
        ("mean", {"mean": [1.0, 2.0, 3.0]}),
        ("most_jitter", {"most_jitter": -1.0}),
        ("most_iterations", {"optimise": True, "most_iterations": 0}),
        ("restarts", {"optimise": True, "restarts": -1}),
    ],
)
def test_bad_input_is_named(named, change) -> None:
    with pytest.raises(InputError, match=named):
        made(**change)


@pytest.mark.filterwarnings("ignore:overflow")
def test_covariances_that_overflow_are_refused() -> None:
    with pytest.raises(InputError, match="not finite"):
        made([[1e200], [1.0]], [1.0, 2.0], DotProduct(1.0))


def test_covariances_with_several_numbers_for_two_points_are_refused() -> None:
    with pytest.raises(InputError, match="covariance"):
        made(covariance=CompoundKernel([RBF(1.0), RBF(2.0)]))


def test_a_process_tells_itself() -> None:
    assert repr(made()) == f"GaussianProcess(25 observations in 2 dimensions, {SE}, noise 0.05: EXACT, GIVEN)"


def test_other_names_are_not_there() -> None:
    assert "fit" in dir(subgoal.gaussian)
    with pytest.raises(AttributeError, match="nothing"):
        _ = subgoal.gaussian.nothing


@pytest.mark.parametrize("at", [[[np.nan, 0.0]], [[0.0]], [0.0, 0.0], "ab"])
def test_places_are_checked(at) -> None:
    process = made()
    for ask in (process.mean, process.variance, process.weights):
        with pytest.raises(InputError, match="at"):
            ask(at)


def test_no_places_give_no_answers() -> None:
    process, none = made(), np.zeros((0, 2))
    assert process.mean(none).shape == (0, 2)
    assert process.variance(none).shape == (0,)
    assert process.weights(none).shape == (0, 25)


def test_inputs_stay_as_they_are_and_the_record_cannot_be_changed() -> None:
    x, y, covariance = np.asfortranarray(X), Y.copy(), SE.clone_with_theta(SE.theta)
    process = fit(x, y, covariance, noise=NOISE, most_iterations=3)
    assert (x == X).all() and (y == Y).all() and (covariance.theta == SE.theta).all()
    x[0] = 9.0
    assert process.points[0, 0] == X[0, 0]
    with pytest.raises(ValueError, match="read-only"):
        process.values[0] = 1.0
    with pytest.raises(AttributeError):
        process.noise = 1.0
