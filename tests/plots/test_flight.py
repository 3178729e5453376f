"""Pictures of a flight: what they show, and the moving ones as files."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from PIL import Image

from subgoal.demonstrations.records import Demonstrations
from subgoal.flight import Flight, FlightStatus, Waypoints, fly, tracking
from subgoal.plots import animate_flight, plot_flight
from subgoal.plots import flight_animation as moving
from subgoal.plots.flight import FLOWN, vehicle_lines
from subgoal.plots.style import colour
from subgoal.runtime.errors import InputError
from tests.flight.made import loop

pytest.importorskip("rotorpy")
HOP = Waypoints(np.array([[0.0, 0.5], [0.8, 0.5], [0.8, 1.0]]), labels=[2, 1, 3], dimensions=("y", "z"), units="m")
ROOM = Waypoints(np.array([[0.0, 0, 1], [0.5, 0, 1], [0.5, 0.5, 1.5]]), dimensions=("x", "y", "z"), units="m")


def beside(made: Waypoints, flight: Flight) -> Demonstrations:
    states = np.column_stack([flight.shown, *([flight.angles] if made.angle is not None else [])])[::20]
    return Demonstrations.from_arrays(
        states + 0.01, np.ones_like(states), [0, len(states)], names=made.dimensions, units="m"
    )


@pytest.fixture(scope="module", params=[HOP, loop(), ROOM], ids=["hop", "loop", "room"])
def all_of_it(request) -> tuple[Flight, Waypoints, Demonstrations]:
    flight = fly(request.param)
    return flight, request.param, beside(request.param, flight)


def test_the_title_says_how_near_the_flight_came(all_of_it) -> None:
    flight, made, demos = all_of_it
    figure = plot_flight(flight, made, demos)
    text = "\n".join(each.get_text() for each in figure.texts)
    assert f"Flown in {flight.duration:.1f} s: {tracking(flight, demos).told}" in text.replace("\n", " ")
    assert f"{len(flight.misses)} of {len(flight.misses)} places reached" in text


def test_waypoints_have_the_numbers_and_colours_of_their_subgoals(all_of_it) -> None:
    flight, made, demos = all_of_it
    axes = plot_flight(flight, made, demos).axes[0]
    discs = {text.get_text(): text for text in axes.texts}
    assert set(discs) == {str(label) for label in made.labels}
    for k, label in enumerate(made.labels):
        disc = discs[str(label)]
        np.testing.assert_allclose(disc.get_position(), made.positions[k, :2])
        assert to_hex(disc.get_bbox_patch().get_facecolor()).upper() == colour(int(label) - 1).upper()


def test_the_path_is_the_flown_one(all_of_it) -> None:
    flight, made, demos = all_of_it
    line, start = plot_flight(flight, made, demos).axes[0].lines
    np.testing.assert_array_equal(start.get_xydata(), flight.shown[:1, :2])
    np.testing.assert_array_equal(line.get_xydata(), flight.shown[:, :2])
    assert line.get_color() == FLOWN


def test_the_second_coordinate_may_point_down(all_of_it) -> None:
    flight, made, demos = all_of_it
    for y_down in (False, True):
        panels = plot_flight(flight, made, demos, y_down=y_down).axes
        assert panels[0].yaxis_inverted() == y_down
        assert not any(axes.yaxis_inverted() for axes in panels[1:])


def test_a_subgoal_that_comes_twice_has_one_disc() -> None:
    made = Waypoints(HOP.positions[[0, 1, 0]], labels=[1, 2, 1], dimensions=("y", "z"), units="m")
    flight = fly(made)
    axes = plot_flight(flight, made, beside(made, flight)).axes[0]
    assert sorted(text.get_text() for text in axes.texts) == ["1", "2"]


def test_a_flight_that_failed_says_so() -> None:
    flight = replace(fly(HOP), status=FlightStatus.DID_NOT_ARRIVE)
    figure = plot_flight(flight, HOP, beside(HOP, flight))
    assert flight.told in [text.get_text() for text in figure.texts]
    assert flight.told.startswith(FlightStatus.DID_NOT_ARRIVE.value)


def test_masts_point_where_the_vehicle_thrusts() -> None:
    flight = fly(loop())
    rows = [0, int(np.argmax(flight.positions[:, 2])), len(flight.times) // 3]
    lines = vehicle_lines(flight, rows, 0.1)
    for k, row in enumerate(rows):
        bar, mast = lines[2 * k : 2 * k + 2]
        np.testing.assert_allclose(bar.mean(axis=0), flight.shown[row], atol=1e-9)
        np.testing.assert_allclose(
            mast[1] - mast[0], 0.08 * flight.placement.direction(flight.angles[[row]])[0, 1:], atol=1e-9
        )
        assert abs((bar[1] - bar[0]) @ (mast[1] - mast[0])) < 1e-12


def test_a_moving_picture_is_small_and_moves(all_of_it, tmp_path) -> None:
    path = animate_flight(*all_of_it, tmp_path / "new" / "flight.gif")
    with Image.open(path) as picture:
        assert 2 <= picture.n_frames <= moving.MOST_FRAMES
        frames = [np.asarray((picture.seek(k), picture.convert("RGB"))[1]) for k in (0, picture.n_frames - 1)]
    red, _, blue = np.moveaxis(np.array(frames, int), -1, 0)
    begun, flown = ((red - blue) > 100).sum(axis=(1, 2))
    assert flown > begun + 100
    assert path.stat().st_size < 3e6
    assert [each.name for each in path.parent.iterdir()] == ["flight.gif"]


def test_a_page_holds_the_moving_picture(tmp_path) -> None:
    flight = fly(HOP)
    page = animate_flight(flight, HOP, beside(HOP, flight), tmp_path / "flight.html").read_text()
    assert 'src="data:image/gif;base64,R0lGOD' in page


def test_a_moving_picture_may_have_its_second_coordinate_point_down() -> None:
    flight = fly(HOP)
    ways = [np.asarray(list(moving._frames(flight, HOP, beside(HOP, flight), y_down))[-1]) for y_down in (False, True)]
    red = [np.flatnonzero((way[..., 0].astype(int) - way[..., 2] > 100).any(axis=1)) for way in ways]
    assert red[0].mean() > red[1].mean() + 20


def test_long_flights_are_told_to_run_faster() -> None:
    flight = fly(HOP)
    assert moving._pace(flight, 10).endswith(f"; {flight.duration * 2:.1f} times as fast as flown")
    assert "fast" not in moving._pace(flight, int(flight.duration * moving.RATE))


def test_films_that_cannot_be_made_are_refused(tmp_path, monkeypatch) -> None:
    flight = fly(HOP)
    monkeypatch.setattr(moving.shutil, "which", lambda _: None)
    for name, message in (("flight.mp4", "no program ffmpeg"), ("flight.avi", r"ends in \.gif, \.html or \.mp4")):
        with pytest.raises(InputError, match=message):
            animate_flight(flight, HOP, beside(HOP, flight), tmp_path / name)
    assert list(tmp_path.iterdir()) == []
