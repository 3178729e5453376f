"""The summary of a recording: numbers by hand, warnings for what they are for."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations import Demonstrations, Recording, Source, demonstrate, summarise


def walk(x, times, offset=None, **fields):
    x = np.asarray(x, float)
    given = {"units": "m", "source": Source("walk")} | fields
    places = np.stack([x, 2 * x], axis=1) if x.ndim == 1 else x
    return Recording(places, times, np.array(offset or [0, len(x)]), ("x", "y"), **given)


def test_numbers():
    recording = walk([0, 1, 3, 3, 10, 11.0], [0, 1, 2, 3, 0, 0.5], [0, 4, 6])
    summary = summarise(recording)
    assert (summary.trajectories, summary.samples, summary.dimension) == (2, 6, 2)
    assert summary.lengths == (2, 3, 4)
    assert summary.durations == (0.5, 1.75, 3)
    assert summary.rate == 1
    assert summary.longest_gap == 1
    assert summary.lower == (0, 0)
    assert summary.upper == (11, 22)
    assert summary.extent == 22
    assert summary.standing == 0.25
    # steps of 1, 2, 0 m over 1 s and of 1 m over 0.5 s, times the square root of 5
    assert summary.speeds[0] == 0
    assert summary.speeds[2] == pytest.approx(1.5 * 5**0.5)
    assert summary.speeds[5] == pytest.approx(2 * 5**0.5)


def warnings_of(recording):
    return " | ".join(summarise(recording).warnings)


def smooth(count=200):
    return np.cumsum(np.random.default_rng(0).uniform(0.5, 1.5, count)), np.arange(count) / 10


def test_a_good_recording_has_no_warning():
    assert warnings_of(walk(*smooth())) == ""


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda x, t: walk(x, np.where(t > 10, t + 7, t)), "clock jumps: 1 steps take over 5 times the usual"),
        (lambda x, t: walk(x, t + (np.arange(200) % 2) * 0.05), "sampling is uneven"),
        (lambda x, t: walk(x, t, units=""), "unit of the positions is unknown"),
        (lambda x, t: walk(x, t, time_unit="sample"), "no clock"),
        (lambda x, t: walk(np.round(x), t), "positions look quantised: x comes in steps of 1 m"),
        (lambda x, t: walk(np.repeat(x, 2)[:200], t), "50 % of the steps stand still"),
        (lambda x, t: walk(np.where(np.arange(200) == 50, 900, x), t), "a tracker that jumps"),
        (lambda x, t: walk(np.stack([x, 0 * x], axis=1), t), "y never changes"),
        (lambda x, t: walk(x, t, [0, 3, 200]), "1 of 2 trajectories have fewer than 5 samples"),
    ],
)
def test_warnings(change, told):
    assert told in warnings_of(change(*smooth()))


def test_demonstrations_discrete_worlds_and_pairs_without_times_are_summarised():
    summary = summarise(demonstrate(walk(*smooth()), every=2))
    assert summary.rate == pytest.approx(5)
    summary = summarise(Demonstrations([3, 4, 9], [0, 1, 0], np.array([0, 3]), times=[0.0, 1, 2]))
    assert (summary.dimension, summary.lower, summary.upper, summary.speeds) == (0, (3,), (9,), None)
    summary = summarise(Demonstrations.from_arrays(np.eye(3), np.eye(3)))
    assert (summary.rate, summary.durations, summary.speeds) == (None, None, None)
    assert len(summary.lines()) > 4


def test_thinned_demonstrations_are_not_said_to_have_gaps():
    x, times = smooth()
    resting = np.where(np.arange(200) < 100, x, x[99] + np.maximum(np.arange(200) - 150, 0))
    assert summarise(demonstrate(walk(resting, times), thin=1.5)).gaps == 1
    assert "clock jumps" not in " ".join(summarise(demonstrate(walk(resting, times), thin=1.5)).warnings)


def test_lines_tell_everything_once():
    recording = walk(
        [0, 1, 3, 3, 10, 11.0], [0, 1, 2, 3, 0, 0.5], [0, 4, 6], source=Source("w", notes={"rows dropped": 7})
    )
    lines = summarise(recording).lines()
    assert lines[0] == "w: 2 trajectories, 6 samples"
    assert "rows dropped: 7" in lines
    assert any(line.startswith("y: 0 to 22 m") for line in lines)
    assert any(line.startswith("warning: ") for line in lines)


def test_states_with_coordinates_are_summed_up_by_where_they_lie() -> None:
    places = np.array([[0.0, 5.0], [2.0, 1.0], [9.0, 9.0]])
    told = summarise(Demonstrations(np.array([0, 1]), np.array([0, 0]), np.array([0, 2]), coordinates=places))
    assert (told.dimension, told.names, told.lower, told.upper) == (2, ("x0", "x1"), (0, 1), (2, 5))
