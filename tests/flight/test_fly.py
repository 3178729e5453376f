"""Flights of a simulated quadrotor: hover, square, flip, and what cannot be flown."""

from __future__ import annotations

import os
import signal
from dataclasses import replace

import numpy as np
import pytest

from subgoal.flight import FlightStatus, Waypoints, fly, smooth, tracking, waypoints
from subgoal.flight.commands import commands_along
from subgoal.flight.vehicle import Simulated, vehicle_named
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent
from tests.flight.made import LEAST, RADIUS, TURN, flip, loop, square

pytest.importorskip("rotorpy")
HOP = Waypoints(np.array([[0.0, 0, 1], [0.6, 0, 1]]), units="m")


@pytest.mark.parametrize("smoothing", ["stop", "through"])
@pytest.mark.parametrize("vehicle", ["hummingbird", "crazyflie"])
def test_a_square_is_flown_within_tolerance(smoothing: str, vehicle: str) -> None:
    flight = fly(waypoints(square()), smoothing=smoothing, vehicle=vehicle)
    assert flight.status is FlightStatus.FLOWN
    assert flight.misses.max() < 0.01
    assert np.linalg.norm(flight.positions - flight.commanded, axis=1).max() < 0.02
    assert tracking(flight, square().demonstrations).rmse < 0.05


def test_a_vertical_square_stays_in_its_plane_and_a_level_one_at_its_height() -> None:
    upright, level = fly(waypoints(square()), plane="xz"), fly(waypoints(square()), plane="xy", height=1.3)
    assert np.abs(upright.positions[:, 1]).max() < 1e-6
    assert np.abs(level.positions[:, 2] - 1.3).max() < 0.02


def test_hover_stays() -> None:
    flight = fly(Waypoints(HOP.positions, dwell=[0.0, 5.0]))
    still = flight.times > flight.path.arrivals[-1] + 2
    assert np.abs(flight.positions[still] - [0.6, 0, 1]).max() < 1e-3
    np.testing.assert_allclose(flight.thrust[still], 0.5 * 9.81, rtol=1e-2)


@pytest.mark.parametrize("plane", ["yz", "xz"])
@pytest.mark.parametrize("turn", [1, -1])
def test_a_flip_is_inverted_at_the_top_and_level_at_both_ends(plane: str, turn: int) -> None:
    flight = fly(loop(turn), plane=plane)
    top = int(np.argmax(flight.positions[:, 2]))
    assert flight.status is FlightStatus.FLOWN
    assert abs(flight.angles[0]) < 0.01
    assert abs(flight.angles[-1] - turn * TURN) < 0.05
    assert abs(flight.angles[top] - turn * np.pi) < 0.3
    np.testing.assert_allclose(np.ptp(flight.shown, axis=0) / 2, RADIUS, atol=0.03)


def test_a_demonstrated_flip_is_flown_as_it_was_shown() -> None:
    posterior = flip()
    flight = fly(waypoints(posterior))
    top = int(np.argmax(flight.positions[:, 2]))
    error = tracking(flight, posterior.demonstrations)
    assert flight.status is FlightStatus.FLOWN
    assert abs(flight.angles[top] - np.pi) < 0.3
    assert flight.positions[top, 2] == pytest.approx(LEAST + 2 * RADIUS, abs=0.03)
    assert error.rmse < 0.03
    np.testing.assert_allclose(error.halves_flown, error.halves_demonstrated, atol=0.03)


def test_a_narrow_loop_is_flown_as_narrow_as_the_vehicle_can() -> None:
    slim, slimmest = fly(loop(roundness=0.8)), fly(loop(roundness=0.1))
    assert slim.status is slimmest.status is FlightStatus.FLOWN
    assert np.ptp(slim.shown[:, 0]) / 2 == pytest.approx(0.8 * RADIUS, abs=0.03)
    assert 0.2 < np.ptp(slimmest.shown[:, 0]) / 2 < 0.75 * RADIUS
    assert np.ptp(slimmest.shown[:, 1]) / 2 == pytest.approx(RADIUS, abs=0.03)


def test_two_rounds_turn_twice() -> None:
    assert fly(loop(), rounds=2).angles[-1] == pytest.approx(2 * TURN, abs=0.05)


def test_a_crazyflie_cannot_loop() -> None:
    with pytest.raises(InputError, match="waypoint 2: found a tilt of 180° that crazyflie cannot have there"):
        fly(loop(), vehicle="crazyflie")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"cyclic": False, "turns": None}, "waypoint 2: found a flight that rests tilted by 180°"),
        ({"dwell": [0.0, 1.0]}, "dwell at waypoint 2: found a rest where the vehicle is tilted"),
        ({"turns": [np.pi, 3 * np.pi]}, "waypoint 2: found a turn by 540°"),
        ({"positions": [[0, 0.5, 0], [0, 0.5, np.pi]]}, "waypoint 2: found the same position"),
    ],
)
def test_tilts_that_cannot_be_flown_are_refused(fields: dict, message: str) -> None:
    own = loop()
    given = {"positions": own.positions, "cyclic": True, "dimensions": own.dimensions, "units": "m",
             "period": own.period, "turns": own.turns, **fields}  # fmt: skip
    with pytest.raises(InputError, match=message):
        fly(Waypoints(**given))


def test_commands_turn_the_vehicle_as_its_path_bends() -> None:
    made = vehicle_named("hummingbird")
    commands = commands_along(smooth(loop()), made, 0.01, 0.0)
    assert np.abs(commands.rates[:, [1, 2]]).max() < 1e-6
    assert commands.rates[:, 0].sum() * 0.01 == pytest.approx(TURN, abs=1e-6)


def test_drag_is_made_up_for() -> None:
    speed = {"speed": 3.0, "acceleration": 6.0}
    far = Waypoints(np.array([[0.0, 0, 1], [6.0, 0, 1]]), units="m")
    assert np.linalg.norm((flight := fly(far, **speed)).positions - flight.commanded, axis=1).max() < 0.03


def test_steps_are_those_of_a_fine_solver() -> None:
    from rotorpy.vehicles.multirotor import Multirotor

    made = vehicle_named("hummingbird")
    path = smooth(HOP, speed=2.0)
    commands = commands_along(path, made, 0.01, 0.0)
    model = Multirotor(made.parameters, integrator_kwargs={"rtol": 1e-9, "atol": 1e-9})
    ours, theirs = (Simulated(made, commands.positions[0], 0.0, 0.01) for _ in range(2))
    apart = []
    for k in range(len(commands.times)):
        flat = {"x": commands.positions[k], "x_dot": commands.velocities[k], "x_ddot": commands.accelerations[k],
                "yaw": 0.0, "yaw_dot": 0.0}  # fmt: skip
        orders = [
            craft.command(0.0, flat, commands.rates[k], commands.angular[k], craft.state["x"])
            for craft in (ours, theirs)
        ]
        ours.advance(orders[0])
        theirs.state = model.step(theirs.state, {"cmd_motor_speeds": orders[1]}, 0.01)
        apart.append(np.abs(ours.state["x"] - theirs.state["x"]).max())
    assert max(apart) < 2e-4


def test_noise_hangs_on_the_seed() -> None:
    one, again, other = (fly(HOP, noise=0.002, seed=seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.positions, again.positions)
    assert np.abs(one.positions - other.positions).max() > 1e-5
    assert np.abs(one.positions - fly(HOP).positions).max() < 0.02


def test_a_tight_tolerance_is_not_met() -> None:
    flight = fly(HOP, tolerance=1e-6)
    assert flight.status is FlightStatus.DID_NOT_ARRIVE
    assert flight.reached.tolist() == [True, False]


def test_noise_that_throws_the_vehicle_off_ends_the_flight() -> None:
    flight = fly(Waypoints(HOP.positions, dwell=[0.0, 20.0]), noise=5.0)
    assert flight.status is FlightStatus.DIVERGED
    assert flight.duration < flight.path.duration


SHORT = Waypoints(np.array([[0.0, 0, 1], [0.05, 0, 1], [0.056, 0, 1]]), units="m")


def test_the_tolerance_is_below_the_distance_of_waypoints() -> None:
    assert fly(SHORT).tolerance == pytest.approx(0.006 / 4)
    assert fly(HOP).tolerance == 0.1


def test_short_ways_are_flown_no_faster_than_thrust_can_swing() -> None:
    flight = fly(SHORT)
    assert flight.status is FlightStatus.FLOWN
    assert np.linalg.norm(flight.positions - flight.commanded, axis=1).max() < 0.01


def test_what_is_told_says_what_to_try() -> None:
    assert fly(HOP).told == "flown: every waypoint was reached within 0.1 m"
    assert "says little: the nearest two are 0.006 m apart" in fly(SHORT, tolerance=0.1).told
    assert "try a larger scale" in fly(SHORT, scale=1e-3).told
    assert "try less noise than 5 m" in fly(Waypoints(HOP.positions, dwell=[0.0, 20.0]), noise=5.0).told
    assert "try a lower speed, or a larger tolerance" in fly(HOP, tolerance=1e-6).told


@pytest.mark.parametrize(
    ("places", "options"),
    [([[0.0, 0, 1], [1e5, 0, 1]], {}), ([[0.0, 0, 1], [1, 0, 1]], {"speed": 1e-4}),
     ([[0.0, 0, 1], [1e-2, 0, 1]], {"acceleration": 1e-9})],
)  # fmt: skip
def test_flights_that_take_too_long_are_refused(places: list[list[float]], options: dict[str, float]) -> None:
    with pytest.raises(InputError, match=r"most_seconds: found a flight of .* wanted at most 600 s"):
        fly(Waypoints(np.array(places), units="m"), **options)
    with pytest.raises(InputError, match="most_seconds"):
        fly(Waypoints(HOP.positions, dwell=[0.0, 1e9]))


def test_what_is_no_waypoints_and_no_flight_is_refused() -> None:
    with pytest.raises(InputError, match="waypoints: found NoneType"):
        fly(None)
    with pytest.raises(InputError, match="posterior: found NoneType"):
        waypoints(None)
    with pytest.raises(InputError, match="tracking: found NoneType"):
        tracking(fly(HOP), None)


@pytest.mark.parametrize("wrong", [([np.nan], 1), ([0.0], 0), ([0.0], 99), ("a", 2)])
def test_a_path_is_asked_at_numbers(wrong: tuple) -> None:
    with pytest.raises(InputError, match=r"times|orders"):
        smooth(HOP).at(*wrong)


def test_a_flight_is_not_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        fly(HOP).positions[0] = 9


def test_a_loop_with_level_ways_before_and_after_is_flown() -> None:
    own = loop()
    places = np.array([[-1.0, LEAST, 0], own.positions[0], own.positions[1], own.positions[0], [1.0, LEAST, 0]])
    route = Waypoints(places, dimensions=own.dimensions, units="m", period=own.period,
                      turns=np.array([0, 0, np.pi, np.pi, 0]))  # fmt: skip
    flight = fly(route)
    assert flight.status is FlightStatus.FLOWN
    assert abs(flight.angles[-1] - TURN) < 0.05


class Breaking(Silent):
    """Presses Ctrl-C when the flight is half over."""

    def update(self, done: int, total: int, note: str = "") -> None:
        if 2 * done > total:
            os.kill(os.getpid(), signal.SIGINT)


def test_a_flight_that_is_interrupted_is_kept() -> None:
    flight = fly(HOP, speed=0.2, progress=Breaking())
    assert flight.status is FlightStatus.STOPPED
    assert 0.4 * flight.path.duration < flight.duration < flight.path.duration
    assert flight.reached.tolist() == [True, False]


def test_more_tolerance_lets_a_leaning_end_be_level() -> None:
    period = (np.inf, np.inf, TURN)
    leaning = Waypoints([[0.0, 0.5, 0.0], [0.5, 0.6, 0.4]], dimensions=("y", "z", "angle"), units="m", period=period)
    with pytest.raises(InputError, match="rests tilted by 23°"):
        fly(leaning)
    assert fly(leaning, tilt_tolerance=0.5).status is FlightStatus.FLOWN


SIDES = Waypoints(
    [[0.0, 0.5, 0.0], [RADIUS, 0.5 + RADIUS, np.pi / 2], [0, 0.5 + 2 * RADIUS, np.pi]],
    turns=[np.pi, np.pi / 2, np.pi / 2], dimensions=("y", "z", "angle"), units="m", period=(np.inf, np.inf, TURN),
    cyclic=True,
)  # fmt: skip
"""Bottom, side and top of a loop."""


def test_the_side_of_a_loop_is_passed_as_the_loop_lets_it() -> None:
    flight = fly(SIDES)
    assert flight.status is FlightStatus.FLOWN
    np.testing.assert_array_equal(flight.route.tilt_tolerance[1:3], [1.2, 0.3])
    assert flight.tilts[1] > 0.3 > flight.tilts[2]
    assert flight.reached.all()


def test_a_side_alone_is_asked_for_as_it_is() -> None:
    alone = replace(SIDES, positions=SIDES.positions[:2], names=(), labels=None, dwell=0.0, roundness=1.0,
                    turns=[1.5 * np.pi, np.pi / 2])  # fmt: skip
    with pytest.raises(InputError, match=r"waypoint 2: found a tilt of 90°.*tilt_tolerance"):
        fly(alone)


def test_a_loop_with_eight_places_is_flown() -> None:
    """As a posterior of a round loop has them: none where the loop leans most but one, which is not at its top."""
    angles = np.array([0, 0.7, 1.3, 1.8, 2.4, np.pi, 4.2, 5.3])
    places = np.column_stack([RADIUS * np.sin(angles), 0.5 + RADIUS - RADIUS * np.cos(angles), angles])
    flight = fly(replace(SIDES, positions=places, names=(), labels=None, dwell=0.0, roundness=1.0,
                         turns=np.diff(angles, prepend=angles[-1] - TURN)))  # fmt: skip
    assert flight.status is FlightStatus.FLOWN
    assert np.flatnonzero(flight.route.tilt_tolerance < 1).tolist() == [5]


def test_a_tilt_that_is_missed_is_told() -> None:
    flight = fly(SIDES)
    flight = replace(flight, status=FlightStatus.DID_NOT_ARRIVE, tilts=flight.tilts + 1)
    assert flight.told.endswith(
        "did not arrive at every waypoint with its tilt: try a larger tilt_tolerance (--tilt-tolerance)"
    )


@pytest.mark.parametrize(
    "options", [{"tolerance": 0.0}, {"tilt_tolerance": 0.0}, {"noise": -1.0}, {"noise": np.nan}, {"seed": -1}]
)
def test_wrong_options_are_refused(options: dict) -> None:
    with pytest.raises(InputError, match=next(iter(options))):
        fly(HOP, **options)
