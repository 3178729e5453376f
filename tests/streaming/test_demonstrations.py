"""The pairs of a stream are those of the whole recording, and none is given before it is sure."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import InputError
from subgoal.streaming import Stream
from tests.streaming.made import assert_same, recording_of, tell, uneven


@pytest.mark.parametrize("window", [2, 3, 5])
@pytest.mark.parametrize("rate", [None, 20.0, 7.3, 400.0])
def test_pairs_are_those_of_the_whole_recording(rate: float | None, window: int) -> None:
    samples = [uneven(0), uneven(1, begin=2.5), uneven(2, 0.2, begin=-1.0)]
    stream = tell(Stream(2, radius=0.3, rate=rate, window=window, chains=1), *samples)
    assert_same(stream.demonstrations(), demonstrate(recording_of(*samples), rate=rate, window=window))


@pytest.mark.parametrize("dimension", [1, 3])
def test_pairs_of_any_dimension(dimension: int) -> None:
    samples = uneven(3, dimension=dimension)
    stream = tell(Stream(dimension, radius=0.3, chains=1), samples)
    assert_same(stream.demonstrations(), demonstrate(recording_of(samples), rate=20.0))


@pytest.mark.parametrize("window", [2, 5])
@pytest.mark.parametrize("rate", [None, 20.0])
def test_pairs_are_given_as_soon_as_they_are_sure(rate: float | None, window: int) -> None:
    """After every sample: the pairs are the first of the whole recording's, and all that the next could not change."""
    times, places = uneven(4, 1.0)
    whole = demonstrate(recording_of((times, places)), rate=rate, window=window)
    stream = Stream(2, radius=0.3, rate=rate, window=window, chains=1)
    for k, (time, place) in enumerate(zip(times, places, strict=True)):
        before = stream.n_pairs
        assert stream.add(time, place) == stream.n_pairs - before
        known = k + 1 if rate is None else int(np.ceil((time - times[0]) * rate))
        settled = known - (window - window // 2)
        assert stream.n_pairs == max(settled, 0)
        if settled > 0:
            found = stream.demonstrations()
            np.testing.assert_array_equal(found.states, whole.states[:settled])
            np.testing.assert_array_equal(found.actions, whole.actions[:settled])
            np.testing.assert_array_equal(found.times, whole.times[:settled])


def test_a_trajectory_that_goes_on_is_truncated_and_ends_in_its_last_pair() -> None:
    stream = tell(Stream(2, radius=0.3, chains=1), uneven(0))
    for time, place in zip(*uneven(1), strict=True):
        stream.add(time, place)
    found = stream.demonstrations()
    assert found.truncated.tolist() == [False, True]
    assert found.trajectory_names == ("T0", "T1")
    assert found.offset[-1] == stream.n_pairs
    np.testing.assert_array_equal(found.final_states[1], found.states[-1])


def test_samples_that_lie_on_the_grid_stay_what_they_were() -> None:
    """Known only at the end: times within rounding of the grid are kept, and with them places and velocities."""
    times = np.arange(60) / 20 + np.random.default_rng(0).uniform(-2e-8, 2e-8, 60)
    places = np.cumsum(np.random.default_rng(1).normal(size=(60, 2)), axis=0)
    stream = Stream(2, radius=3.0, chains=1)
    for time, place in zip(times, places, strict=True):
        stream.add(time, place)
    assert not np.array_equal(stream.demonstrations().times, times[: stream.n_pairs])
    stream.lift()
    assert_same(stream.demonstrations(), demonstrate(recording_of((times, places)), rate=20.0))
    np.testing.assert_array_equal(stream.demonstrations().times, times)


def test_a_trajectory_of_one_sample_is_dropped_and_counted() -> None:
    samples = [uneven(0), (np.zeros(1), np.zeros((1, 2))), uneven(1)]
    stream = tell(Stream(names=("x", "y"), radius=0.3, chains=1), *samples)
    wanted = demonstrate(recording_of(*samples, names=("x", "y")), rate=20.0)
    assert_same(stream.demonstrations(), wanted)
    assert wanted.trajectory_names == ("T0", "T2")


def test_a_trajectory_too_short_for_a_step_is_dropped_and_counted() -> None:
    stream = tell(Stream(2, radius=0.3, chains=1), uneven(0))
    stream.add(0.0, [0.0, 0.0])
    stream.add(1e-9, [0.0, 1e-9])
    assert stream.lift() == 0
    assert stream.demonstrations().n_trajectories == 1
    assert stream.demonstrations().source.notes["trajectories too short to resample dropped"] == 1


def with_gaps(seed: int, *lengths: float, begin: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """An uneven trajectory with a gap at each of some samples."""
    times, places = uneven(seed, begin=begin)
    for k, length in enumerate(lengths):
        times[(k + 1) * len(times) // (len(lengths) + 1) :] += length
    return times, places


@pytest.mark.parametrize("window", [2, 5])
@pytest.mark.parametrize("rate", [None, 20.0])
def test_gaps_cut_as_in_the_whole_recording(rate: float | None, window: int) -> None:
    """The second gap of the second trajectory is shorter than what cuts, and its third longer than any resampling."""
    samples = [uneven(0), with_gaps(1, 3.0, 0.9, 500.0), with_gaps(2, 2.0, begin=-7.0)]
    stream = tell(Stream(2, radius=0.3, rate=rate, window=window, max_gap=1.0, chains=1), *samples)
    wanted = demonstrate(recording_of(*samples), rate=rate, window=window, max_gap=1.0)
    assert wanted.trajectory_names == ("T0", "T1/0", "T1/1", "T1/2", "T2/0", "T2/1")
    assert_same(stream.demonstrations(), wanted)


def test_a_piece_of_one_sample_is_dropped_and_counted() -> None:
    times, places = uneven(0)
    times[40:] += 5.0
    times[41:] += 5.0
    stream = tell(Stream(2, radius=0.3, max_gap=1.0, chains=1), (times, places))
    wanted = demonstrate(recording_of((times, places)), rate=20.0, max_gap=1.0)
    assert wanted.trajectory_names == ("T0/0", "T0/2")
    assert_same(stream.demonstrations(), wanted)


def test_pieces_have_the_name_that_their_trajectory_is_given_at_its_end() -> None:
    stream = Stream(2, radius=0.3, max_gap=1.0, chains=1)
    for time, place in zip(*with_gaps(0, 3.0), strict=True):
        stream.add(time, place)
    assert stream.demonstrations().trajectory_names == ("T0/0", "T0/1")
    assert stream.demonstrations().truncated.tolist() == [True, True]
    stream.lift(name="door")
    tell(stream, uneven(1))
    assert stream.demonstrations().trajectory_names == ("door/0", "door/1", "T1")
    assert stream.demonstrations().truncated.tolist() == [True, False, False]


def test_a_sample_beyond_a_gap_settles_the_piece_before_it() -> None:
    stream = Stream(2, radius=0.3, rate=None, window=2, max_gap=1.0, chains=1)
    assert [stream.add(time, [time, 0.0]) for time in (0.0, 0.5, 1.5, 3.0, 3.5)] == [0, 1, 1, 1, 1]


def test_a_bad_sample_beyond_a_gap_cuts_nothing() -> None:
    stream = Stream(2, radius=0.3, rate=None, max_gap=1.0, chains=1)
    for time in (0.0, 0.5):
        stream.add(time, [time, 0.0])
    with pytest.raises(InputError, match="place"):
        stream.add(9.0, [np.nan, 0.0])
    assert stream.add(1.0, [1.0, 0.0]) == 1
    stream.lift()
    assert stream.demonstrations().trajectory_names == ("T0",)


def test_lifting_twice_is_lifting_once() -> None:
    stream = tell(Stream(2, radius=0.3, chains=1), uneven(0))
    assert stream.lift() == 0
    tell(stream, uneven(1))
    assert_same(stream.demonstrations(), demonstrate(recording_of(uneven(0), uneven(1)), rate=20.0))


def test_lifting_gives_the_last_pairs() -> None:
    times, places = uneven(0)
    stream = Stream(2, radius=0.3, rate=None, window=5, chains=1)
    for time, place in zip(times, places, strict=True):
        stream.add(time, place)
    assert stream.n_pairs == len(times) - 3
    assert stream.lift() == 3


def test_what_was_given_out_does_not_change() -> None:
    stream = tell(Stream(2, radius=0.3, chains=1), uneven(0))
    demonstrations, candidates = stream.demonstrations(), stream.candidates()
    table = stream.likelihood().dense.copy()
    likelihood = stream.likelihood()
    kept = demonstrations.states.copy(), candidates.points.copy()
    tell(stream, uneven(1))
    stream.retune(confidence=7.0)
    np.testing.assert_array_equal(demonstrations.states, kept[0])
    np.testing.assert_array_equal(candidates.points, kept[1])
    np.testing.assert_array_equal(likelihood.dense, table)


def test_seconds_since_1970_may_end_on_a_resampling_time() -> None:
    for count in range(20, 120):
        times = 1.7e9 + np.cumsum(np.full(count, 0.01))
        places = np.column_stack([np.arange(count) * 0.01, np.zeros(count)])
        stream = tell(Stream(2, radius=0.3, chains=1), (times, places))
        found, batch = stream.demonstrations(), demonstrate(Recording(places, times, [0, count], ("a", "b")), rate=20)
        np.testing.assert_array_equal(found.times, batch.times)
        np.testing.assert_array_equal(found.actions, batch.actions)
        np.testing.assert_array_equal(found.final_states, places[-1:])
