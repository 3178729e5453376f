"""Dimensions that wrap: the pairs of the batch to the last bit, its table to rounding."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.prepare import demonstrate
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.streaming import Stream
from tests.streaming.made import assert_same, recording_of, tell, uneven

TURN = 2 * np.pi
PERIOD = (np.inf, TURN)
METRIC = Metric.of(2, (1.0, 0.5), PERIOD)


def turning(seed: int, low: float) -> tuple[np.ndarray, np.ndarray]:
    """A place along a line and an angle, from ``low`` to ``low`` + 2π, that goes round and back some times."""
    times, places = uneven(seed, 4.0)
    angle = 5 * places[:, 1] - 3
    return times, np.column_stack([places[:, 0], low + np.mod(angle - low, TURN)])


@pytest.mark.parametrize("window", [2, 5])
@pytest.mark.parametrize("rate", [None, 20.0])
@pytest.mark.parametrize("lows", [(0.0, 0.0), (-np.pi, -np.pi), (0.0, -np.pi)], ids=["from 0", "around 0", "later"])
def test_pairs_are_those_of_the_whole_recording(lows: tuple[float, float], rate: float | None, window: int) -> None:
    samples = [turning(seed, low) for seed, low in enumerate(lows)]
    assert max(np.abs(np.diff(places[:, 1])).max() for _, places in samples) > 6
    stream = tell(Stream(2, radius=0.3, rate=rate, window=window, metric=METRIC, chains=1), *samples)
    assert_same(stream.demonstrations(), demonstrate(recording_of(*samples), rate=rate, window=window, period=PERIOD))


def test_jumps_of_half_a_period_go_as_in_the_batch() -> None:
    places = np.cumsum([[0.0, 0.0], [0.1, 2.0], [0.1, -2.0], [0.1, 1.0], [0.1, 2.0], [0.1, 2.5], [0.1, -3.0]], axis=0)
    samples, metric = (np.arange(7.0), places), Metric.of(2, period=(np.inf, 4.0))
    stream = tell(Stream(2, radius=0.3, rate=None, metric=metric, chains=1), samples)
    assert_same(stream.demonstrations(), demonstrate(recording_of(samples), period=(np.inf, 4.0)))


def test_the_table_is_that_of_action_comparison() -> None:
    stream = tell(Stream(2, radius=0.2, metric=METRIC, chains=1), turning(0, -np.pi), turning(1, -np.pi))
    wanted = action_comparison(stream.demonstrations(), stream.candidates())
    np.testing.assert_allclose(stream.likelihood().dense, wanted.dense, rtol=1e-9)
    assert stream.likelihood().candidates.points[:, 1].max() < np.pi


def test_candidates_lie_apart_the_shorter_way_round() -> None:
    stream = tell(Stream(2, radius=0.2, metric=METRIC, chains=1), turning(0, 0.0))
    points, states = stream.candidates().points, stream.demonstrations().states
    ends = len(points) - 1
    apart = METRIC.distance(points[:ends, None], points[None, :ends])[np.triu_indices(ends, 1)]
    assert apart.min() > 0.2
    assert METRIC.distance(states[:, None], points[None]).min(axis=1).max() <= 0.2
    assert ((points[:, 1] >= 0) & (points[:, 1] < TURN)).all()


def test_subgoals_and_posterior_lie_within_one_period() -> None:
    stream = tell(Stream(2, radius=0.3, metric=METRIC), turning(0, 0.0), turning(1, 0.0))
    for item in stream.subgoals():
        assert 0 <= item.position[1] < TURN
    with pytest.warns(UserWarning):
        posterior = stream.posterior(20)
    np.testing.assert_array_equal(posterior.candidates.points, stream.candidates().points)
