"""The table and the candidates of a stream, after every point: those of the batch and of a plain greedy net."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.metric import Metric
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.streaming import Stream
from subgoal.streaming.growing import Growing, with_room
from tests.streaming.made import tell, uneven

WEIGHTED = Metric(np.array([1.0, 0.4]), np.full(2, np.inf))


def plain_net(trajectories: list[tuple[np.ndarray, np.ndarray]], radius: float, weights: np.ndarray) -> np.ndarray:
    """States of each trajectory as they come, but its last (which is its end) and the one before after the end."""
    kept: list[np.ndarray] = []

    def offer(place: np.ndarray, limit: float) -> None:
        if all(np.sqrt((((other - place) * weights) ** 2).sum()) > limit for other in kept):
            kept.append(place)

    for states, end in trajectories:
        for state in states[:-2]:
            offer(state, radius)
        offer(end, 0.0)
        for state in states[-2:]:
            offer(state, radius)
    return np.array(kept)


@pytest.mark.parametrize("metric", [None, WEIGHTED], ids=["plain", "weighted"])
def test_the_table_is_that_of_action_comparison_after_every_pair(metric: Metric | None) -> None:
    stream = Stream(2, radius=0.3, metric=metric, confidence=4.0, chains=1)
    for samples in (uneven(0), uneven(1)):
        for time, place in zip(*samples, strict=True):
            if stream.add(time, place) and stream.n_pairs > 1:
                found = stream.likelihood()
                wanted = action_comparison(stream.demonstrations(), stream.candidates(), confidence=4.0)
                np.testing.assert_array_equal(found.dense, wanted.dense)
                np.testing.assert_array_equal(found.source.uninformative, wanted.source.uninformative)
        stream.lift()
    np.testing.assert_array_equal(stream.likelihood().dense, _batch(stream, 4.0))


def _batch(stream: Stream, confidence: float) -> np.ndarray:
    table = action_comparison(stream.demonstrations(), stream.candidates(), confidence=confidence)
    assert table.dense is not None
    return table.dense


def test_pairs_become_slow_and_quick_again_as_the_median_speed_moves() -> None:
    """Steps of 1, then many of 500: the first are slower than a hundredth of the median; then many of 1 again."""
    steps = np.concatenate([np.ones(5), np.full(9, 500.0), np.ones(30)])
    stream = Stream(1, radius=2.0, rate=None, chains=1)
    slow = []
    for k, place in enumerate(np.cumsum(steps)):
        if stream.add(k, place):
            source = stream.likelihood().source
            slow.append(int(source.uninformative[:3].sum()))
            np.testing.assert_array_equal(stream.likelihood().dense, _batch(stream, 3.0))
    assert slow[2] == 0
    assert max(slow) == 3
    assert slow[-1] == 0


def test_a_pair_that_does_not_move_is_slow_from_the_first() -> None:
    stream = Stream(2, radius=0.3, rate=None, chains=1)
    for k in range(4):
        stream.add(k, [0.0, 0.0])
    stream.add(4, [1.0, 0.0])
    assert stream.likelihood().source.uninformative.tolist() == [True, True, True, False]
    np.testing.assert_array_equal(stream.likelihood().dense, _batch(stream, 3.0))


@pytest.mark.parametrize("metric", [None, WEIGHTED], ids=["plain", "weighted"])
def test_candidates_are_a_greedy_net_in_order_of_arrival(metric: Metric | None) -> None:
    stream = tell(Stream(2, radius=0.25, metric=metric, chains=1), uneven(0), uneven(1, begin=9.0), uneven(2))
    demos = stream.demonstrations()
    pieces = [demos.states[a:b] for a, b in zip(demos.offset[:-1], demos.offset[1:], strict=True)]
    weights = np.ones(2) if metric is None else metric.weights
    wanted = plain_net(list(zip(pieces, demos.final_states, strict=True)), 0.25, weights)
    np.testing.assert_array_equal(stream.candidates().points, wanted)
    assert len(wanted) > 12
    np.testing.assert_allclose(np.exp(stream.candidates().log_prior), 1 / len(wanted))
    assert stream.candidates().radius == 0.25


def test_an_end_is_a_candidate_however_near_the_others() -> None:
    stream = tell(Stream(2, radius=5.0, chains=1), uneven(0), uneven(1))
    points = stream.candidates().points
    np.testing.assert_array_equal(points[0], uneven(0)[1][0])
    np.testing.assert_array_equal(points[1:], [uneven(0)[1][-1], uneven(1)[1][-1]])


def test_an_end_that_is_one_already_is_not_another() -> None:
    stream = tell(Stream(2, radius=5.0, chains=1), uneven(0), uneven(0))
    assert stream.candidates().n_candidates == 2


def test_another_confidence_makes_another_table() -> None:
    stream = tell(Stream(2, radius=0.3, chains=1), uneven(0))
    stream.retune(confidence=0.7)
    np.testing.assert_array_equal(stream.likelihood().dense, _batch(stream, 0.7))
    tell(stream, uneven(1))
    np.testing.assert_array_equal(stream.likelihood().dense, _batch(stream, 0.7))


def test_growing_arrays_keep_what_they_hold() -> None:
    rows, wanted = Growing(2, dtype=np.int64), np.arange(2000).reshape(1000, 2)
    for k in range(0, 1000, 7):
        rows.extend(wanted[k : k + 7])
    np.testing.assert_array_equal(rows.rows, wanted)
    table = np.arange(6.0).reshape(2, 3)
    assert with_room(table, 2, 3) is table
    larger = with_room(table, 2, 4)
    assert larger.shape == (2, 6)
    np.testing.assert_array_equal(larger[:, :3], table)
