"""``read`` and ``look``: options that go to the reader, to the preparation, or nowhere."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations import Demonstrations, Recording, read
from subgoal.demonstrations.read import look
from subgoal.runtime.errors import InputError
from tests.demonstrations.valid_files import EDINBURGH, LABYRINTH, deeplabcut_frame


@pytest.fixture
def edinburgh(tmp_path):
    (tmp_path / "e.txt").write_text(EDINBURGH)
    return tmp_path / "e.txt"


def test_start_within_keeps_the_trajectories_that_start_there(edinburgh):
    demos = read(edinburgh, start_within=((480, np.inf), (-np.inf, 140)))
    assert demos.trajectory_names == ("R1",)
    assert demos.source.notes["trajectories starting elsewhere dropped"] == 1
    for wrong in (3, [1, 2], [(1, 2, 3), (1, 2, 3)], [], [(0, "far"), (0, 1)], [(0, 1)]):
        with pytest.raises(InputError, match=r"start_within|lower|upper"):
            read(edinburgh, start_within=wrong)


def test_the_rate_goes_to_readers_without_a_clock_and_to_resampling(edinburgh):
    demos = read(edinburgh, rate=4)
    assert demos.time_unit == "s"
    # R2 has frames 367 and 369: a quarter of a second apart after resampling
    assert demos.times[3:].tolist() == [367 / 4, 368 / 4, 369 / 4]
    assert demos.states[3:].tolist() == [[1, 2], [2, 3], [3, 4]]
    assert demos.actions[3:].tolist() == [[4, 4]] * 3


def test_the_longest_gap_goes_to_the_readers_of_trackers(tmp_path):
    deeplabcut_frame().to_csv(tmp_path / "d.csv")
    assert read(tmp_path / "d.csv", bodypart="nose").n_trajectories == 1
    assert read(tmp_path / "d.csv", bodypart="nose", max_gap=1.5).n_trajectories == 2


@pytest.mark.parametrize(
    "options",
    [{"rate": 3}, {"every": 2}, {"velocity": "savgol"}, {"window": 3}, {"max_gap": 1}, {"start_within": [(0, 1)]}],
)
def test_options_that_ready_pairs_cannot_use_are_refused(tmp_path, options):
    (tmp_path / "l.csv").write_text(LABYRINTH)
    with pytest.raises(InputError, match=f"found {next(iter(options))}, wanted none of them"):
        read(tmp_path / "l.csv", **options)


def test_look_gives_what_the_file_holds(tmp_path, edinburgh):
    (tmp_path / "l.csv").write_text(LABYRINTH)
    assert isinstance(look(tmp_path / "l.csv", session="A"), Demonstrations)
    recording = look(edinburgh, rate=2, max_gap=None)
    assert isinstance(recording, Recording)
    assert recording.times[0] == 47.5
    with pytest.raises(InputError, match="found every"):
        look(edinburgh, every=2)
