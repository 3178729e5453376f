"""How the sticky hidden Markov model conducts itself: cuts, tiles, limits and bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from subgoal.partition.priors import Gamma
from subgoal.partition.sticky_hmm import StickyHMM
from subgoal.runtime.errors import InputError
from tests.exact.shared_tables import ALL, assert_cuts_change_nothing, distance_ratio, with_trajectories
from tests.exact.test_transition_sticky_hmm import GAMMA, STARTS, path_law, run
from tests.oracles.tables import PRIOR, TABLES


def test_cutting_a_run_and_its_tiles_changes_nothing() -> None:
    whole = assert_cuts_change_nothing(StickyHMM(Gamma(2.0, 1.0)), GAMMA, STARTS)
    assert whole.redraws.shape == (5, 3)


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (4, 1)])
def test_one_observation_and_one_candidate(shape: tuple[int, int]) -> None:
    dense = TABLES["generic"][: shape[0], : shape[1]]
    done = run(with_trajectories(dense, (0,)), StickyHMM(), 1000)
    assert np.isfinite(done.log_joint).all()
    if shape == (1, 3):
        law = PRIOR * np.exp(dense[0])
        assert distance_ratio(done.assignments, {(g,): float(p) for g, p in enumerate(law)}) <= 3
    else:
        assert (done.assignments == 0).all()


def test_one_step_trajectories_are_drawn_from_one_law() -> None:
    """No transitions at all: one group of first steps."""
    dense, starts = TABLES["generic"], (0, 1, 2, 3)
    law = path_law(dense, 0.8, 1.2, starts=starts)
    assert distance_ratio(run(with_trajectories(dense, starts), StickyHMM(2.0, 0.6), 2000).assignments, law) <= 3


def test_impossible_candidates_are_never_chosen() -> None:
    done = run(with_trajectories(ALL["barred"], STARTS), StickyHMM(), 500)
    assert not (done.assignments[:, 1] == 0).any()
    assert not (done.assignments[:, 2] == 1).any()
    assert np.isfinite(done.log_likelihood).all()


@pytest.mark.parametrize("fields", [{"mass": 0.0}, {"mass": float("nan")}, {"stickiness": 1.0}, {"stickiness": -0.1}])
def test_bad_numbers_are_refused(fields) -> None:
    with pytest.raises(InputError, match=r"mass of the rows|stickiness"):
        StickyHMM(**fields)


def test_too_many_candidates_are_refused() -> None:
    table = with_trajectories(np.zeros((2, 4097)), (0,), np.full(4097, 1 / 4097))
    with pytest.raises(InputError, match="at most 4096"):
        run(table, StickyHMM(), 1)


def test_the_model_can_be_compared_and_changed() -> None:
    assert StickyHMM() == StickyHMM()
    assert replace(StickyHMM(), stickiness=0.0).stickiness == 0.0
    assert StickyHMM().__name__ == "sticky hidden Markov model"
