"""What errors are told from is held out in whole stretches, and nothing that overlaps with it is learned from."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.learned_pairs import held_out, transitions
from tests.dynamics.recorded import STEP, affine


@pytest.mark.parametrize("every", [1, 4])
@pytest.mark.parametrize("seed", range(4))
def test_what_is_learned_from_shares_no_pair_with_what_is_tested_on(every: int, seed: int) -> None:
    moves = transitions(affine((200, 150)), every * STEP, Metric.euclidean(2))
    span = np.arange(every)
    for train, test in held_out(moves, 0.2, seed):
        check(moves, train, test, span)


def check(moves, train, test, span) -> None:
    every = len(span)
    learned_from, tested_on = (set((moves.row[rows][:, None] + span).ravel()) for rows in (train, test))
    assert not learned_from & tested_on
    assert not (train & test).any()
    left = ~(train | test)
    assert all(set(row + span) & tested_on for row in moves.row[left])
    assert left.any() == (every > 1)


@pytest.mark.parametrize("every", [1, 4])
def test_stretches_are_whole_and_about_the_share_that_was_asked_for(every: int) -> None:
    moves = transitions(affine((200, 150)), every * STEP, Metric.euclidean(2))
    folds = held_out(moves, 0.2, 0)
    assert len(folds) == 5
    for _, test in folds:
        assert 0.12 < test.mean() < 0.28
        begins = np.flatnonzero(test & ~np.concatenate([[False], test[:-1]]))
        assert 1 <= len(begins) <= 7
    assert len({tuple(held_out(moves, 0.2, seed)[0][1]) for seed in range(5)}) == 5


def test_every_transition_is_tested_on_once() -> None:
    moves = transitions(affine((200, 150)), STEP, Metric.euclidean(2))
    for share in (0.1, 0.2, 0.5):
        np.testing.assert_array_equal(sum(test.astype(int) for _, test in held_out(moves, share, 3)), 1)
