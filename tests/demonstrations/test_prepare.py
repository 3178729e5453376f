"""Velocities, subsampling and ends of trajectories, against numbers worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from subgoal.demonstrations import Recording, Source, demonstrate
from subgoal.runtime.errors import InputError


def squares(count=6, step=0.5, **fields):
    """One trajectory of k² at times k·step, then one sample alone."""
    places = np.append(np.arange(count) ** 2.0, 99.0)[:, None]
    times = np.append(np.arange(count) * step, 0.0)
    return Recording(places, times, np.array([0, count, count + 1]), ("x",), units="m", **fields)


def column(array):
    return array[:, 0].tolist()


def test_central_differences_are_clipped_at_the_ends():
    demos = demonstrate(squares())
    assert column(demos.states) == [0, 1, 4, 9, 16, 25]
    assert column(demos.actions) == [2, 4, 8, 12, 16, 18]
    assert demos.times.tolist() == [0, 0.5, 1, 1.5, 2, 2.5]
    assert column(demos.final_states) == [25]
    assert demos.source.notes == {"trajectories of one sample dropped": 1}
    assert (demos.units, demos.time_unit, demos.trajectory_names) == ("m", "s", ("T0",))


def test_central_windows_reach_further_forwards_when_odd():
    # window 3: from i − 1 to i + 2
    assert column(demonstrate(squares(), window=3).actions) == [4, 6, 10, 14, 16, 18]
    assert column(demonstrate(squares(), window=4).actions) == [4, 6, 8, 12, 14, 16]


def test_central_uses_real_time_differences():
    recording = Recording([[0.0], [1.0], [5.0]], [0.0, 1.0, 3.0], np.array([0, 3]), ("x",))
    assert column(demonstrate(recording).actions) == [1, 5 / 3, 2]


def test_forward_differences_give_the_last_sample_no_pair():
    demos = demonstrate(squares(), velocity="forward", window=1)
    assert column(demos.states) == [0, 1, 4, 9, 16]
    assert column(demos.actions) == [2, 6, 10, 14, 18]
    assert column(demos.final_states) == [25]
    assert column(demonstrate(squares(), velocity="forward").actions) == [4, 8, 12, 16, 18]


def test_every_keeps_the_last_recorded_position_as_the_final_state():
    demos = demonstrate(squares(), every=4)
    assert column(demos.states) == [0, 16]
    assert column(demos.actions) == [4, 14]  # window 4
    assert column(demos.final_states) == [25]
    assert column(demonstrate(squares(), every=5).states) == [0, 25]
    assert column(demonstrate(squares(), every=2, velocity="forward").states) == [0, 4, 16]


def test_every_counts_from_the_start_of_each_trajectory():
    recording = Recording(np.arange(10.0)[:, None], np.r_[0:5, 0:5.0], np.array([0, 5, 10]), ("x",))
    demos = demonstrate(recording, every=2)
    assert column(demos.states) == [0, 2, 4, 5, 7, 9]
    assert demos.offset.tolist() == [0, 3, 6]


@settings(deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3, 3), st.integers(1, 3))
def test_savgol_gives_the_slope_of_a_parabola_exactly(a, b, c, half):
    times = np.arange(12) * 0.25
    recording = Recording((a + b * times + c * times**2)[:, None], times, np.array([0, 12]), ("x",))
    demos = demonstrate(recording, velocity="savgol", window=2 * half + 1)
    assert demos.actions[:, 0] == pytest.approx(b + 2 * c * times, abs=1e-9)


def test_savgol_default_window_is_five_and_wider_for_wider_steps():
    noisy = np.random.default_rng(0).normal(size=(30, 1))
    recording = Recording(noisy, np.arange(30.0), np.array([0, 30]), ("x",))
    slopes = [demonstrate(recording, velocity="savgol", window=w).actions for w in (5, 7)]
    assert np.array_equal(demonstrate(recording, velocity="savgol").actions, slopes[0])
    assert np.array_equal(demonstrate(recording, velocity="savgol", every=6).actions, slopes[1][::6])


def test_savgol_refuses_uneven_times_but_not_a_shorter_last_step():
    times = np.array([0, 1, 2, 3.5, 4.5, 5.5])
    recording = Recording(times[:, None], times, np.array([0, 6]), ("x",))
    with pytest.raises(InputError, match=r"sample 3 .*resample with rate="):
        demonstrate(recording, velocity="savgol")
    demos = demonstrate(recording, rate=1, velocity="savgol")
    assert column(demos.states) == pytest.approx([0, 1, 2, 3, 4, 5])
    assert column(demos.actions) == pytest.approx([1] * 6)
    assert column(demos.final_states) == [5.5]


def test_trajectories_shorter_than_the_savgol_window_are_dropped_and_counted():
    recording = Recording(np.arange(9.0)[:, None], np.r_[0:3, 0:6.0], np.array([0, 3, 9]), ("x",))
    demos = demonstrate(recording, velocity="savgol")
    assert demos.trajectory_names == ("T1",)
    assert demos.source.notes == {"trajectories too short for the window dropped": 1}
    with pytest.raises(InputError, match="no trajectory left"):
        demonstrate(recording, velocity="savgol", window=7)


def test_recorded_actions_are_kept_and_only_thinned_out():
    recording = squares(actions=np.arange(14.0).reshape(7, 2))
    demos = demonstrate(recording, every=2)
    assert demos.actions.tolist() == [[0, 1], [4, 5], [8, 9]]
    assert column(demos.final_states) == [25]
    finer = demonstrate(recording, rate=10)
    assert finer.actions.shape == (finer.n_observations, 2)


def test_gaps_are_cut_before_velocities_and_the_first_piece_is_truncated():
    times = np.array([0, 1, 2, 10, 11])
    recording = Recording(times[:, None] * 2.0, times, np.array([0, 5]), ("x",))
    demos = demonstrate(recording, max_gap=3)
    assert demos.trajectory_names == ("T0/0", "T0/1")
    assert demos.truncated.tolist() == [True, False]
    assert column(demos.final_states) == [4, 22]
    assert column(demos.actions) == [2] * 5
    assert demos.source.notes == {"gaps split": 1}


def test_thinning_comes_last():
    demos = demonstrate(squares(), thin=3.5)
    assert column(demos.states) == [0, 4, 9, 16, 25]
    assert column(demos.actions) == [2, 8, 12, 16, 18]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"velocity": "sideways"}, "velocity"),
        ({"every": 0}, "every"),
        ({"every": 1.5}, "every"),
        ({"window": 1}, "window"),
        ({"velocity": "savgol", "window": 4}, "odd"),
        ({"rate": -1}, "rate"),
        ({"rate": 1e9}, "fewer samples"),
        ({"max_gap": 0}, "max_gap"),
        ({"max_gap": 0.1}, "no trajectory left"),
        ({"thin": -1}, "radius"),
    ],
)
def test_bad_options_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        demonstrate(squares(), **options)


def test_velocities_beyond_all_floats_are_refused():
    recording = Recording([[1e308], [-1e308]], [0.0, 1.0], np.array([0, 2]), ("x",), source=Source("far"))
    with pytest.raises(InputError, match="actions at index"):
        demonstrate(recording)
