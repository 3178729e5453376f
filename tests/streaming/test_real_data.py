"""Recordings of hands and walkers, told sample by sample: the pairs and the subgoals of the batch."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import subgoal
from experiments.common import find_data
from subgoal.streaming import Stream
from tests.streaming.made import FIELDS

pytestmark = pytest.mark.filterwarnings("ignore:NOT CONVERGED")


def folder_of(name: str) -> Path:
    folder, reason = find_data(name, None)
    if folder is None:
        pytest.skip(str(reason))
    return folder


def told(recording: subgoal.Recording, **options: object) -> Stream:
    stream = Stream(names=recording.names, time_unit=recording.time_unit, **options)
    for a, b in zip(recording.offset[:-1], recording.offset[1:], strict=True):
        for time, place in zip(recording.times[a:b], recording.positions[a:b], strict=True):
            stream.add(time, place)
        stream.lift()
    return stream


def assert_pairs(stream: Stream, wanted: subgoal.Demonstrations) -> None:
    found = stream.demonstrations()
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), err_msg=name)


@pytest.mark.parametrize(("shape", "count"), [("Line", 1), ("Zshape", 3)])
def test_pen_strokes_have_the_subgoals_of_the_batch(shape: str, count: int) -> None:
    recording = subgoal.read_recording(folder_of("lasa_handwriting") / f"{shape}.mat")
    extent = float(np.ptp(recording.positions, axis=0).max())
    rate = 50 / float(recording.times[recording.offset[1] - 1] - recording.times[0])
    stream = told(recording, radius=0.03 * extent, rate=rate)
    assert_pairs(stream, subgoal.demonstrate(recording, rate=rate))
    wanted = subgoal.subgoals(subgoal.sample(stream.likelihood(), draws=400, warmup=400, thin=5))
    found = subgoal.subgoals(stream.posterior())
    assert found.n_subgoals == wanted.n_subgoals == count
    for item, other in zip(found[:count], wanted[:count], strict=True):
        assert np.linalg.norm(item.position - other.position) <= 0.03 * extent
        assert abs(item.share - other.share) < 0.02


def test_walkers_have_the_pairs_of_the_batch() -> None:
    recording = subgoal.read_recording(next(folder_of("edinburgh_forum").glob("tracks*.txt")))
    few = recording.offset[:41]
    some = subgoal.Recording(
        recording.positions[: few[-1]], recording.times[: few[-1]], few, recording.names, time_unit=recording.time_unit
    )
    assert_pairs(told(some, radius=30.0, rate=None, window=5), subgoal.demonstrate(some, window=5))
    assert_pairs(told(some, radius=30.0, rate=0.13), subgoal.demonstrate(some, rate=0.13))
