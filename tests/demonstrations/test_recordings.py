"""Choosing, cutting and resampling trajectories; the records themselves."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from subgoal.demonstrations import Demonstrations, Recording, Source, resample, split_at_gaps, starting_in
from subgoal.demonstrations.angles import unwrapped
from subgoal.runtime.errors import InputError


def two(**fields):
    """Trajectory a: x = t² at 0, 1, 2, 4; b: x = 10, 20 at 0, 0.3."""
    return Recording(
        np.array([[0.0, 5], [1, 5], [4, 5], [16, 5], [10, 0], [20, 0]]), [0, 1, 2, 4, 0, 0.3], np.array([0, 4, 6]),
        ("x", "y"), trajectory_names=("a", "b"), **fields,
    )  # fmt: skip


def test_resampling_interpolates_and_keeps_the_last_sample():
    made = resample(two(), 2)
    assert made.positions[:, 0].tolist() == [0, 0.5, 1, 2.5, 4, 7, 10, 13, 16, 10, 20]
    assert made.times.tolist() == [0, 0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 0, 0.3]
    assert made.offset.tolist() == [0, 9, 11]
    assert made.source.notes == {"samples interpolated": 5}


def test_resampling_at_the_rate_of_the_recording_changes_nothing():
    times = np.arange(50) / 30 + 7
    recording = Recording(np.random.default_rng(0).normal(size=(50, 2)), times, np.array([0, 50]), ("x", "y"))
    made = resample(recording, 30)
    assert np.array_equal(made.positions, recording.positions)
    assert np.array_equal(made.times, times)
    assert made.source.notes == {}


def test_seconds_since_1970_are_so_coarse_that_the_end_may_be_a_resampling_time():
    for count in range(20, 120):
        times = 1.7e9 + np.cumsum(np.full(count, 0.01))
        made = resample(Recording(np.arange(count)[:, None], times, [0, count], ("x",)), 20)
        assert (np.diff(made.times) > 0).all()
        assert made.times[-1] == times[-1] and made.positions[-1, 0] == count - 1


def test_angles_are_interpolated_the_shorter_way_round():
    recording = Recording([[6.1, 6.1], [0.1, 0.1]], [0.0, 1.0], np.array([0, 2]), ("a", "x"))
    made = resample(unwrapped(recording, [2 * np.pi, np.inf]), 2)
    assert made.positions[1] == pytest.approx([(6.1 + 0.1 + 2 * np.pi) / 2, 3.1])


@given(st.lists(st.floats(0.01, 5), min_size=1, max_size=12), st.floats(0.3, 20))
def test_resampled_lines_stay_lines(steps, rate):
    times = np.append(0, np.cumsum(steps))
    recording = Recording((3 * times - 1)[:, None], times, np.array([0, len(times)]), ("x",))
    made = resample(recording, rate)
    assert made.positions[:, 0] == pytest.approx(3 * made.times - 1, abs=1e-5)
    assert made.times[-1] == times[-1]
    assert np.diff(made.times)[:-1] == pytest.approx(1 / rate, rel=1e-5)


def test_cutting_at_gaps_names_pieces_and_marks_them():
    cut = split_at_gaps(two(), 1.5)
    assert cut.offset.tolist() == [0, 3, 4, 6]
    assert cut.trajectory_names == ("a/0", "a/1", "b")
    assert cut.truncated.tolist() == [True, False, False]
    assert cut.source.notes == {"gaps split": 1}
    assert split_at_gaps(two(), 2).offset.tolist() == [0, 4, 6]


def test_the_time_between_trajectories_is_no_gap():
    recording = Recording([[0.0], [1.0], [2.0], [3.0]], [0.0, 1, 100, 101], np.array([0, 2, 4]), ("x",))
    assert split_at_gaps(recording, 5) is recording


def test_trajectories_are_chosen_by_their_start():
    chosen = starting_in(two(actions=np.arange(6.0)[:, None]), [5, -np.inf], [np.inf, 3])
    assert chosen.trajectory_names == ("b",)
    assert chosen.positions.tolist() == [[10, 0], [20, 0]]
    assert chosen.actions.tolist() == [[4], [5]]
    assert chosen.source.notes == {"trajectories starting elsewhere dropped": 1}
    for lower, upper in (([1000, 0], [2000, 1]), ([10, -1], [11, 1]), ([9, -1], [10, 1])):
        with pytest.raises(InputError, match="no trajectory left"):
            starting_in(two(), lower, upper)
    for bounds in ([0], [0, np.nan]):
        with pytest.raises(InputError, match="lower"):
            starting_in(two(), bounds, [1, 1])


def test_bad_periods_are_refused():
    for period in ([1.0], [0.0, 1.0]):
        with pytest.raises(InputError, match="period"):
            unwrapped(two(), period)


def test_times_that_stand_still_are_refused_with_their_row():
    with pytest.raises(InputError, match=r"times at row 2: found 1\.0 after 1\.0"):
        Recording([[0.0], [1.0], [2.0]], [0.0, 1.0, 1.0], np.array([0, 3]), ("x",))
    assert Recording([[0.0], [1.0]], [1.0, 0.0], np.array([0, 1, 2]), ("x",)).n_trajectories == 2


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"positions": [[0.0], [np.inf]]}, r"positions at index \(1, 0\)"),
        ({"times": [0.0]}, "times"),
        ({"offset": np.array([0, 3])}, "offset"),
        ({"offset": np.array([0, 0, 2])}, "trajectory 0"),
        ({"names": ("x", "y")}, "names"),
        ({"actions": [[1.0]]}, "actions"),
        ({"truncated": [True, False]}, "truncated"),
    ],
)
def test_recordings_check_their_fields(fields, message):
    given_fields = {"positions": [[0.0], [1.0]], "times": [0.0, 1.0], "offset": np.array([0, 2]), "names": ("x",)}
    with pytest.raises(InputError, match=message):
        Recording(**{**given_fields, **fields})


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"states": [[np.nan], [1.0]]}, r"states at index \(0, 0\)"),
        ({"actions": [1.0]}, "actions: found 1 rows"),
        ({"states": []}, "no observations"),
        ({"final_states": [[1.0], [2.0]]}, "final_states"),
        ({"final_states": [[1.0, 2.0]]}, "final_states"),
        ({"truncated": [True, True]}, "truncated"),
        ({"times": [1.0]}, "times"),
        ({"trajectory_names": ("a", "b")}, "trajectory_names"),
    ],
)
def test_demonstrations_check_their_fields(fields, message):
    given_fields = {"states": [[0.0], [1.0]], "actions": [1.0, 2.0], "offset": np.array([0, 2])}
    with pytest.raises(InputError, match=message):
        Demonstrations(**{**given_fields, **fields})


def test_demonstrations_from_arrays_are_unordered_pairs_and_leave_the_input_alone():
    states = np.array([[0.0, 1.0], [3.0, 1.0]])
    demos = Demonstrations.from_arrays(states, [1, 0])
    assert demos.offset.tolist() == [0, 1, 2]
    assert demos.trajectory.tolist() == [0, 1]
    assert demos.actions.dtype == np.int64
    assert demos.extent == 3
    assert demos.final_states.tolist() == states.tolist()
    assert states.flags.writeable
    assert not demos.states.flags.writeable


def test_sources_add_up_their_notes():
    source = Source("f", notes={"rows dropped": 2}).noting(rows_dropped=3, gaps_split=0)
    assert source.notes == {"rows dropped": 5}
