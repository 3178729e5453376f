"""A car driven by hand: topics with clocks of their own on one clock, and what is said of it without labels."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from experiments import rc_car
from experiments.common import Options, figure_style
from experiments.rc_car import stalled
from experiments.rc_car_picture import words
from experiments.recorded_car import Recorded, body_motion, delays, held, read_recording, spans, topic
from experiments.recorded_study import Answer, forecast_error, main_of, matched
from subgoal.candidates import Candidates
from subgoal.demonstrations import Demonstrations, Metric

START = 1_700_000_000.9
RATE, TURN, SPEED = 25.0, 0.8, 1.5
GAP = (30.0, 31.5)


def steering(times: Any) -> Any:
    """Full left and full right in turn, 1.6 s each."""
    return np.where((np.asarray(times) % 3.2) < 1.6, 0.3, -0.3)


def yaw_rate(times: Any) -> Any:
    """A first-order lag of 0.2 s behind the steering, in closed form of one period."""
    phase = np.asarray(times) % 1.6
    edge = (1 - np.exp(-8.0)) / (1 + np.exp(-8.0))
    return np.sign(steering(times)) * (1 - (1 + edge) * np.exp(-phase / 0.2)) * 2.0


def written(folder: Path, name: str, times: Any, **columns: Any) -> None:
    lines = ["," + ",".join(["s", "ns", *columns])]
    for k, time in enumerate(times):
        whole = int(np.floor(START + time))
        values = [str(column[k]) for column in columns.values()]
        lines.append(",".join([str(k), str(whole), str(round((START + time - whole) * 1e9)), *values]))
    (folder / f"{name}Data.csv").write_text("\n".join(lines) + "\n")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Sixty seconds with a gap: the four topics begin one after the other and tick differently."""
    made = tmp_path_factory.mktemp("data") / "DS5"
    made.mkdir()
    clocks = [k * 0.02 + np.arange(0, 60, 1 / (RATE + 3 * k)) for k in range(4)]
    clocks = [at[(at <= GAP[0]) | (at >= GAP[1])] for at in clocks]
    fine = np.arange(0, 61, 0.002)
    heading = np.cumsum(yaw_rate(fine)) * 0.002
    x, y = (np.cumsum(SPEED * turn(heading)) * 0.002 for turn in (np.cos, np.sin))
    command, odom, imu, pose = clocks
    slow = np.where(command % 20 < 4, 0.0, SPEED)
    written(made, "command", command, V=slow, delta=steering(command))
    wheels = np.where((odom - 0.1) % 20 < 4, 0.0, SPEED)
    written(made, "odom", odom, vx=wheels)
    written(made, "imu", imu, wz=np.degrees(yaw_rate(imu)))
    at = np.interp(pose, fine, heading)
    written(made, "pfPose", pose, x=np.interp(pose, fine, x), y=np.interp(pose, fine, y),
            **{"q.z": np.sin(at / 2), "q.w": np.cos(at / 2)})  # fmt: skip
    return made


@pytest.fixture(scope="module")
def car(folder: Path) -> Recorded:
    return read_recording(folder)


def test_times_are_seconds_and_messages_that_come_twice_count_once(tmp_path: Path) -> None:
    rows = [",s,ns,V", "0,10,500000000,1", "1,11,250000000,2", "2,11,250000000,3", "3,9,750000000,4"]
    (tmp_path / "commandData.csv").write_text("\n".join(rows))
    times, table = topic(tmp_path, "command")
    np.testing.assert_allclose(times, [9.75, 10.5, 11.25])
    assert table["V"].tolist() == [4, 1, 2]


def test_all_topics_stand_on_one_clock_without_the_gap(car: Recorded) -> None:
    assert len(car.offset) == 3
    steps = np.diff(car.times)
    np.testing.assert_allclose(np.delete(steps, car.offset[1] - 1), 0.05, atol=1e-9)
    assert car.times[car.offset[1] - 1] < GAP[0] < GAP[1] < car.times[car.offset[1]]
    np.testing.assert_allclose(car.states["yaw rate"], yaw_rate(car.times), atol=0.25)
    assert np.median(np.abs(car.states["yaw rate"] - yaw_rate(car.times))) < 0.01


def test_gyroscopes_count_in_degrees_and_the_state_in_radians(car: Recorded) -> None:
    assert 1.9 < car.states["yaw rate"].max() < 2.01


def test_speed_ahead_comes_from_the_pose_and_there_is_none_sideways(car: Recorded) -> None:
    assert abs(np.median(car.states["vx"]) - SPEED) < 0.06
    assert abs(np.median(car.states["vy"])) < 0.05


def test_speed_to_the_left_is_above_zero() -> None:
    at = np.arange(0, 3, 0.05)
    pose = pd.DataFrame({"x": 0 * at - 0.5 * at, "y": 2 * at, "q.z": np.sin(np.pi / 4) + 0 * at,
                         "q.w": np.cos(np.pi / 4) + 0 * at})  # fmt: skip
    ahead, left, rate = body_motion((at, pose), np.array([1.0, 2.0]))
    np.testing.assert_allclose([ahead, left, rate], [[2, 2], [0.5, 0.5], [0, 0]], atol=1e-9)


def test_commands_hold_until_the_next() -> None:
    sent = held(np.array([1.0, 2.0]), pd.Series([5.0, 6.0]), np.array([0.5, 1.0, 1.99, 2.0, 9.0]))
    assert sent.tolist() == [5, 5, 5, 6, 6]


def test_a_command_that_works_later_is_the_one_sent_earlier(folder: Path, car: Recorded) -> None:
    late = read_recording(folder, steer_late=0.2)
    np.testing.assert_array_equal(late.commands[100:200, 0], car.commands[96:196, 0])
    np.testing.assert_array_equal(late.commands[:, 1], car.commands[:, 1])


def test_spans_are_where_no_topic_is_silent_and_short_ones_are_dropped() -> None:
    even = np.arange(0, 40, 0.1)
    torn = even[(even < 10) | (even > 11)]
    other = even[(even < 13) | (even > 14)]
    found = spans([torn, other])
    np.testing.assert_allclose(found, [(0.3, 9.6), (14.4, 39.6)], atol=1e-6)


def test_delays_are_found(folder: Path) -> None:
    found = delays(folder)
    assert abs(found["wheels_after_command"] - 0.1) < 0.03
    assert found["yaw_rate_after_steering"] > 0.05
    assert abs(found["pose_after_gyroscope"]) < 0.03


def test_a_stalled_motor_is_counted() -> None:
    zeros = np.zeros(4)
    speed = np.array([0.0, 1.0, 1.0, -2.0])
    car = Recorded(
        zeros, {"wheels": np.array([0, 0, 1, 0.0])}, np.stack([zeros, speed], 1), np.zeros((4, 2)), np.array([0, 4])
    )
    assert stalled(car) == 0.5


@pytest.mark.parametrize(
    ("state", "told"),
    [
        ((0.1, 0.0), "stop"),
        ((2.0, 2.3), "fast left"),
        ((-1.0, 1.2), "slow right"),
        ((0.2, 2.5), "fast straight"),
        ((-1.0, -1.2), "reverse right"),
    ],
)
def test_states_have_words(state: tuple[float, float], told: str) -> None:
    assert words(np.array(state)) == told


def test_main_subgoals_serve_five_in_a_hundred() -> None:
    assert main_of(np.array([7] * 94 + [2] * 5 + [1])).tolist() == [2, 7]
    assert main_of(np.arange(100)).tolist() == [0]


def test_subgoals_are_matched_one_to_one_and_each_has_a_nearest() -> None:
    def answered(points: list[list[float]]) -> Answer:
        goals: Any = Candidates(points=np.array(points))
        nothing: Any = None
        return Answer(nothing, nothing, nothing, goals, goals, np.zeros(1, int))

    one, other = answered([[0.0], [1.0], [9.0]]), answered([[0.6], [0.9]])
    apart, nearest = matched(one, other, Metric(np.array([2.0]), np.array([np.inf])))
    np.testing.assert_allclose(apart, [0.2, 1.2])
    np.testing.assert_allclose(nearest, [1.2, 0.2, 16.2])
    np.testing.assert_allclose(matched(other, one, Metric(np.array([1.0]), np.array([np.inf])))[1], [0.4, 0.1])


def test_forecasts_of_what_is_linear_are_right_and_the_change_is_what_they_are_measured_by() -> None:
    rng = np.random.default_rng(3)

    def drive(n: int) -> Demonstrations:
        action = np.repeat(rng.normal(size=(n // 4, 1)), 4, axis=0)
        state = np.zeros((n, 1))
        for k in range(n - 1):
            state[k + 1] = 0.9 * state[k] + action[k]
        return Demonstrations(states=state, actions=action, offset=np.array([0, n]), times=0.1 * np.arange(n),
                              names=("v",))  # fmt: skip

    error, change = forecast_error(drive(200), drive(120), step=0.1, horizon=0.6, told=("v",), kind="linear")
    assert error.shape == change.shape == (57, 1)
    assert error.max() < 1e-9
    assert change.mean() > 1


def test_left_and_right_are_found_on_a_made_slalom(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rc_car, "FEW", {"chains": 1, "warmup": 30, "draws": 30, "thin": 1, "workers": 1})
    with figure_style():
        headline, figure = rc_car.experiment(Options(out=folder, quick=True, data=folder.parent))
    told = {row["words"].split()[-1] for row in headline["manoeuvres"]}
    assert {"left", "right"} <= told
    assert headline["n_subgoals"] == len(headline["manoeuvres"])
    assert sum(row["share"] for row in headline["manoeuvres"]) == pytest.approx(1)
    assert {"n_subgoals", "held_out_error", "bellman_residual", "stability"} <= set(headline)
    assert headline["stability"]["halves"]["matched_within_one_unit"] >= 2
    assert len(figure.axes) == 4
