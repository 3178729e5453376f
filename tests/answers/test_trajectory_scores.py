"""Errors of scores of whole trajectories, and differences of two models on the same ones."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from subgoal.answers.trajectory_scores import TrajectoryScores
from subgoal.runtime.errors import InputError


def test_the_standard_error_is_over_trajectories() -> None:
    nats = np.array([-3.0, -5.0, -1.0, -4.0])
    alike = TrajectoryScores(nats, np.full(4, 10))
    wanted = np.std(nats / 10 / math.log(2), ddof=1) / 2
    assert alike.standard_error == pytest.approx(wanted)
    assert (
        repr(alike)
        == f"TrajectoryScores({nats.mean() / 10 / math.log(2):.3f} ± {wanted:.3f} bits per decision, 4 trajectories)"
    )
    assert math.isnan(TrajectoryScores(nats[:1], np.array([3])).standard_error)


@pytest.mark.t2
def test_the_error_of_uneven_trajectories_is_what_repetition_gives() -> None:
    """40,000 sets of thirty trajectories, one to ten steps long: spread of the mean within 5 % of the mean error."""
    generator = np.random.default_rng(0)
    means, errors = [], []
    for _ in range(40_000):
        lengths = generator.integers(1, 11, 30)
        scores = TrajectoryScores(-lengths * generator.gamma(2.0, 1.0, 30), lengths)
        means.append(scores.bits_per_decision)
        errors.append(scores.standard_error)
    assert np.mean(errors) == pytest.approx(np.std(means), rel=0.05)


def test_differences_are_paired() -> None:
    generator = np.random.default_rng(1)
    base, decisions = generator.normal(-20, 10, 6), np.full(6, 5)
    gain = np.array([1.0, 2.0, 0.5, 1.5, 1.0, 0.0])
    better, worse = TrajectoryScores(base + gain, decisions), TrajectoryScores(base, decisions)
    found = better.difference(worse)
    bits = gain / 5 / math.log(2)
    assert found.bits_per_decision == pytest.approx(bits.mean())
    assert found.standard_error == pytest.approx(stats.sem(bits))
    wanted = stats.t.interval(0.95, 5, bits.mean(), stats.sem(bits))
    assert found.interval == pytest.approx(wanted)
    assert found.standard_error < better.standard_error / 5
    narrow = better.difference(worse, probability=0.5).interval
    assert narrow == pytest.approx(stats.t.interval(0.5, 5, bits.mean(), stats.sem(bits)))
    back = worse.difference(better)
    assert back.interval == pytest.approx((-wanted[1], -wanted[0]))
    with pytest.raises(InputError, match="same trajectories"):
        better.difference(TrajectoryScores(base, np.full(6, 4)))
    with pytest.raises(InputError, match="probability"):
        better.difference(worse, probability=1.0)
