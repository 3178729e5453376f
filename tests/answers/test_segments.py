"""Segments from hand-made draws: maximal runs, silent observations, probabilities, everything else."""

from __future__ import annotations

import numpy as np
import pytest

import subgoal
from subgoal.answers.segments import OTHER
from subgoal.candidates import Candidates
from tests.answers.made import posterior_of

APART = Candidates(np.arange(0.0, 40.0, 10.0)[:, None])


def spans(cut) -> list[tuple[int, int, int, int]]:
    return [(s.trajectory, s.start, s.stop, s.subgoal) for s in cut]


def test_maximal_runs_within_each_trajectory() -> None:
    theta = np.array([[0, 0, 0, 1, 1, 0, 0, 0, 0, 1]])
    cut = subgoal.segments(posterior_of(theta, APART, offset=[0, 2, 7, 10]))
    assert spans(cut) == [(0, 0, 2, 0), (1, 2, 3, 0), (1, 3, 5, 1), (1, 5, 7, 0), (2, 7, 9, 0), (2, 9, 10, 1)]
    assert len(cut) == 6
    assert cut.labels.tolist() == theta[0].tolist()
    assert [s.probability for s in cut] == [1.0] * 6


def test_labels_go_by_falling_share() -> None:
    """Candidate 2 has most observations, hence is listed subgoal 0."""
    cut = subgoal.segments(posterior_of(np.array([[1, 2, 2, 2, 0, 0]]), APART))
    assert cut.labels.tolist() == [2, 0, 0, 0, 1, 1]


def test_probability_is_the_mean_over_the_run() -> None:
    draws = np.array([[0, 0, 1, 1], [0, 0, 1, 1], [0, 1, 1, 1], [0, 1, 0, 1]])[:, [0, 1, 2, 3]]
    posterior = posterior_of(np.vstack([draws, [[0, 0, 1, 1]]]), APART)
    cut = subgoal.segments(posterior)
    found = subgoal.subgoals(posterior)
    first, second = (found.listed_group[g] for g in (0, 1))
    assert spans(cut) == [(0, 0, 2, first), (0, 2, 4, second)]
    assert [s.probability for s in cut] == pytest.approx([(1 + 0.6) / 2, (0.8 + 1) / 2])
    np.testing.assert_allclose(cut.probability[:, first], [1, 0.6, 0.2, 0], atol=1e-15)
    np.testing.assert_allclose(cut.probability.sum(axis=1), 1.0, atol=1e-15)


def test_merged_candidates_share_a_run() -> None:
    """Neither of two near candidates has half of an observation's draws; their place has all of it."""
    near = Candidates(np.array([[0.0], [1.0], [50.0]]), radius=1.0)
    draws = np.array([[0, 0, 1, 2], [1, 1, 0, 2], [0, 1, 1, 2], [2, 0, 0, 2]])
    cut = subgoal.segments(posterior_of(draws, near))
    assert spans(cut) == [(0, 0, 3, 0), (0, 3, 4, 1)]
    assert cut.items[0].probability == pytest.approx((0.75 + 1 + 1) / 3)


def test_silent_observations_take_the_last_label_that_spoke() -> None:
    theta = np.array([[1, 0, 0, 1, 1, 0, 1, 1]])
    silent = np.array([True, False, True, True, False, True, False, True])
    cut = subgoal.segments(posterior_of(theta, APART, silent=silent))
    one = int(cut.labels[1])
    assert cut.labels.tolist() == [one] * 4 + [1 - one] * 4
    assert spans(cut) == [(0, 0, 4, one), (0, 4, 8, 1 - one)]
    assert [s.probability for s in cut] == [1.0, 1.0]


def test_silence_does_not_reach_into_the_next_trajectory() -> None:
    theta = np.array([[0, 0, 1, 1, 1, 0]])
    silent = np.array([False, False, False, True, True, False])
    cut = subgoal.segments(posterior_of(theta, APART, offset=[0, 4, 6], silent=silent))
    assert cut.labels[3] == cut.labels[2] != cut.labels[0]
    assert cut.labels[4] == cut.labels[5] == cut.labels[0]


def test_a_trajectory_that_never_speaks_keeps_its_own_labels() -> None:
    silent = np.array([True, True, False, False])
    cut = subgoal.segments(posterior_of(np.array([[0, 0, 1, 1]]), APART, offset=[0, 2, 4], silent=silent))
    assert spans(cut) == [(0, 0, 2, 0), (1, 2, 4, 1)]
    assert cut.items[0].probability == 1.0


def test_everything_else_is_other() -> None:
    """Of 2,000 observations one serves a candidate below one percent: it is other, and certainly so."""
    theta = np.zeros((1, 2000), int)
    theta[0, 700] = 3
    cut = subgoal.segments(posterior_of(theta, APART))
    assert spans(cut) == [(0, 0, 700, 0), (0, 700, 701, OTHER), (0, 701, 2000, 0)]
    assert cut.labels[700] == -1
    assert cut.probability.shape == (2000, 2)
    assert cut.probability[700].tolist() == [0.0, 1.0]
    assert cut.probability[:700, -1].max() == 0.0


def test_nothing_else_is_an_empty_column() -> None:
    cut = subgoal.segments(posterior_of(np.array([[0, 1, 1]]), APART))
    assert cut.probability.shape == (3, 3)
    assert cut.probability[:, -1].tolist() == [0.0, 0.0, 0.0]


def test_times_of_first_and_last_observation() -> None:
    theta = np.array([[0, 0, 1, 1, 1]])
    timed = subgoal.segments(posterior_of(theta, APART, times=np.array([0.0, 0.5, 2.0, 2.5, 9.0])))
    assert [(s.begin, s.end) for s in timed] == [(0.0, 0.5), (2.0, 9.0)]
    plain = subgoal.segments(posterior_of(theta, APART))
    assert [(s.begin, s.end) for s in plain] == [(0.0, 1.0), (2.0, 4.0)]


def test_subgoals_may_be_given() -> None:
    near = Candidates(np.array([[0.0], [1.0]]), radius=1.0)
    posterior = posterior_of(np.array([[0, 0, 1]]), near)
    assert len(subgoal.segments(posterior)) == 1
    assert len(subgoal.segments(posterior, subgoal.subgoals(posterior, merge_radius=0.0))) == 2


def test_segments_tile_every_trajectory_of_a_real_posterior() -> None:
    from tests.posterior.worlds import corner_likelihood, quiet_sample

    posterior = quiet_sample(corner_likelihood(), chains=4, draws=100, warmup=50, thin=2)
    cut = subgoal.segments(posterior)
    assert cut.items[0].start == 0
    assert cut.items[-1].stop == posterior.n_observations
    for one, two in zip(cut.items, cut.items[1:], strict=False):
        assert one.stop == two.start
        assert one.subgoal != two.subgoal
    assert np.abs(cut.probability.sum(axis=1) - 1).max() <= 1e-12
