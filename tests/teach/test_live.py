"""Learning while the pen is down."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.runtime.errors import InputError
from subgoal.teach.drawing import Drawing
from subgoal.teach.learning import Tuning, demonstrations_of
from subgoal.teach.limits import Limits
from subgoal.teach.live import Live
from tests.teach.made import CORNERS, square

TUNING = Tuning()


def test_points_are_learned_from_as_they_come_each_once() -> None:
    drawing, live, points = Drawing(Limits()), Live(), square()
    drawing.begin()
    for k in range(0, len(points), 37):
        drawing.add(tuple(points[k : k + 37]))
        answer = live.answer(drawing.sheet(), TUNING)
    drawing.lift()
    answer = live.answer(drawing.sheet(), TUNING)
    assert answer.pairs == demonstrations_of(drawing.sheet().recording()).n_observations
    assert answer.found.n_subgoals == 4
    places = np.array([goal.position for goal in answer.found])[:4]
    assert np.linalg.norm(places[:, None] - CORNERS[None], axis=2).min(axis=1).max() < 0.15
    assert answer.posterior is None


def test_segments_know_their_stroke_where_others_have_no_or_one_point() -> None:
    drawing, live, points = Drawing(Limits()), Live(), square()
    drawing.begin()
    drawing.lift()
    drawing.begin()
    drawing.add(((0.0, 0.0, 1.0),))
    drawing.lift()
    for part in (points[:120], points[120:240]):
        drawing.begin()
        drawing.add(tuple(part))
        drawing.lift()
    answer = live.answer(drawing.sheet(), TUNING)
    assert answer.strokes == (2, 3)
    batch = demonstrations_of(drawing.sheet().recording())
    assert batch.trajectory_names == ("stroke 3", "stroke 4")


def test_a_drawing_that_lost_a_stroke_is_learned_anew() -> None:
    drawing, live, points = Drawing(Limits()), Live(), square()
    for part in (points[:120], points[120:360]):
        drawing.begin()
        drawing.add(tuple(part))
        drawing.lift()
    before = live.answer(drawing.sheet(), TUNING).pairs
    drawing.undo()
    assert live.answer(drawing.sheet(), TUNING).pairs < before / 2


def test_other_parameters_are_used_from_then_on() -> None:
    drawing, live = Drawing(Limits()), Live()
    drawing.begin()
    drawing.add(tuple(square()))
    counts = [live.answer(drawing.sheet(), tuning).found.n_subgoals for tuning in (TUNING, Tuning(0.1, 0.01))]
    assert counts[0] != counts[1]


def test_nothing_is_said_before_anything_moved_and_then_it_goes_on() -> None:
    drawing, live = Drawing(Limits()), Live()
    drawing.begin()
    drawing.add(tuple(square()[:2]))
    with pytest.raises(InputError):
        live.answer(drawing.sheet(), TUNING)
    drawing.add(tuple(square()[2:200]))
    assert live.answer(drawing.sheet(), TUNING).pairs > 60


def test_a_rest_that_a_stream_does_not_take_is_said_and_the_next_drawing_is_learned() -> None:
    drawing, live, points = Drawing(Limits()), Live(), square()
    drawing.begin()
    drawing.add((*points[:100], (100.0, 0.0, 2.0)))
    with pytest.raises(InputError):
        live.answer(drawing.sheet(), TUNING)
    drawing.clear()
    drawing.begin()
    drawing.add(tuple(points))
    assert live.answer(drawing.sheet(), TUNING).found.n_subgoals == 4
