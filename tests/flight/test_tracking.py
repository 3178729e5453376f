"""Errors without time, worked out by hand, and a flight on disk."""

from __future__ import annotations

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from subgoal.demonstrations.records import Demonstrations
from subgoal.flight import Flight, Waypoints, fly, tracking, write_flight
from subgoal.runtime.errors import InputError
from tests.flight.made import loop

pytest.importorskip("rotorpy")


def flown(path: np.ndarray, units: str = "m", scale: float = 1.0) -> Flight:
    """A flight that was at ``path`` (n, 2), metres in the plane yz."""
    real = fly(Waypoints(np.array([[0.0, 0.0], [1.0, 0.0]]) / scale, dimensions=("y", "z"), units=units))
    n = len(path)
    cut = {name: getattr(real, name)[:n] for name in ("velocities", "quaternions", "commanded", "thrust")}
    return replace(real, times=np.arange(n) / 100, positions=np.column_stack([np.zeros(n), path]), **cut)


def shown(*paths: list, units: str = "m", names: tuple[str, ...] = ("y", "z")) -> Demonstrations:
    states = np.vstack([np.array(path, float) for path in paths])
    offset = np.cumsum([0, *map(len, paths)])
    return Demonstrations.from_arrays(states, np.ones_like(states), offset, names=names, units=units)


def test_distances_are_to_lines_and_not_to_samples() -> None:
    error = tracking(flown(np.array([[0.0, 0.1], [0.5, 0.1], [1.0, 0.1]])), shown([[0, 0], [1, 0]]))
    np.testing.assert_allclose(error.flown, 0.1)
    np.testing.assert_allclose(error.demonstrated, 0.1)
    assert (error.rmse, error.largest) == pytest.approx((0.1, 0.1))


def test_both_directions_count_one_half() -> None:
    error = tracking(flown(np.array([[0.0, 0.0], [0.2, 0.0], [0.5, 0.0]])), shown([[0, 0], [1, 0]]))
    np.testing.assert_allclose(error.flown, 0, atol=1e-12)
    np.testing.assert_allclose(error.demonstrated, [0, 0.5])
    assert error.rmse == pytest.approx(np.sqrt(0.125 / 2))
    assert error.largest == pytest.approx(0.5)


def test_trajectories_are_not_joined() -> None:
    error = tracking(flown(np.array([[0.5, 0.0], [0.5, 0.0]])), shown([[0, 0], [0, 1]], [[1, 0], [1, 1]]))
    np.testing.assert_allclose(error.flown, 0.5)


def test_a_trajectory_of_one_sample_is_a_point() -> None:
    error = tracking(flown(np.array([[0.5, 0.0], [0.5, 0.2]])), shown([[0.5, 1]]))
    np.testing.assert_allclose(error.flown, [1.0, 0.8])


def test_distances_are_in_the_units_of_the_demonstration() -> None:
    flight = flown(np.array([[0.0, 0.01], [0.1, 0.01]]), "mm", 0.001)
    error = tracking(flight, shown([[0, 0], [1000, 0]], units="mm"))
    np.testing.assert_allclose(error.flown, 10)
    assert error.told == "450 mm from the demonstrated path (RMS), 900 mm at most"


def test_angles_are_compared_at_the_nearest_point_and_wrap() -> None:
    flight = fly(loop())
    turned = np.linspace(0, 2 * np.pi, 400)
    round_about = np.column_stack([0.45 * np.sin(turned), 0.95 - 0.45 * np.cos(turned), turned])
    names = ("y", "z", "angle")
    more = np.array([0, 0, 1])
    plain = tracking(flight, shown(round_about, names=names))
    again = tracking(flight, shown(round_about + 4 * np.pi * more, names=names))
    aside = tracking(flight, shown(round_about + np.pi * more, names=names))
    assert plain.rmse < 0.03
    assert 0.1 < plain.angle_rmse < 0.6
    assert again.angle_rmse == pytest.approx(plain.angle_rmse)
    assert aside.angle_rmse > 2.5


def test_other_coordinates_are_refused() -> None:
    with pytest.raises(InputError, match="coordinates a, b, wanted y, z"):
        tracking(flown(np.zeros((2, 2))), shown([[0, 0], [1, 0]], names=("a", "b")))


def test_a_flight_is_written_with_its_numbers(tmp_path) -> None:
    flight = fly(Waypoints(np.array([[0.0, 0.5], [1.0, 0.5]]), dimensions=("y", "z"), units="m"))
    error = tracking(flight, shown([[0, 0.5], [1, 0.5]]))
    table, numbers = write_flight(flight, error, tmp_path / "new")
    rows = list(csv.DictReader(table.open()))
    assert len(rows) == len(flight.times)
    np.testing.assert_allclose([float(row["y"]) for row in rows], flight.positions[:, 1], atol=1e-8)
    told = json.loads(numbers.read_text())
    assert (told["status"], told["tracking_rmse"]) == ("FLOWN", error.rmse)
    assert [place["waypoint"] for place in told["places"]] == [1, 2]
