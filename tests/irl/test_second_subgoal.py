"""The confidence at which a second subgoal appears is that at which a mixture of two first beats one (V10)."""

from __future__ import annotations

import math

import numpy as np
import pytest

from subgoal import LogLikelihood
from subgoal.irl.second_subgoal import second_subgoal
from subgoal.runtime.errors import InputError
from tests.irl.energies import Energies, drawn, table

TWO = np.arange(40) % 2
WEIGHTS = np.concatenate([np.geomspace(1e-7, 0.5, 200), 1 - np.geomspace(1e-7, 0.5, 200)])


def two_beat_one(likelihood: LogLikelihood, alpha: float) -> bool:
    """By trying every pair of candidates at every weight of a grid."""
    density = np.exp(np.asarray(likelihood.at(alpha).dense))
    one = np.log(density).sum(axis=0).max()
    best = -np.inf
    for g in range(density.shape[1]):
        for h in range(g):
            mixed = WEIGHTS[:, None] * density[:, g] + (1 - WEIGHTS[:, None]) * density[:, h]
            best = max(best, np.log(mixed).sum(axis=1).max())
    return bool(best > one + 1e-10)


def brute_force(likelihood: LogLikelihood, low: float, high: float) -> float:
    levels = np.geomspace(low, high, 2 + int(np.log(high / low) / np.log(1.1)))
    first = next(k for k, level in enumerate(levels) if two_beat_one(likelihood, level))
    below, above = levels[first - 1], levels[first]
    while above > below * (1 + 1e-5):
        middle = np.sqrt(below * above)
        below, above = (below, middle) if two_beat_one(likelihood, middle) else (middle, above)
    return float(above)


@pytest.mark.parametrize("seed", range(6))
def test_it_is_where_the_best_pair_of_candidates_first_beats_one(seed: int) -> None:
    likelihood = table(drawn(40, confidence=4.0, seed=seed, goal=TWO if seed % 2 else None))
    found = second_subgoal(likelihood, low=0.01, high=1000.0)
    assert 0.01 < found.confidence < 1000
    assert found.confidence == pytest.approx(brute_force(likelihood, 0.01, 1000.0), rel=1e-3)
    assert found.best != found.second


def test_just_below_one_suffices_and_just_above_the_second_is_worth_its_weight() -> None:
    likelihood = table(drawn(40, confidence=4.0, seed=1, goal=TWO))
    found = second_subgoal(likelihood)
    for factor, more in ((1 - 1e-6, False), (1 + 1e-6, True)):
        rows = np.asarray(likelihood.at(factor * found.confidence).dense)
        gain = np.exp(rows - rows[:, [found.best]]).mean(axis=0)
        assert rows.sum(axis=0).argmax() == found.best
        assert (gain.max() > 1) == more
    assert gain.argmax() == found.second


def test_one_is_enough_for_ever_where_one_candidate_is_never_wrong() -> None:
    made = drawn(20)
    best = Energies(made.values, made.values[:, :, 0].argmax(axis=1))
    best.values[:, :, 1:] = 0.5
    found = second_subgoal(table(best), high=50.0)
    assert found.confidence == math.inf and found.second is None and found.best == 0
    assert "enough at every confidence up to 50" in str(found)


def test_one_is_not_enough_where_the_search_begins_above() -> None:
    found = second_subgoal(table(drawn(40, confidence=40.0, goal=TWO)), low=300.0, high=900.0)
    assert found.confidence == 0
    assert "not enough even at the lowest confidence, 300" in str(found)


@pytest.mark.parametrize("ends", [{"low": 0.0}, {"low": float("nan")}, {"low": 2.0, "high": 1.0}, {"high": np.inf}])
def test_ends_that_are_none_are_refused(ends) -> None:
    with pytest.raises(InputError):
        second_subgoal(table(drawn()), **ends)


def test_tables_of_given_numbers_are_refused() -> None:
    with pytest.raises(InputError, match="wanted 1, for a table of given numbers"):
        second_subgoal(LogLikelihood.from_table(np.zeros((3, 2))))
    with pytest.raises(InputError, match="wanted a LogLikelihood"):
        second_subgoal(np.zeros((3, 2)))
