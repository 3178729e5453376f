"""What the page is told of an answer, a drawing and a flight."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from subgoal.demonstrations.records import Recording
from subgoal.flight import read_waypoints, waypoints
from subgoal.posterior.posterior import Posterior
from subgoal.teach.drawing import Drawing
from subgoal.teach.flying import flown, waypoint_text
from subgoal.teach.learning import SETTLED, Answer, Tuning, demonstrations_of, learn
from subgoal.teach.limits import Limits
from subgoal.teach.picture import picture, view
from tests.teach.made import served, square

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")


@pytest.fixture(scope="module")
def drawn() -> Answer:
    drawing = Drawing(Limits())
    drawing.begin()
    drawing.add(tuple(square()))
    drawing.lift()
    return learn(demonstrations_of(drawing.sheet().recording()), Tuning(), SETTLED)


@pytest.fixture
def posterior(drawn: Answer) -> Posterior:
    assert drawn.posterior is not None
    return drawn.posterior


def test_an_answer_in_plain_numbers(drawn: Answer) -> None:
    found = json.loads(json.dumps(picture(drawn, 7), allow_nan=False))
    assert (found["number"], found["n"], found["stage"]) == (7, 4, "settled")
    for goal, told in zip(drawn.found, found["subgoals"], strict=True):
        assert (told["y"], told["z"], told["share"], told["inclusion"]) == (*goal.position, goal.share, goal.inclusion)
        assert told["radius"] >= goal.radius
    assert sum(found["counts"].values()) == pytest.approx(1, abs=0.05)
    cuts = found["segments"]
    assert [cut["begin"] for cut in cuts] == sorted(cut["begin"] for cut in cuts)
    assert {cut["subgoal"] for cut in cuts} <= {-1, *range(len(found["subgoals"]))}


def sheet_of(places: list[list[float]], units: str):
    drawing = Drawing(Limits())
    recording = Recording(np.array(places), np.arange(len(places)), np.array([0, len(places)]), ("u", "v"), units)
    drawing.replace(recording)
    return drawing.sheet()


def test_what_lies_in_the_empty_plane_is_shown_in_it() -> None:
    assert view(sheet_of([[-2, 0], [2, 3]], "m")) == [-2, 2, 0, 3]
    assert view(Drawing(Limits()).sheet()) == [-2, 2, 0, 3]


@pytest.mark.parametrize("places", [[[0.0, 0], [100, 10]], [[5.0, 900], [6, 1000]], [[7.0, 7], [7, 7.0]], [[0.0, 0]]])
def test_what_does_not_is_shown_whole_and_undistorted(places: list[list[float]]) -> None:
    left, right, low, high = view(sheet_of(places, "mm"))
    assert (right - left) / (high - low) == pytest.approx(4 / 3)
    for y, z in places:
        assert left < y < right
        assert low < z < high


def test_a_flight_goes_round_the_square(posterior: Posterior) -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    found = json.loads(json.dumps(flown(posterior), allow_nan=False))
    rows = {len(found[name]) for name in ("times", "y", "z", "tilt", "thrust")}
    assert rows == {len(found["times"])}
    assert max(found["y"]) - min(found["y"]) == pytest.approx(2, abs=0.2)
    assert max(found["z"]) - min(found["z"]) == pytest.approx(2, abs=0.2)
    assert found["thrust"][-1] == pytest.approx(1, abs=0.1)
    assert 0 < found["rmse"] < 0.2
    right = [k for k in range(len(found["y"]) - 1) if found["y"][k + 1] - found["y"][k] > 0.02]
    speeding = right[: len(right) // 6]
    assert np.mean([found["tilt"][k] for k in speeding]) < 0
    assert "from your path" in found["summary"]


def test_waypoints_as_text(posterior: Posterior, tmp_path: Path) -> None:
    for kind in ("csv", "json"):
        path = tmp_path / f"w.{kind}"
        path.write_text(waypoint_text(posterior, kind))
        np.testing.assert_array_equal(read_waypoints(path).positions, waypoints(posterior).positions)


def test_without_the_extra_the_page_says_what_is_missing_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *more: None if name == "rotorpy" else find(name, *more)
    )
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square())
        page.do("fly")
        error = page.hear("error")
        assert error["code"] == "cannot"
        assert "subgoal[flight]" in error["text"]
        page.do("export", format="csv")
        assert page.hear("file")["name"] == "waypoints.csv"
