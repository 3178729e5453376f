"""The table: tiles, marginals, confidence, impossible observations, and numbers of one's own."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import table as tables
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError
from tests.likelihood.test_action_comparison import METRICS, scene
from tests.oracles import directions as oracle
from tests.posterior.worlds import quiet_sample


def weighted_prior(candidates: Candidates) -> Candidates:
    prior = np.random.default_rng(9).normal(scale=3, size=candidates.n_candidates)
    return Candidates(candidates.points, prior, radius=candidates.radius, metric=candidates.metric)


@pytest.mark.parametrize("controller", [False, True])
def test_tiles_are_the_whole_table(controller: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "TILE_ENTRIES", 100)
    metric = METRICS["angle"]
    demos, candidates = scene(metric, n=50, g_count=20)
    settings = (
        {"controller": subgoal.controllers.straight_to_goal(metric), "compare": "direction"} if controller else {}
    )
    whole, tiled = (
        subgoal.action_comparison(demos, weighted_prior(candidates), dense_entries=entries, **settings)
        for entries in (10_000, 999)
    )
    assert whole.is_dense and not tiled.is_dense
    assert tiled.dense is None and tiled.relative is None
    starts, tiles = zip(*tiled.tiles(), strict=True)
    assert len(tiles) == 10
    np.testing.assert_array_equal(np.concatenate(tiles), whole.dense)
    np.testing.assert_array_equal(tiled.log_marginal, whole.log_marginal)
    relative = np.concatenate([tiled.relative_tile(a, tile) for a, tile in zip(starts, tiles, strict=True)])
    np.testing.assert_array_equal(relative, whole.relative)
    np.testing.assert_array_equal(tiled.arrived.toarray(), whole.arrived.toarray())


def test_log_marginal_is_the_sum_over_candidates() -> None:
    for scale in (1.0, 10.0, 100.0):
        generator = np.random.default_rng(1)
        values, prior = generator.normal(scale=scale, size=(30, 8)), generator.normal(scale=scale, size=8)
        likelihood = LogLikelihood.from_table(values, candidates=Candidates(np.arange(8.0), prior))
        wanted = [oracle.log_sum(row, likelihood.log_prior) for row in values]
        np.testing.assert_allclose(likelihood.log_marginal, wanted, rtol=1e-13, atol=1e-12)
        np.testing.assert_allclose(likelihood.relative, np.exp(values - np.array(wanted)[:, None]), rtol=1e-10)


def test_an_improbable_candidate_may_be_the_only_good_one() -> None:
    candidates = Candidates([0.0, 1.0], np.array([-550.0, 0.0]))
    assert LogLikelihood.from_table([[0.0, -600.0]], candidates=candidates).log_marginal[0] == pytest.approx(-550.0)


def test_the_sum_over_the_base_matters_as_much_as_the_peak() -> None:
    """Many moderate candidates outweigh one good one: the weight of a new subgoal is the sum, never the best."""
    values = np.full((1, 1001), -3.0)
    values[0, 0] = 0.0
    marginal = LogLikelihood.from_table(values).log_marginal[0]
    assert marginal == pytest.approx(np.log((1 + 1000 * np.exp(-3.0)) / 1001), abs=1e-12)


def test_confidence_can_be_changed_afterwards() -> None:
    demos, candidates = scene(METRICS["weights"])
    first = subgoal.action_comparison(demos, candidates, confidence=2.0)
    before = first.dense.copy()
    np.testing.assert_array_equal(
        first.at(5.0).dense, subgoal.action_comparison(demos, candidates, confidence=5.0).dense
    )
    np.testing.assert_array_equal(first.at(5.0).at(2.0).log_marginal, first.log_marginal)
    np.testing.assert_array_equal(first.dense, before)
    assert (first.confidence, first.at(5.0).confidence) == (2.0, 5.0)
    for bad in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="confidence"):
            first.at(bad)


def test_scaling_the_norm_is_scaling_the_confidence() -> None:
    """E26: it is consequential. With log Z the confidence of a demonstrator can be told; without, none is the best.

    1,000 directions drawn at α = 3 towards one goal: the complete density peaks within five standard errors (0.5).
    """
    generator = np.random.default_rng(8)
    angle = np.linspace(-np.pi, np.pi, 20_001)
    mass = np.cumsum(np.exp(-6.0 * np.abs(np.sin(angle / 2))))
    drawn = np.interp(generator.random(1000) * mass[-1], mass, angle)
    actions = np.column_stack([np.cos(drawn), np.sin(drawn)])
    demos = Demonstrations.from_arrays(np.zeros((1000, 2)), actions)
    table = subgoal.action_comparison(demos, Candidates([[5.0, 0.0]]))
    alphas = np.arange(0.5, 8.0, 0.1)
    complete = np.array([table.at(alpha).log_marginal.sum() for alpha in alphas])
    bare = complete + 1000 * np.array([oracle.log_direction_normaliser(alpha, 2) for alpha in alphas])
    assert abs(alphas[complete.argmax()] - 3.0) <= 0.5
    assert bare.argmax() == 0
    chord = 2 * np.abs(np.sin(drawn / 2))
    np.testing.assert_allclose(bare, -alphas * chord.sum(), rtol=1e-9)


def test_a_factor_common_to_all_candidates_cancels() -> None:
    """E26, the other half: the draws stay the same, the log likelihood moves by the factors."""
    values = np.random.default_rng(2).normal(size=(25, 6))
    shift = 2.0 ** np.random.default_rng(3).integers(-3, 4, size=25)
    settings = {"chains": 2, "draws": 40, "warmup": 5, "thin": 2}
    one = quiet_sample(LogLikelihood.from_table(values), **settings)
    two = quiet_sample(LogLikelihood.from_table(values + shift[:, None]), **settings)
    np.testing.assert_array_equal(one.assignments, two.assignments)
    np.testing.assert_allclose(one.log_likelihood + shift.sum(), two.log_likelihood, rtol=1e-12)


def test_given_numbers_know_one_confidence_only() -> None:
    likelihood = LogLikelihood.from_table(np.zeros((3, 2)))
    assert likelihood.confidence == 1.0
    with pytest.raises(InputError, match="confidence"):
        likelihood.at(2.0).rows(0, 1)


def test_impossible_observations_are_named() -> None:
    values = np.zeros((5, 3))
    values[3] = -np.inf
    with pytest.raises(InputError, match="observation 3: found log density -inf"):
        LogLikelihood.from_table(values).log_marginal  # noqa: B018
    with pytest.raises(InputError, match="observation 3"):
        quiet_sample(LogLikelihood.from_table(values))


@pytest.mark.parametrize("dense_entries", [0, 10**6])
def test_impossible_pairs_are_never_drawn(dense_entries: int) -> None:
    values = np.where(np.random.default_rng(3).random((40, 5)) < 0.6, -np.inf, 0.0)
    values[np.arange(40), np.arange(40) % 5] = -0.5
    likelihood = LogLikelihood.from_table(values, dense_entries=dense_entries)
    for sampler in (subgoal.samplers.collapsed_blocks, subgoal.samplers.alg4_corrected):
        posterior = quiet_sample(likelihood, sampler=sampler, chains=4, draws=20, warmup=0, thin=1)
        assert np.isfinite(posterior.log_joint).all()
        assert np.isfinite(values[np.arange(40), posterior.assignments]).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [([[0.0, np.nan]], r"index \(0, 1\)"), ([[0.0], [np.inf]], r"index \(1, 0\)"), (np.zeros((0, 3)), "shape"),
     (np.zeros(3), "2 dimensions"), ([["a"]], "real numbers"), (np.zeros((2, 2), complex), "real numbers"),
     (np.zeros((2, 0)), "shape")],
)  # fmt: skip
def test_bad_numbers_are_refused(values, message: str) -> None:
    with pytest.raises(InputError, match=message):
        LogLikelihood.from_table(values)


def test_a_source_that_gives_nan_is_named() -> None:
    demos, candidates = scene(METRICS["plain 2-D"])
    likelihood = subgoal.action_comparison(demos, candidates)
    object.__setattr__(likelihood, "source", tables.FixedTable(np.full((12, 7), np.nan)))
    object.__setattr__(likelihood, "confidence", 1.0)
    with pytest.raises(InputError, match="observation 0: found log density nan"):
        likelihood.log_marginal  # noqa: B018


def test_sizes_that_do_not_fit() -> None:
    with pytest.raises(InputError, match="candidates: found 2"):
        LogLikelihood.from_table(np.zeros((4, 3)), candidates=Candidates([0.0, 1.0]))
    demos, _ = scene(METRICS["plain 2-D"])
    with pytest.raises(InputError, match="demonstrations: found 12"):
        LogLikelihood.from_table(np.zeros((4, 3)), demonstrations=demos)


@pytest.mark.parametrize("form", ["fortran", "float32", "list", "read-only", "strided"])
def test_any_array_of_numbers_serves_and_stays_as_it_was(form: str) -> None:
    plain = np.arange(12.0).reshape(4, 3)
    given = {
        "fortran": np.asfortranarray(plain), "float32": plain.astype(np.float32), "list": plain.tolist(),
        "read-only": plain.copy(), "strided": np.repeat(plain, 2, axis=0)[::2],
    }[form]  # fmt: skip
    if form == "read-only":
        given.flags.writeable = False
    likelihood = LogLikelihood.from_table(given)
    np.testing.assert_array_equal(likelihood.dense, plain)
    assert not likelihood.dense.flags.writeable
    np.testing.assert_array_equal(given, plain)
    if isinstance(given, np.ndarray) and form != "read-only":
        assert given.flags.writeable


def test_metrics_that_are_not() -> None:
    for weights, period in [([0.0], [np.inf]), ([1.0], [-1.0]), ([np.nan], [1.0]), ([1.0], [np.nan]), ([1, 1], [1])]:
        with pytest.raises(InputError):
            Metric(np.array(weights, float), np.array(period, float))
