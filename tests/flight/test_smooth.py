"""Paths of minimum snap: through the waypoints, within limits, at rest where they should be."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from subgoal.flight import Waypoints, smooth
from subgoal.runtime.errors import InputError, MissingExtraError

pytest.importorskip("minsnap_trajectories")
CORNERS = np.array([[0.0, 0.5], [1.5, 0.5], [1.5, 2.0], [0.0, 2.0]])
SQUARE = Waypoints(CORNERS, dimensions=("y", "z"), units="m", cyclic=True)
LIMITS = {"speed": 1.2, "acceleration": 2.5}


def still(path, times) -> float:
    return float(np.abs(path.at(times, 4)[1:]).max())


@pytest.mark.parametrize(("speed", "acceleration"), [(1.2, 2.5), (3.0, 1.5)])
@pytest.mark.parametrize("smoothing", ["stop", "through"])
def test_the_path_goes_through_the_waypoints_and_keeps_to_the_limits(smoothing, speed, acceleration) -> None:
    path = smooth(SQUARE, smoothing=smoothing, speed=speed, acceleration=acceleration)
    np.testing.assert_allclose(path.at(path.arrivals)[0][:, 1:], CORNERS[[0, 1, 2, 3, 0]], atol=1e-9)
    _, fast, hard = np.linalg.norm(path.at(np.linspace(0, path.duration, 3000), 3), axis=2)
    assert fast.max() <= speed * 1.005
    assert hard.max() <= acceleration * 1.005
    assert max(fast.max() / speed, hard.max() / acceleration) > 0.99


def test_stopping_is_at_rest_in_straight_lines() -> None:
    path = smooth(SQUARE, **LIMITS)
    assert still(path, path.arrivals) < 1e-6
    assert path.overshoot < 1e-9


def test_going_through_rests_at_both_ends_only() -> None:
    path = smooth(SQUARE, smoothing="through", **LIMITS)
    assert still(path, [0.0, path.duration - 1e-9]) < 1e-6
    assert np.linalg.norm(path.at(path.arrivals[1:-1], 2)[1], axis=1).min() > 0.1


@pytest.mark.parametrize("bound", [0.2, 0.05, 0.02])
def test_overshoot_is_bounded(bound) -> None:
    path = smooth(SQUARE, smoothing="through", overshoot=bound, **LIMITS)
    y, z = path.at(np.linspace(0, path.duration, 3000))[0][:, 1:].T
    inside = np.minimum.reduce([np.abs(y), np.abs(y - 1.5), np.abs(z - 0.5), np.abs(z - 2.0)])
    outside = np.maximum.reduce([-y, y - 1.5, 0.5 - z, z - 2.0])
    assert max(inside.max(), outside.max()) <= bound * 1.02
    assert path.overshoot <= bound


def test_dwells_are_rests() -> None:
    made = Waypoints(CORNERS, dimensions=("y", "z"), units="m", dwell=[0.0, 2.0, 0.0, 1.0])
    path = smooth(made, smoothing="through", **LIMITS)
    waits = np.linspace(path.arrivals[1] + 1e-9, path.arrivals[1] + 2.0 - 1e-9, 20)
    np.testing.assert_allclose(path.at(waits)[0][:, 1:], np.tile(CORNERS[1], (20, 1)), atol=1e-9)
    assert still(path, waits) < 1e-6
    assert path.duration == pytest.approx(path.arrivals[-1] + 1.0)


def test_derivatives_can_be_given() -> None:
    wanted = {1: {"velocity": [0.0, 0.3, 0.3], "acceleration": [0.0, 0.1, -0.2]}}
    made = Waypoints(CORNERS, dimensions=("y", "z"), units="m")
    path = smooth(made, smoothing="through", constraints=wanted, overshoot=1.0, **LIMITS)
    motion = path.at([path.arrivals[1]], 3)[:, 0]
    np.testing.assert_allclose(motion[1:], [[0, 0.3, 0.3], [0, 0.1, -0.2]], atol=1e-9)
    np.testing.assert_allclose(motion[0, 1:], CORNERS[1], atol=1e-9)


def test_long_ways_are_paths_too() -> None:
    places = np.cumsum(np.random.default_rng(0).uniform(0.3, 1, (40, 2)), axis=0)
    path = smooth(Waypoints(places, units="m"), smoothing="through")
    np.testing.assert_allclose(path.at(path.arrivals)[0][:, :2], places, atol=1e-6)


def test_a_cyclic_way_begins_and_ends_nearest_to_the_start() -> None:
    made = Waypoints(CORNERS, dimensions=("y", "z"), units="m", cyclic=True, start=np.array([1.4, 2.1]))
    assert smooth(made, rounds=2).route.waypoint.tolist() == [2, 3, 0, 1, 2, 3, 0, 1, 2]


def test_one_pass_begins_at_the_start_unless_it_is_the_first_waypoint() -> None:
    one = {"dimensions": ("y", "z"), "units": "m"}
    assert smooth(Waypoints(CORNERS, start=np.array([0.0, 2.0]), **one)).route.waypoint.tolist() == [-1, 0, 1, 2, 3]
    assert smooth(Waypoints(CORNERS, start=np.array([0.05, 0.5]), **one)).route.waypoint.tolist() == [0, 1, 2, 3]


def test_units_and_planes_are_placed_in_the_world() -> None:
    made = Waypoints(CORNERS * 1000, dimensions=("a", "b"), units="mm")
    np.testing.assert_allclose(smooth(made, height=2.0).route.places[1], [1.5, 0.5, 2.0])
    np.testing.assert_allclose(smooth(made, plane="xz").route.places[1], [1.5, 0.0, 0.5])
    np.testing.assert_allclose(smooth(made, plane="zy").route.places[1], [0.0, 0.5, 1.5])
    np.testing.assert_allclose(smooth(made, plane="yz", scale=0.01).route.places[1], [0.0, 15.0, 5.0])


def test_an_angle_in_a_horizontal_plane_is_a_heading() -> None:
    period = (np.inf, np.inf, 2 * np.pi)
    places = [[0.0, 0, 0], [1, 0, 2.0], [1, 1, -2.0]]
    path = smooth(Waypoints(places, dimensions=("x", "y", "yaw"), units="m", period=period))
    np.testing.assert_allclose(path.headings(path.arrivals), [0, 2.0, 2 * np.pi - 2.0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"speed": 0.0}, "speed"), ({"speed": np.nan}, "speed"), ({"speed": 100.0}, "100.0, wanted at most 20 m/s"),
        ({"acceleration": 90.0}, "acceleration: found 90.0, wanted at most"), ({"smoothing": "round"}, "smoothing"),
        ({"overshoot": 0.0}, "overshoot"), ({"plane": "ab"}, "plane"), ({"plane": "yy"}, "plane"),
        ({"height": np.nan, "plane": "xy"}, "height"), ({"rounds": 0}, "rounds"), ({"rounds": 2}, "not cyclic"),
        ({"vehicle": "goose"}, "vehicle: found 'goose', wanted one of 'hummingbird'"), ({"scale": -1.0}, "scale"),
        ({"constraints": {0: {"velocity": [0, 0, 0]}}}, "neither first nor last"),
        ({"constraints": {1: {"jerk": [0, 0, 0]}}}, "velocity or acceleration"),
        ({"constraints": {1: {"velocity": [0, 0]}}}, r"velocity: found shape \(2,\)"),
        ({"constraints": {1: {"velocity": [0, 3.0, 0]}}}, "velocity at constraints: found 3, wanted at most 1"),
        ({"constraints": [1]}, "constraints: found list"),
        ({"most_seconds": 1.0}, "most_seconds: found a flight of"),
        ({"most_seconds": np.nan}, "most_seconds"),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(options, message) -> None:
    with pytest.raises(InputError, match=message):
        smooth(Waypoints(CORNERS, dimensions=("y", "z"), units="m"), **options)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"positions": CORNERS, "units": "px"}, "units: found 'px'"),
        ({"positions": [[0.0], [1.0]]}, r"found 1 positions \(x0\), wanted two or three"),
        ({"positions": CORNERS, "period": (360.0, np.inf)}, "period 360"),
    ],
)
def test_what_is_no_position_is_refused(fields, message) -> None:
    with pytest.raises(InputError, match=message):
        smooth(Waypoints(**fields))


def test_three_positions_have_no_plane() -> None:
    with pytest.raises(InputError, match="plane: found 'yz', wanted None"):
        smooth(Waypoints([[0.0, 0, 1], [1, 1, 1]]), plane="yz")


@pytest.mark.parametrize("package", ["rotorpy", "minsnap_trajectories"])
def test_a_missing_extra_is_said_by_name(package, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"{package} is not installed.*subgoal\[flight\]"):
        smooth(SQUARE)
