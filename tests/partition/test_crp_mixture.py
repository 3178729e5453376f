"""The mixture samplers as users call them: frequencies against enumeration, the record, seeds, bad input."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.stats import chisquare

from subgoal.partition.crp import log_eppf
from subgoal.partition.crp_mixture import collapsed_gibbs, neal_8
from subgoal.partition.crp_mixture_literal import UnnormalisedGaussian, literal_algorithm_2
from subgoal.partition.crp_seating import choose
from subgoal.partition.normal_inverse_wishart import NormalInverseWishart
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream
from tests.oracles.partitions import blocks, canonical, crp_probability, set_partitions

LEVEL = 3e-6
SAMPLERS = [collapsed_gibbs, neal_8, literal_algorithm_2]
EXACT = [collapsed_gibbs, partial(neal_8, auxiliaries=1), partial(neal_8, auxiliaries=4)]


def small_case():
    points = np.array([[-1.0], [-0.7], [0.4], [1.3]])
    return points, NormalInverseWishart([0.1], 0.3, [[0.15]], 2.5), 3.0


def some_clusters() -> np.ndarray:
    centres = np.array([[0.0, 0.0], [7.0, 1.0], [1.0, 7.0]])
    return np.concatenate([c + stream(4, k).standard_normal((20, 2)) for k, c in enumerate(centres)])


@pytest.mark.parametrize("sampler", EXACT, ids=["collapsed", "neal-8, m=1", "neal-8, m=4"])
def test_frequencies_match_the_enumerated_posterior(sampler):
    """3,000 independent chains that start at an exact posterior draw must still be posterior draws after 3 sweeps.

    The draws are independent, so chi-square is exact; it finds a total variation of 0.12 and more.
    """
    points, base, eta = small_case()
    states = list(set_partitions(4))
    law = np.array(
        [crp_probability(z, eta) * np.exp(sum(base.log_marginal(points[b]) for b in blocks(z))) for z in states]
    )
    law /= law.sum()
    starts = stream(21).choice(len(states), size=1_500, p=law)
    counts = np.zeros(len(states))
    generator = stream(22)
    for start in starts:
        draws = sampler(points, base, concentration=eta, sweeps=3, generator=generator, start=states[start])
        counts[states.index(canonical(draws.labels[-1].tolist()))] += 1
    assert chisquare(counts, 1_500 * law).pvalue > LEVEL


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_the_record_is_consistent(sampler):
    points = some_clusters()
    base = NormalInverseWishart.from_data(points)
    draws = sampler(points, base, concentration=1.0, sweeps=6, generator=stream(1), start=np.arange(60) % 7)
    assert draws.labels.shape == (7, 60)
    for t, row in enumerate(draws.labels):
        assert set(row.tolist()) == set(range(draws.n_clusters[t]))
        wanted = log_eppf(np.bincount(row), 1.0) + sum(base.log_marginal(points[b]) for b in blocks(row.tolist()))
        assert draws.log_joint[t] == pytest.approx(wanted, rel=1e-10)
        if draws.parameters:
            assert draws.parameters[t].shape == (draws.n_clusters[t], 6)
    assert bool(draws.parameters) == (sampler is not collapsed_gibbs)
    np.testing.assert_array_equal(draws.clusters_above(0.0), draws.n_clusters)
    assert (draws.clusters_above(1.0) == 0).all()


@pytest.mark.parametrize("sampler", [collapsed_gibbs, neal_8])
def test_three_far_clusters_are_found(sampler):
    points = some_clusters()
    base = NormalInverseWishart.from_data(points)
    start = stream(2).integers(10, size=60)
    draws = sampler(points, base, concentration=1.0, sweeps=30, generator=stream(3), start=start)
    assert (draws.clusters_above(0.05)[-5:] == 3).all()
    last = draws.labels[-1]
    common = [np.bincount(last[k * 20 : k * 20 + 20]).argmax() for k in range(3)]
    assert len(set(common)) == 3
    assert np.mean(last == np.repeat(common, 20)) > 0.9


def test_parameters_come_from_their_clusters():
    """Neal-8 redraws (μ, Σ) after the labels, in the order of the labels."""
    points = some_clusters()
    base = NormalInverseWishart.from_data(points)
    draws = neal_8(points, base, concentration=1e-6, sweeps=3, generator=stream(5), start=np.repeat([4, 9, 2], 20))
    for k, row in enumerate(draws.parameters[-1]):
        members = points[draws.labels[-1] == k]
        assert np.abs(row[:2] - members.mean(axis=0)).max() < 1.5


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_a_seed_fixes_everything_and_nothing_is_changed(sampler):
    points, base, eta = small_case()
    points.flags.writeable = False
    start = np.array([7, 7, 3, 3])
    np.random.seed(0)  # noqa: NPY002 - the global state is what is watched
    before = np.random.get_state()[1].copy()  # noqa: NPY002
    one, two = (sampler(points, base, concentration=eta, sweeps=20, generator=stream(8, 1), start=start) for _ in "ab")
    np.testing.assert_array_equal(one.labels, two.labels)
    np.testing.assert_array_equal(one.log_joint, two.log_joint)
    np.testing.assert_array_equal(start, [7, 7, 3, 3])
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002
    with pytest.raises(ValueError, match="read-only"):
        one.labels[0, 0] = 1


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_no_sweeps_and_one_point(sampler):
    base = NormalInverseWishart([0.0], 1.0, [[1.0]], 3.0)
    draws = sampler([[0.5]], base, concentration=1.0, sweeps=0, generator=stream(0))
    assert draws.labels.tolist() == [[0]]
    draws = sampler([[0.5]], base, concentration=1.0, sweeps=3, generator=stream(0))
    assert draws.n_clusters.tolist() == [1, 1, 1, 1]


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize(
    ("named", "changed"),
    [
        ("points", {"points": [[np.nan], [0.0]]}),
        ("points", {"points": [0.0, 1.0]}),
        ("points", {"points": np.empty((0, 1))}),
        ("points", {"points": [[0.0, 1.0]]}),
        ("concentration", {"concentration": 0.0}),
        ("concentration", {"concentration": -1.0}),
        ("concentration", {"concentration": np.nan}),
        ("sweeps", {"sweeps": -1}),
        ("sweeps", {"sweeps": 2.5}),
        ("start", {"start": [0, 1]}),
        ("start", {"start": [0.0, 1.0, 2.0, 3.0]}),
    ],
)
def test_bad_input_is_named(sampler, named, changed):
    points, base, eta = small_case()
    given = {"points": points, "concentration": eta, "sweeps": 2, "start": None} | changed
    with pytest.raises(InputError, match=named):
        sampler(given.pop("points"), base, generator=stream(0), **given)


@pytest.mark.parametrize("m", [0, -1, 1.5, True])
def test_auxiliaries_are_checked(m):
    points, base, eta = small_case()
    with pytest.raises(InputError, match="auxiliaries"):
        neal_8(points, base, concentration=eta, sweeps=1, generator=stream(0), auxiliaries=m)


@pytest.mark.parametrize("weights", [[-np.inf, -np.inf], [np.nan, 0.0]])
def test_an_impossible_point_is_refused(weights):
    with pytest.raises(InputError, match="points"):
        choose(np.array(weights), stream(0))


def test_printed_likelihood_says_nothing_about_the_partition():
    """−½ Σ d² at the maximum likelihood fits is −½ N d for any partition into clusters of full rank."""
    points = some_clusters()
    printed = UnnormalisedGaussian(points)
    for seed in range(3):
        label = stream(31, seed).integers(4, size=60)
        totals = np.array([printed.statistics(points[label == k]).sum(axis=0) for k in range(4)])
        score = printed.log_likelihood(points, printed.draw_given(totals, stream(0)))
        assert score[np.arange(60), label].sum() == pytest.approx(-60.0, rel=1e-9)


def test_printed_fit_of_one_point_has_no_width():
    points = some_clusters()
    printed = UnnormalisedGaussian(points)
    score = printed.log_likelihood(points, printed.draw_given(printed.statistics(points[:1]), stream(0)))[:, 0]
    assert score[0] == 0.0
    assert np.isneginf(score[1:]).all()
    with pytest.raises(InputError, match="prior"):
        printed.log_marginal_of(printed.statistics(points))
