"""The car: against a slow form of it, its integration, its symmetries, where energy goes, and what it refuses."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from subgoal._kernels import car as loops
from subgoal.dynamics import ALL_DRIVE, REAR_DRIVE, Car
from subgoal.runtime.errors import InputError
from tests.exact.replay import plain, python_form
from tests.oracles import car as oracle

CARS = pytest.mark.parametrize("car", [REAR_DRIVE, ALL_DRIVE], ids=lambda car: car.drive)


def pairs(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """States of all kinds, at rest and sliding backwards among them, and actions within the bounds."""
    generator = np.random.default_rng(seed)
    states = generator.normal([1.0, 0.0, 0.0, 1.5], [1.0, 1.0, 3.0, 1.0], size=(count, 4))
    states[0] = 0.0
    return states, generator.uniform(*REAR_DRIVE.bounds, size=(count, 2))


@CARS
def test_derivatives_are_those_of_the_slow_form(car: Car) -> None:
    states, actions = pairs(60)
    slow = [oracle.derivative(s, a, car.drive) for s, a in zip(states, actions, strict=True)]
    np.testing.assert_allclose(car.derivative(states, actions), slow, rtol=1e-11, atol=1e-11)


@CARS
def test_a_held_action_leads_where_the_slow_form_says(car: Car) -> None:
    states, actions = pairs(12)
    slow = [oracle.after(s, a, car.drive, 0.25) for s, a in zip(states, actions, strict=True)]
    np.testing.assert_allclose(replace(car, step=1e-4)(states, actions, 0.25), slow, atol=2e-5)


@CARS
def test_halving_the_step_quarters_the_error(car: Car) -> None:
    """Heun's method is of second order; a drift, in which everything changes."""
    state, action = np.array([1.2, -0.7, 2.0, 2.0]), np.array([-0.2, 2.8])
    exact = oracle.after(state, action, car.drive, 0.2)
    coarse, fine = (abs(replace(car, step=h)([state], [action], 0.2)[0] - exact).max() for h in (0.002, 0.001))
    assert 1e-7 < fine < 1e-4
    assert 3.6 < coarse / fine < 4.4


@CARS
def test_compiled_is_its_python_form(car: Car) -> None:
    states, actions = pairs(9)
    compiled = car(states, actions, 0.1), car.derivative(states, actions)
    with python_form(loops):
        out = np.empty_like(states), np.empty_like(states)
        plain(loops.advance)(states, actions, 0.1, car.step, car._build, out[0])
        plain(loops.derivatives)(states, actions, car._build, out[1])
    for ours, theirs in zip(compiled, out, strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-13, atol=1e-13)


@CARS
def test_steps_are_equal_and_at_most_as_long_as_said(car: Car) -> None:
    """0.012 s are three steps of 0.004 s, as 0.004 s thrice; 0.015 s are three of the longest, not four."""
    states, actions = pairs(5)
    by_three = states
    for _ in range(3):
        by_three = car(by_three, actions, 0.004)
    np.testing.assert_allclose(car(states, actions, 0.012), by_three, rtol=1e-13)
    by_three = states
    for _ in range(3):
        by_three = car(by_three, actions, 0.005)
    np.testing.assert_allclose(car(states, actions, 0.015), by_three, rtol=1e-13)


@CARS
def test_left_is_the_mirror_of_right(car: Car) -> None:
    states, actions = pairs(30)
    left, right = car(states, actions, 0.2), car(states * [1, -1, -1, 1], actions * [-1, 1], 0.2)
    np.testing.assert_allclose(right * [1, -1, -1, 1], left, rtol=1e-9, atol=1e-12)


@CARS
def test_rows_do_not_hang_on_each_other_and_nothing_is_written_into_the_input(car: Car) -> None:
    states, actions = pairs(20)
    before = states.copy(), actions.copy()
    together = car(states, actions, 0.05)
    np.testing.assert_array_equal(car(states[7:8], actions[7:8], 0.05)[0], together[7])
    np.testing.assert_array_equal(states, before[0])
    np.testing.assert_array_equal(actions, before[1])


@CARS
def test_locked_wheels_take_energy_from_every_motion(car: Car) -> None:
    states, actions = pairs(200)
    states[:, 3] = actions[:, 1] = 0.0
    rate = car.derivative(states, actions)
    power = car.mass * (states[:, :2] * rate[:, :2]).sum(axis=1) + car.inertia * states[:, 2] * rate[:, 2]
    assert power[0] == 0
    assert (power[1:] < 0).all()


def test_a_rolling_car_is_slowed_by_the_drag_of_its_free_wheels() -> None:
    vx = 1.5
    drag = 0.02 * 9.81 * REAR_DRIVE.rear / (REAR_DRIVE.front + REAR_DRIVE.rear) * vx / np.hypot(vx, 0.3)
    np.testing.assert_allclose(REAR_DRIVE.derivative([[vx, 0, 0, vx]], [[0, vx]]), [[-drag, 0, 0, 0]], atol=1e-14)
    assert not ALL_DRIVE.derivative([[vx, 0, 0, vx]], [[0, vx]]).any()


@CARS
def test_acceleration_stays_within_the_friction_circle(car: Car) -> None:
    states, actions = pairs(500)
    rate, (vx, vy, r, _) = car.derivative(states, actions), states.T
    felt = np.hypot(rate[:, 0] - vy * r, rate[:, 1] + vx * r)
    assert felt.max() <= 9.81 * np.hypot(car.friction, car.rolling)
    assert felt.max() > 0.9 * 9.81 * car.friction


def test_speeding_up_loads_the_rear_axle_of_a_high_car() -> None:
    """Forces on the axles of a straight car that spins its rear wheels: F_zr = (m g l_f + h m a) / L, found by hand."""
    high = replace(REAR_DRIVE, height=0.05, rolling=0.0)
    state, action = [[1.0, 0.0, 0.0, 3.0]], [[0.0, 3.0]]
    share = oracle.tyre((1.0 - 3.0) / np.hypot(3.0, 0.3)).real
    wanted = 9.81 * share * high.front / (high.front + high.rear - high.height * share)
    np.testing.assert_allclose(high.derivative(state, action)[0, 0], wanted, rtol=1e-13)
    assert wanted > replace(high, height=0.0).derivative(state, action)[0, 0]


def test_the_wheel_follows_its_command() -> None:
    after = replace(REAR_DRIVE, step=1e-4)([[0.0, 0.0, 0.0, 0.5]], [[0.0, 2.0]], 0.3)[0, 3]
    np.testing.assert_allclose(after, 2.0 - 1.5 * np.exp(-3), rtol=1e-6)


def test_no_time_changes_nothing() -> None:
    states, actions = pairs(4)
    np.testing.assert_array_equal(REAR_DRIVE(states, actions, 0.0), states)


def test_cars_are_records() -> None:
    assert pickle.loads(pickle.dumps(ALL_DRIVE)) == ALL_DRIVE != REAR_DRIVE
    assert replace(REAR_DRIVE, friction=0.45 * 0.85).friction == pytest.approx(0.3825)
    assert REAR_DRIVE.names == ("vx", "vy", "r", "w")
    with pytest.raises(ValueError, match="read-only"):
        REAR_DRIVE.bounds[0][0] = -1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"mass": 0.0}, "mass: found 0.0, wanted a finite number above 0"),
        ({"inertia": float("nan")}, "inertia: found nan"),
        ({"rolling": -0.1}, "rolling: found -0.1, wanted a finite number of at least 0"),
        ({"friction": "dry"}, "friction: found 'dry'"),
        ({"drive": "front"}, "drive: found 'front', wanted 'rear' or 'all'"),
        ({"height": 0.3}, "height: found 0.3, wanted below 0.213 m"),
        ({"step": 0.02}, "step: found 0.02, wanted at most 0.00"),
    ],
)
def test_impossible_cars_are_refused(changes: dict, message: str) -> None:
    with pytest.raises(InputError) as problem:
        Car(**changes)
    assert message in str(problem.value)


def test_impossible_states_and_actions_are_refused() -> None:
    states, actions = pairs(3)
    with pytest.raises(InputError, match=r"states: found shape \(3, 3\), wanted \(B, 4\): vx, vy, r, w"):
        REAR_DRIVE(states[:, :3], actions, 0.1)
    with pytest.raises(InputError, match=r"actions: found shape \(3, 1\)"):
        REAR_DRIVE.derivative(states, actions[:, :1])
    with pytest.raises(InputError, match="actions: found 2 rows, wanted 3, one for each state"):
        REAR_DRIVE(states, actions[:2], 0.1)
    with pytest.raises(InputError, match=r"states at index \(1, 2\): found nan"):
        REAR_DRIVE(np.where(np.arange(12).reshape(3, 4) == 6, np.nan, states), actions, 0.1)
    for wrong in (-0.1, float("nan"), float("inf")):
        with pytest.raises(InputError, match="duration"):
            REAR_DRIVE(states, actions, wrong)
