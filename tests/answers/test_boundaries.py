"""Boundaries between segments: the share of draws in which the subgoal changes, counted by hand."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

import subgoal
from subgoal.answers.segments import boundaries
from subgoal.candidates import Candidates
from subgoal.models import Persistent
from subgoal.runtime.errors import InputError
from tests.answers.made import posterior_of
from tests.posterior.worlds import corner_likelihood, quiet_sample

APART = Candidates(np.arange(0.0, 40.0, 10.0)[:, None])
NEAR = Candidates(np.array([[0.0], [1.0], [50.0]]), radius=1.0)


def test_a_boundary_is_where_the_subgoal_changes_in_so_many_draws() -> None:
    draws = np.array([[0, 0, 1, 1, 2, 2], [0, 1, 1, 1, 2, 3], [0, 1, 1, 1, 1, 3], [0, 0, 0, 1, 1, 3]])
    cut = subgoal.segments(posterior_of(draws, APART, offset=[0, 4, 6]))
    assert cut.boundary.tolist() == [1.0, 0.5, 0.25, 0.25, 1.0, 0.75]


def test_the_sum_is_the_expected_number_of_segments() -> None:
    generator = np.random.default_rng(0)
    draws, offset = generator.integers(0, 4, (30, 20)), [0, 7, 8, 20]
    ranges = list(itertools.pairwise(offset))
    counts = [len(ranges) + sum((np.diff(row[a:b]) != 0).sum() for a, b in ranges) for row in draws]
    found = boundaries(posterior_of(draws, APART, offset=offset))
    assert found.sum() == pytest.approx(np.mean(counts), abs=1e-12)


def test_a_switch_between_near_duplicates_is_none() -> None:
    draws = np.array([[0, 1, 0, 2], [1, 0, 1, 2], [0, 0, 1, 1]])
    posterior = posterior_of(draws, NEAR)
    np.testing.assert_allclose(subgoal.segments(posterior).boundary, [1, 0, 0, 2 / 3], atol=1e-15)
    alone = subgoal.subgoals(posterior, merge_radius=0.0)
    np.testing.assert_allclose(subgoal.segments(posterior, alone).boundary, [1, 2 / 3, 1, 2 / 3], atol=1e-15)


def test_the_background_and_candidates_in_no_subgoal_stand_for_themselves() -> None:
    """Of 2,500 observations one serves candidate 3 and one candidate 2, both below 0.1 %; one serves none."""
    theta = np.zeros((1, 2500), int)
    theta[0, 700:702] = [3, 2]
    posterior = posterior_of(theta, APART)
    theta = theta.copy()
    theta[0, 100] = -1
    posterior = replace(posterior, assignments=theta[None].astype(np.int32))
    assert (subgoal.subgoals(posterior).group[2:] < 0).all()
    assert np.flatnonzero(boundaries(posterior)).tolist() == [0, 100, 101, 700, 701, 702]


def test_silent_observations_are_passed_over() -> None:
    draws = np.array([[0, 1, 0, 1, 0], [0, 1, 1, 0, 0]])
    silent = np.array([False, True, False, True, False])
    found = boundaries(posterior_of(draws, APART, silent=silent))
    assert found.tolist() == [1.0, 0.0, 0.5, 0.0, 0.5]


def test_silence_at_the_beginning_hides_no_boundary_of_another_trajectory() -> None:
    """The second trajectory begins silent: its first observation that speaks has none before it."""
    draws = np.array([[0, 0, 1, 1, 1, 0, 1]])
    silent = np.array([False, False, True, True, False, False, False])
    found = boundaries(posterior_of(draws, APART, offset=[0, 2, 5, 7], silent=silent))
    assert found.tolist() == [1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0]
    never = boundaries(posterior_of(draws, APART, offset=[0, 4, 7], silent=np.ones(7, bool)))
    assert never.tolist() == [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0]


def test_no_more_than_marginals_can_move_without_one() -> None:
    """P(boundary) is at least the total variation between the laws of neighbours; no step is counted twice."""
    posterior = quiet_sample(corner_likelihood(), chains=2, draws=100, warmup=50, thin=2)
    cut = subgoal.segments(posterior)
    moved = 0.5 * np.abs(np.diff(cut.probability, axis=0)).sum(axis=1)
    assert (cut.boundary[1:] >= moved - 1e-12).all()
    assert cut.boundary.min() >= 0
    assert cut.boundary.max() <= 1


def test_of_subgoals_that_persist_the_boundary_is_at_the_corner() -> None:
    """The path turns at observation 40; the sum of chances near it is about one."""
    posterior = quiet_sample(corner_likelihood(), model=Persistent(), chains=2, draws=100, warmup=50, thin=2)
    found = boundaries(posterior)
    assert abs(int(np.argmax(found[1:])) + 1 - 40) <= 2
    assert found[36:45].sum() == pytest.approx(1, abs=0.3)


def test_without_assignments_there_are_none() -> None:
    posterior = replace(posterior_of(np.array([[0, 0, 1]]), APART), assignments=None)
    cut = subgoal.segments(posterior)
    assert cut.boundary is None
    assert len(cut) == 2
    with pytest.raises(InputError, match="assignments"):
        boundaries(posterior)
