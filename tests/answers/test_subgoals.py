"""Merged subgoals from hand-made draws: who is merged, where it sits, what is listed and counted."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError
from tests.answers.made import posterior_of


def line(*places: float, **fields) -> Candidates:
    return Candidates(np.array(places)[:, None], **fields)


def draws_with(counts: list[list[int]]) -> np.ndarray:
    """(draws, N) assignments with these counts per candidate, in order of candidates."""
    return np.array([np.repeat(np.arange(len(row)), row) for row in counts])


def test_complete_linkage_not_single() -> None:
    """Places 0, 4, 8 in a row: single linkage would merge all three within 5, complete linkage keeps 8 apart."""
    posterior = posterior_of(draws_with([[50, 30, 20]] * 4), line(0.0, 4.0, 8.1, radius=1.0))
    found = subgoal.subgoals(posterior)
    assert found.merge_radius == 5.0
    assert found.group.tolist() == [0, 0, 1]
    assert [item.members.tolist() for item in found.items] == [[0, 1], [2]]
    assert [item.share for item in found.items] == pytest.approx([0.8, 0.2])


def test_no_merged_place_is_wider_than_the_radius() -> None:
    generator = np.random.default_rng(0)
    candidates = Candidates(generator.uniform(0, 30, (60, 2)), radius=1.0)
    posterior = posterior_of(generator.integers(0, 60, (50, 300)), candidates)
    for merge_radius in (0.0, 2.0, 5.0, 12.0, 100.0):
        found = subgoal.subgoals(posterior, merge_radius=merge_radius)
        for item in found.items:
            places = candidates.points[item.members]
            assert np.linalg.norm(places[:, None] - places[None], axis=2).max() <= merge_radius
        sizes = [item.members.size for item in found.items]
        assert sum(sizes) == 60
        assert (max(sizes) == 1) == (merge_radius == 0.0)
        assert (len(sizes) == 1) == (merge_radius == 100.0)
        assert sum(item.share for item in found.items) == pytest.approx(1.0)


def test_angles_merge_across_the_seam() -> None:
    wrapped = line(0.1, 6.2, 3.0, radius=0.1, metric=Metric.of(1, period=[2 * np.pi]))
    found = subgoal.subgoals(posterior_of(draws_with([[4, 4, 2]]), wrapped))
    assert found.group.tolist() == [0, 0, 1]
    assert found.items[0].radius == pytest.approx(0.1 + 2 * np.pi - 6.2)


def test_a_merged_place_sits_at_its_heaviest_member() -> None:
    posterior = posterior_of(
        draws_with([[10, 0, 0, 90], [10, 60, 0, 30], [10, 60, 0, 30]]), line(9, 0, 0.5, 1, radius=1)
    )
    first, second = subgoal.subgoals(posterior).items
    assert (first.candidate, first.position.tolist(), first.label, second.label) == (3, [1.0], 1, 2)
    assert first.members.tolist() == [3, 1]
    assert first.member_shares == pytest.approx([0.5, 0.4])
    assert first.share == pytest.approx(0.9)
    assert first.expected_observations == pytest.approx(90.0)
    assert second.candidate == 0


def test_credible_set_is_the_fewest_members_with_95_percent() -> None:
    """Shares 60, 35, 3, 2: exactly 95 % is reached by two; with 59 it takes three."""
    for counts, size, radius in (([60, 35, 3, 2], 2, 1.0), ([59, 35, 4, 2], 3, 2.0), ([96, 2, 1, 1], 1, 0.0)):
        found = subgoal.subgoals(posterior_of(draws_with([counts]), line(0, 1, 2, 3, radius=1.0))).items
        assert len(found) == 1
        assert found[0].credible_set.tolist() == list(range(size))
        assert found[0].radius == radius


def test_thresholds_of_a_tenth_one_and_five_percent() -> None:
    """Of 10,000: 9 are left out, 10 are merged; 99 are not listed, 100 are; 499 are not counted, 500 are."""
    counts = [8783, 9, 10, 99, 100, 499, 500]
    found = subgoal.subgoals(posterior_of(draws_with([counts]), line(*range(0, 70, 10))))
    assert found.group.tolist() == [0, -1, 5, 4, 3, 2, 1]
    assert [item.candidate for item in found.items] == [0, 6, 5, 4, 3, 2]
    assert [item.candidate for item in found.listed] == [item.candidate for item in found] == [0, 6, 5, 4]
    assert found.n_subgoals == 2
    assert found.listed_group.tolist() == [0, -1, -1, -1, 3, 2, 1]
    assert found.n_subgoals_distribution == {2: 1.0}
    assert [item.inclusion for item in found.items] == [1, 1, 1, 1, 0, 0]
    assert [item.prominence for item in found.items] == [1, 1, 0, 0, 0, 0]


def test_number_of_subgoals_is_counted_per_draw_after_merging() -> None:
    """Two near candidates that share a place count once, whether they alternate or are used together."""
    counts = [[50, 50, 0], [100, 0, 0], [0, 100, 0], [30, 30, 40], [48, 48, 4], [0, 95, 5]]
    found = subgoal.subgoals(posterior_of(draws_with(counts), line(0.0, 1.0, 50.0, radius=1.0), chains=2))
    assert found.counted_per_draw.tolist() == [[1, 1, 1], [2, 1, 2]]
    assert found.n_subgoals_distribution == {1: pytest.approx(4 / 6), 2: pytest.approx(2 / 6)}
    apart = subgoal.subgoals(posterior_of(draws_with(counts), line(0.0, 1.0, 50.0, radius=1.0)), merge_radius=0.0)
    assert apart.n_subgoals_distribution == {1: pytest.approx(2 / 6), 2: pytest.approx(3 / 6), 3: pytest.approx(1 / 6)}


def test_share_interval_and_probabilities() -> None:
    counts = [[100 - k, k] for k in range(101)]
    item = subgoal.subgoals(posterior_of(draws_with(counts), line(0.0, 50.0))).items[1]
    assert item.share_interval == pytest.approx((0.05, 0.95))
    assert item.inclusion == pytest.approx(100 / 101)
    assert item.prominence == pytest.approx(96 / 101)


def test_names_stand_where_there_are_any() -> None:
    named = line(0.0, 10.0, names=("door", "gate"))
    assert [item.name for item in subgoal.subgoals(posterior_of(draws_with([[3, 7]]), named))] == ["gate", "door"]
    plain = subgoal.subgoals(posterior_of(draws_with([[3, 7]]), line(0.0, 10.0)))
    assert [item.name for item in plain] == ["subgoal 1", "subgoal 2"]


def test_ties_are_broken_by_the_first_candidate() -> None:
    found = subgoal.subgoals(posterior_of(draws_with([[5, 5, 5]]), line(0.0, 10.0, 20.0)))
    assert [item.candidate for item in found.items] == [0, 1, 2]


def test_nothing_reaches_a_tenth_of_a_percent() -> None:
    posterior = posterior_of(np.arange(4000).reshape(2000, 2), line(*range(4000)))
    found = subgoal.subgoals(posterior)
    assert (len(found.items), len(found), found.n_subgoals) == (0, 0, 0)
    assert found.n_subgoals_distribution == {0: 1.0}
    cut = subgoal.segments(posterior, found)
    assert cut.labels.tolist() == [-1, -1]
    assert cut.probability.tolist() == [[1.0], [1.0]]


def test_bad_radius() -> None:
    posterior = posterior_of(draws_with([[5, 5]]), line(0.0, 10.0))
    for bad in (-1.0, np.nan, "x"):
        with pytest.raises(InputError, match="merge_radius"):
            subgoal.subgoals(posterior, merge_radius=bad)


def test_residuals_of_perfect_and_of_uniform_directions() -> None:
    """Distance 0 and transform 0 for a demonstrator without noise; slow pairs and arrived ones are left out."""
    from tests.posterior.worlds import quiet_sample, two_corners

    demos = two_corners(noise=0.0)
    likelihood = subgoal.action_comparison(demos, Candidates([[10.0, 0.0], [10.0, 10.0]], radius=0.6), confidence=20.0)
    out = subgoal.residuals(quiet_sample(likelihood, chains=2, draws=50, warmup=20))
    assert out is not None
    assert 75 <= out.rows.size < 80
    assert np.median(out.distance) <= 1e-6
    assert np.median(out.transform) <= 1e-6
    assert out.expected.sum() == pytest.approx(1.0, abs=1e-9)
    table = LogLikelihood.from_table(np.zeros((3, 2)))
    assert subgoal.residuals(quiet_sample(table, chains=1, draws=2, warmup=0)) is None


def test_one_place_given_twice_is_one_subgoal() -> None:
    """With no radius coincident candidates are merged, and only they."""
    posterior = posterior_of(draws_with([[20, 0, 20], [0, 20, 20]]), line(0.0, 0.0, 1.0))
    found = subgoal.subgoals(posterior)
    assert found.n_subgoals == 2
    assert sorted(len(goal.members) for goal in found) == [1, 2]
