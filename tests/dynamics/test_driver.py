"""The driver: what it records is what the car did, its errors have their law, and it holds what it is after."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import expm

from subgoal.dynamics import ALL_DRIVE, REAR_DRIVE, SCRIPT, Car, drive, manoeuvres, path, turns
from subgoal.dynamics.driver import regulator
from subgoal.dynamics.equilibria import jacobians
from subgoal.runtime.errors import InputError

CARS = pytest.mark.parametrize("car", [REAR_DRIVE, ALL_DRIVE], ids=lambda car: car.drive)


def runs_of(labels: np.ndarray) -> list[tuple[int, int]]:
    """(label, length) of each run."""
    cuts = np.flatnonzero(np.diff(labels)) + 1
    return [(int(run[0]), len(run)) for run in np.split(labels, cuts)]


@CARS
def test_the_record_is_what_the_car_did(car: Car) -> None:
    told = drive(car, seed=3)
    demos = told.demonstrations
    assert demos.states.shape == (3000, 4) and demos.actions.shape == (3000, 2) and told.labels.shape == (3000,)
    np.testing.assert_allclose(demos.times, np.arange(3000) / 100, atol=1e-12)
    after = replace(car, step=0.0025)(demos.states, demos.actions, 0.01)
    np.testing.assert_array_equal(after[:-1], demos.states[1:])
    np.testing.assert_array_equal(after[-1:], demos.final_states)
    np.testing.assert_array_equal(demos.states[0], 0.0)
    low, high = car.bounds
    assert (demos.actions >= low).all() and (demos.actions <= high).all()
    assert demos.names == car.names and demos.truncated.all()
    assert repr(told) == "Driven(3000 pairs, stop, straight, left, right, left drift, right drift)"


def test_the_script_is_driven_in_its_order() -> None:
    told = drive(REAR_DRIVE, seed=0)
    names = list(told.places)
    wanted = [
        "stop",
        "straight",
        "left",
        "straight",
        "right",
        "straight",
        "left drift",
        "straight",
        "right drift",
        "stop",
    ]
    assert [names[label] for label, _ in runs_of(told.labels)] == wanted


def test_lengths_vary_by_their_law() -> None:
    """log(length / mean) over 60 drives: standard deviation 0.15, less a little for the common scale."""
    labels = drive(ALL_DRIVE, rate=20, trajectories=60).labels.reshape(60, 600)
    lengths = np.array([[length for _, length in runs_of(each)] for each in labels])
    spread = np.log(lengths / 20 / np.array([length for _, length in SCRIPT])).std()
    assert lengths.sum(axis=1).tolist() == [600] * 60
    assert 0.12 < spread < 0.16


def test_shuffled_keeps_the_ends_and_the_share_of_each() -> None:
    orders = set()
    for seed in range(5):
        told = drive(ALL_DRIVE, seed=seed, order="shuffled", rate=20)
        names = list(told.places)
        runs = [names[label] for label, _ in runs_of(told.labels)]
        assert runs[0] == runs[-1] == "stop"
        assert set(runs) == set(names)
        orders.add(tuple(runs))
    assert len(orders) == 5
    assert any("straight" not in pair for runs in orders for pair in pairwise(runs[1:-1]))


def test_shuffled_segments_keep_their_lengths() -> None:
    """Shares of the time over 60 drives: 4.5 s of 32.5 s for each turn and drift, ±0.012."""
    told = drive(ALL_DRIVE, order="shuffled", rate=20, trajectories=60)
    shares = np.bincount(told.labels) / told.labels.size
    np.testing.assert_allclose(shares[2:], 4.5 / 32.5, atol=0.012)


def test_seeds_and_trajectories_have_streams_of_their_own() -> None:
    one, two = drive(REAR_DRIVE, seed=5, duration=3), drive(REAR_DRIVE, seed=5, duration=3, trajectories=2)
    np.testing.assert_array_equal(one.demonstrations.states, two.demonstrations.states[:300])
    assert two.demonstrations.offset.tolist() == [0, 300, 600]
    assert not np.array_equal(two.demonstrations.actions[:300], two.demonstrations.actions[300:])
    other = drive(REAR_DRIVE, seed=6, duration=3)
    assert not np.array_equal(other.demonstrations.actions, one.demonstrations.actions)


def test_without_noise_and_feedback_the_hand_follows_with_its_lag() -> None:
    """1 − exp(−t / 0.1 s) of the way from the straight command to the left one."""
    told = drive(ALL_DRIVE, [("straight", 1.0), ("left", 1.0)], noise=0, feedback=False, duration=2)
    turned = np.flatnonzero(told.labels == list(told.places).index("left"))
    share = 1 - np.exp(-np.arange(1, len(turned) + 1) / 100 / 0.1)
    np.testing.assert_allclose(told.demonstrations.actions[turned, 0], 0.22 * share, atol=1e-12)
    np.testing.assert_allclose(told.demonstrations.actions[turned, 1], 1.9 - 0.4 * share, atol=1e-12)


@pytest.mark.parametrize(("name", "scale"), [("straight", 1.0), ("straight", 2.0), ("stop", 1.0)])
def test_the_hand_wanders_by_its_law(name: str, scale: float) -> None:
    """Steering of 200 s, standard deviation 0.03 rad (× 0.3 at rest) and 1/e left after 0.2 s: by ±15 % and ±0.12."""
    told = drive(ALL_DRIVE, [(name, 1.0)], noise=scale, feedback=False, duration=200)
    errors = told.demonstrations.actions[:, 0] - told.demonstrations.actions[:, 0].mean()
    wanted = 0.03 * scale * (0.3 if name == "stop" else 1.0)
    assert abs(errors.std() / wanted - 1) < 0.15
    assert abs((errors[20:] * errors[:-20]).mean() / errors.var() - np.exp(-1)) < 0.12


def test_speed_commands_wander_by_theirs() -> None:
    told = drive(ALL_DRIVE, [("straight", 1.0)], feedback=False, duration=200)
    assert abs(told.demonstrations.actions[:, 1].std() / 0.10 - 1) < 0.15


def test_each_segment_has_an_offset_of_its_own() -> None:
    """Mean commands of 300 segments of 6 s: 0.01 rad and 0.06 m/s beside what wandering leaves in a mean, by ±15 %."""
    script = [("straight", 6.0), ("left", 6.0)] * 10
    told = drive(ALL_DRIVE, script, feedback=False, duration=120, trajectories=15, rate=20)
    goals = list(told.places.values())
    errors, at = [], 0
    for label, length in runs_of(told.labels):
        inside = slice(at + 20, at + length)
        errors.append(told.demonstrations.actions[inside].mean(axis=0) - goals[label].action)
        at += length
    left = np.array([0.03, 0.10]) * np.sqrt(2 * 0.2 / 5)
    np.testing.assert_allclose(np.std(errors, axis=0), np.hypot([0.01, 0.06], left), rtol=0.15)


@CARS
@pytest.mark.parametrize("name", ["straight", "left", "right drift"])
def test_feedback_brings_the_car_to_what_it_is_after(car: Car, name: str) -> None:
    told = drive(car, [("stop", 1.0), (name, 9.0)], noise=0, duration=10)
    goal = told.places[name]
    np.testing.assert_allclose(told.demonstrations.final_states[0], goal.state, atol=0.01)


def test_only_feedback_holds_the_drift_of_a_rear_driven_car() -> None:
    start = manoeuvres(REAR_DRIVE)["left drift"].state
    held, left = (
        drive(REAR_DRIVE, [("left drift", 1.0)], noise=0.2, feedback=feedback, duration=10)
        for feedback in (True, False)
    )
    assert abs(held.demonstrations.final_states[0] - start).max() < 0.5
    assert abs(left.demonstrations.final_states[0] - start).max() > 1.0


@pytest.mark.parametrize("name", ["straight", "left drift"])
def test_gains_are_those_of_the_riccati_recursion(name: str) -> None:
    """K of 0.02 s by 4,000 steps of dynamic programming."""
    goal = manoeuvres(REAR_DRIVE)[name]
    by_state, by_action = jacobians(REAR_DRIVE, goal.state, goal.action)
    a = expm(0.02 * by_state)
    parts = [expm(0.02 * (k + 0.5) / 200 * by_state) for k in range(200)]
    b = sum(parts) @ by_action * 0.02 / 200
    state_cost, action_cost = np.diag([4, 4, 1, 0.01]), np.diag([1 / 0.15**2, 1 / 0.7**2])
    cost = state_cost
    for _ in range(4000):
        gain = np.linalg.solve(action_cost + b.T @ cost @ b, b.T @ cost @ a)
        cost = state_cost + a.T @ cost @ (a - b @ gain)
    np.testing.assert_allclose(regulator(REAR_DRIVE, goal), gain, rtol=1e-4, atol=1e-6)


@CARS
def test_turns_are_three_radii(car: Car) -> None:
    told = turns(car, noise=0.5, seed=1)
    rates = [told.demonstrations.states[told.labels == k, 2].mean() for k in range(3)]
    assert list(told.places) == ["wide right", "right", "tight right"]
    np.testing.assert_allclose(rates, [goal.state[2] for goal in told.places.values()], atol=0.1)
    np.testing.assert_allclose(rates, [-0.72, -1.44, -2.29], atol=0.2)
    assert len(runs_of(told.labels)) == 6


def test_a_path_of_constant_velocities_is_a_circle() -> None:
    goal = manoeuvres(ALL_DRIVE)["left drift"]
    times = np.linspace(0, 2 * np.pi / goal.state[2], 2001)
    ran = path(np.tile(goal.state, (2001, 1)), times)
    np.testing.assert_array_equal(ran[0], 0.0)
    np.testing.assert_allclose(ran[-1], [0, 0, 2 * np.pi], atol=1e-9)
    centre = np.array([-goal.state[1], goal.state[0]]) / goal.state[2]
    np.testing.assert_allclose(np.hypot(*(ran[:, :2] - centre).T), np.hypot(*centre), rtol=1e-5)
    assert np.arctan2(*ran[1, 1::-1]) == pytest.approx(goal.sideslip, abs=2e-3)


def test_a_path_is_of_second_order() -> None:
    def end(count: int) -> np.ndarray:
        times = np.linspace(0, 2, count + 1) ** 1.2
        return path(np.c_[1 + times, np.sin(times), 2 * np.cos(times)], times)[-1]

    exact = end(6400)
    coarse, fine = abs(end(100) - exact).max(), abs(end(200) - exact).max()
    assert 3.5 < coarse / fine < 4.5


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"script": [("straight", 2.0), ("loop", 1.0)]}, "script at segment 1: found ('loop', 1.0), wanted (name, sec"),
        ({"script": [("straight", float("nan"))]}, "seconds of segment 0 of the script: found nan"),
        ({"script": []}, "script: found no segments"),
        ({"order": "reversed"}, "order: found 'reversed'"),
        ({"noise": -1.0}, "noise: found -1.0"),
        ({"rate": 0.0}, "rate: found 0.0"),
        ({"duration": 0.001}, "duration: found 0.001, wanted at least 0.01 s"),
        ({"trajectories": 0}, "trajectories: found 0"),
        ({"seed": -1}, "seed: found -1"),
    ],
)
def test_impossible_drives_are_refused(fields: dict, message: str) -> None:
    with pytest.raises(InputError) as problem:
        drive(REAR_DRIVE, **fields)
    assert message in str(problem.value)


def test_impossible_paths_are_refused() -> None:
    with pytest.raises(InputError, match=r"states and times: found shapes \(3, 2\) and \(3,\)"):
        path(np.ones((3, 2)), np.arange(3))
    with pytest.raises(InputError, match="times at row 2: found 1"):
        path(np.ones((3, 4)), [0.0, 1.0, 1.0])
