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
from subgoal.runtime.errors import InputError, StoppedError
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
    found = json.loads(json.dumps(flown(posterior, 120.0, lambda: True), allow_nan=False))
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


def test_a_flight_tells_where_it_goes_in_order_and_when_it_is_there(posterior: Posterior) -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    found = flown(posterior, 120.0, lambda: True)
    wanted = waypoints(posterior).positions
    assert [(stop["y"], stop["z"]) for stop in found["stops"]] == [tuple(place) for place in wanted.tolist()]
    for stop in found["stops"]:
        assert np.hypot(found["y"][stop["row"]] - stop["y"], found["z"][stop["row"]] - stop["z"]) < 0.1


def test_a_path_of_pixels_is_flown_as_large_as_the_plane_and_that_is_said() -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    pixels = np.array(square()) * [1, 300, 300]
    recording = Recording(
        pixels[:, 1:], pixels[:, 0], np.array([0, len(pixels)]), ("x", "y"), trajectory_names=("stroke 1",)
    )
    learned = learn(demonstrations_of(recording), Tuning(), SETTLED).posterior
    assert learned is not None
    found = flown(learned, 120.0, lambda: True)
    assert found["times"][-1] < 30
    assert max(found["y"]) - min(found["y"]) == pytest.approx(600, abs=60)
    assert "unknown" in found["summary"]


def test_a_flight_that_takes_too_long_is_refused_in_words_of_the_page(posterior: Posterior) -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    with pytest.raises(InputError, match="Try: a shorter one") as told:
        flown(posterior, 2.0, lambda: True)
    assert "--" not in str(told.value)


def test_a_flight_that_nobody_waits_for_ends(posterior: Posterior) -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    waits = iter([True, True, False])
    with pytest.raises(StoppedError):
        flown(posterior, 120.0, lambda: next(waits))


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
