"""Flights of a simulated quadrotor: hover, square, flip, and what cannot be flown."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.flight import FlightStatus, Waypoints, fly, tracking, waypoints
from subgoal.runtime.errors import InputError
from tests.flight.made import LEAST, RADIUS, TURN, flip, square

pytest.importorskip("rotorpy")


def test_a_square_is_flown_within_tolerance() -> None:
    flight = fly(waypoints(square()))
    assert flight.status is FlightStatus.FLOWN
    assert flight.misses.max() < 0.05
    assert tracking(flight, square().demonstrations).rmse < 0.05


def test_a_flip_is_inverted_at_the_top_and_level_at_both_ends() -> None:
    flight = fly(waypoints(flip()))
    top = np.argmax(flight.positions[:, 2])
    assert flight.status is FlightStatus.FLOWN
    assert abs(flight.angles[top] - np.pi) < 0.3
    assert abs(flight.angles[0]) < 0.01
    assert abs(flight.angles[-1] - TURN) < 0.05
    assert flight.positions[top, 2] == pytest.approx(LEAST + 2 * RADIUS, abs=0.15)


def test_hover_stays() -> None:
    flight = fly(Waypoints(np.array([[0.0, 0, 1], [0.1, 0, 1]]), dwell=[0.0, 5.0]))
    still = flight.times > flight.path.arrivals[-1] + 2
    assert np.abs(flight.positions[still] - [0.1, 0, 1]).max() < 1e-3


def test_a_crazyflie_cannot_loop() -> None:
    with pytest.raises(InputError, match="waypoint 1: found a loop that needs"):
        fly(waypoints(flip()), vehicle="crazyflie")
