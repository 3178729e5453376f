"""Strokes, what may be done to them, and the recording they make."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.records import Recording
from subgoal.teach.drawing import Drawing
from subgoal.teach.limits import Limits
from subgoal.teach.messages import RefusedError

A, B, C = (0.0, 1.0, 1.0), (0.1, 1.1, 1.0), (0.2, 1.2, 1.0)


def drawn(*strokes: tuple[tuple[float, float, float], ...], limits: Limits | None = None) -> Drawing:
    drawing = Drawing(limits or Limits())
    for stroke in strokes:
        drawing.begin()
        drawing.add(stroke)
        drawing.lift()
    return drawing


def refused(action, *arguments) -> str:
    with pytest.raises(RefusedError) as problem:
        action(*arguments)
    return problem.value.code


def test_each_stroke_is_a_trajectory() -> None:
    recording = drawn((A, B), (C,)).sheet().recording()
    assert recording.offset.tolist() == [0, 2, 3]
    assert recording.trajectory_names == ("stroke 1", "stroke 2")
    assert recording.positions.tolist() == [[1.0, 1.0], [1.1, 1.0], [1.2, 1.0]]
    assert recording.times.tolist() == [0.0, 0.1, 0.2]
    assert (recording.names, recording.units) == (("y", "z"), "m")


def test_a_stroke_without_points_keeps_the_number_of_the_next_one() -> None:
    drawing = Drawing(Limits())
    drawing.begin()
    drawing.lift()
    drawing.begin()
    drawing.add((A, B))
    assert drawing.sheet().recording().trajectory_names == ("stroke 2",)


def test_a_sheet_stays_as_it_was() -> None:
    drawing = drawn((A,))
    sheet = drawing.sheet()
    drawing.begin()
    drawing.add((B, C))
    assert sheet.strokes == ((A,),)


def test_pen_up_and_down_take_turns() -> None:
    drawing = Drawing(Limits())
    assert refused(drawing.add, (A,)) == "out-of-order"
    assert refused(drawing.lift) == "out-of-order"
    drawing.begin()
    assert refused(drawing.begin) == "out-of-order"


@pytest.mark.parametrize("points", [(B, A), (A, A), (A, B, B)])
def test_times_increase_within_a_message_or_nothing_is_added(points) -> None:
    drawing = Drawing(Limits())
    drawing.begin()
    assert refused(drawing.add, points) == "out-of-order"
    assert drawing.n_points == 0


def test_times_increase_from_message_to_message() -> None:
    drawing = Drawing(Limits())
    drawing.begin()
    drawing.add((B,))
    assert refused(drawing.add, (A,)) == "out-of-order"
    assert drawing.n_points == 1


def test_a_drawing_is_no_larger_than_it_may_be() -> None:
    drawing = drawn((A,), limits=Limits(points=2, strokes=2))
    drawing.begin()
    assert refused(drawing.add, (B, C)) == "too-large"
    drawing.add((B,))
    drawing.lift()
    assert refused(drawing.begin) == "too-large"
    assert drawing.n_points == 2


def test_undo_takes_the_last_stroke() -> None:
    drawing = drawn((A,), (B, C))
    drawing.undo()
    assert drawing.sheet().strokes == ((A,),)
    drawing.undo()
    assert refused(drawing.undo) == "cannot"


def test_clear_leaves_an_empty_sheet_of_metres() -> None:
    drawing = drawn((A, B))
    drawing.replace(Recording(np.zeros((1, 2)), np.zeros(1), np.array([0, 1]), ("u", "v"), "mm"))
    drawing.clear()
    assert (drawing.sheet().strokes, drawing.sheet().names, drawing.sheet().units) == ((), ("y", "z"), "m")


def test_only_more_points_keep_the_lineage() -> None:
    drawing = drawn((A, B))
    before = drawing.sheet()
    drawing.begin()
    drawing.add((C,))
    drawing.lift()
    assert drawing.sheet().lineage == before.lineage
    assert drawing.revision > before.revision
    drawing.undo()
    assert drawing.sheet().lineage > before.lineage


def test_a_recording_takes_the_place_of_the_drawing_and_comes_out_as_it_was() -> None:
    given = Recording(
        np.array([[0.0, 1], [2, 3], [4, 5]]), np.array([0.0, 1, 0]), np.array([0, 2, 3]), ("u", "v"), "mm",
        time_unit="frame",
    )  # fmt: skip
    drawing = drawn((A, B))
    drawing.replace(given)
    found = drawing.sheet().recording()
    np.testing.assert_array_equal(found.positions, given.positions)
    np.testing.assert_array_equal(found.times, given.times)
    assert (found.offset.tolist(), found.names, found.units, found.time_unit) == ([0, 2, 3], ("u", "v"), "mm", "frame")
