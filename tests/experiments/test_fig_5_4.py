"""The measures that figure 5-4 reports."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.common import find_data
from experiments.fig_5_4 import FILE, PAIRS, selection, settling_sweep
from subgoal.demonstrations.readers import read_recording
from subgoal.demonstrations.recordings import starting_in


@pytest.mark.parametrize(
    ("trace", "settled"),
    [
        ([3, 3, 3], 0),
        ([1, 2, 2, 2], 2),
        ([5, 4, 5, 4, 4], 4),
        ([9, 8, 7, 7, 7, 8, 8], 3),
    ],
)
def test_settling_sweep_is_the_last_change_of_the_running_mode(trace: list[int], settled: int) -> None:
    assert settling_sweep(np.array(trace)) == settled


def test_selection_takes_whole_tracks_of_the_corner_until_there_are_enough() -> None:
    folder, reason = find_data("edinburgh_forum", None)
    if folder is None:
        pytest.skip(str(reason))
    recording = starting_in(read_recording(folder / FILE), (480, -np.inf), (np.inf, 140))
    assert recording.n_trajectories == 157
    demos = selection(recording, 0)
    lengths = np.diff(demos.offset)
    assert demos.n_observations >= PAIRS
    assert demos.n_observations - lengths.max() < PAIRS
    starts = demos.states[demos.offset[:-1]]
    assert (starts[:, 0] > 480).all()
    assert (starts[:, 1] < 140).all()
    assert selection(recording, 1).trajectory_names != demos.trajectory_names
