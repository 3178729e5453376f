"""Steady states: the six manoeuvres as they were measured, fixed points of the transition, and the eigenvalues."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from subgoal.dynamics import ALL_DRIVE, REAR_DRIVE, Car, Equilibrium, equilibria_of, manoeuvres, steady_state
from subgoal.runtime.errors import InputError

CARS = {"rear": REAR_DRIVE, "all": ALL_DRIVE}
MIRROR = np.array([1, -1, -1, 1])
KNOWN = [
    ("all", "straight", (0.0, 1.9), (1.90, 0.0, 0.0), -12.9),
    ("all", "left", (0.22, 1.5), (1.48, 0.01, 1.58), -12.4),
    ("all", "left drift", (0.20, 2.6), (1.07, -1.14, 2.77), -0.80),
    ("rear", "straight", (0.0, 1.9), (1.88, 0.0, 0.0), -6.2),
    ("rear", "left", (0.22, 1.5), (1.45, 0.01, 1.54), -7.7),
    ("rear", "left drift", (-0.30, 2.5), (1.28, -0.85, 2.29), 6.9),
]
"""drive, manoeuvre, (δ, w_c), (v_x, v_y, r), largest real part of the eigenvalues but for the −10 of the wheel."""

every = pytest.mark.parametrize(
    ("car", "goal"), [(car, goal) for car in CARS.values() for goal in manoeuvres(car).values()], ids=lambda x: repr(x)
)


@pytest.mark.parametrize(("drive", "name", "action", "body", "growth"), KNOWN)
def test_manoeuvres_are_the_known_ones(drive: str, name: str, action, body, growth: float) -> None:
    """To the digits that are known, ±0.0051 in the state."""
    goal = manoeuvres(CARS[drive])[name]
    np.testing.assert_array_equal(goal.action, action)
    np.testing.assert_allclose(goal.state[:3], body, atol=0.0051)
    modes = goal.eigenvalues.real[~np.isclose(goal.eigenvalues, -10.0, atol=1e-6)]
    assert len(modes) == 3
    np.testing.assert_allclose(modes.max(), growth, atol=0.005 if abs(growth) < 1 else 0.051)


@every
def test_manoeuvres_are_fixed_points_of_the_transition(car: Car, goal: Equilibrium) -> None:
    np.testing.assert_allclose(car(goal.state[None], goal.action[None], 1.0)[0], goal.state, atol=1e-8)
    assert goal.residual < 1e-10


@every
def test_small_errors_grow_and_decay_with_the_eigenvalues(car: Car, goal: Equilibrium) -> None:
    """Eigenvalues of the transition over 0.1 s, by differences of whole runs, are exp(0.1 λ)."""
    fine, shift = replace(car, step=5e-4), 1e-5 * np.eye(4)
    held = np.tile(goal.action, (4, 1))
    jacobian = ((fine(goal.state + shift, held, 0.1) - fine(goal.state - shift, held, 0.1)) / 2e-5).T
    found, wanted = np.linalg.eigvals(jacobian), np.exp(0.1 * goal.eigenvalues)
    for each in wanted:
        assert abs(found - each).min() < 2e-4 * max(1, abs(each))


def test_the_drift_is_stable_with_all_wheels_driven_and_a_saddle_with_two() -> None:
    drift = {drive: manoeuvres(car)["left drift"] for drive, car in CARS.items()}
    assert drift["all"].stable and not drift["rear"].stable
    assert (drift["rear"].eigenvalues.real > 0).sum() == 1
    assert np.degrees(drift["all"].sideslip) == pytest.approx(-47, abs=0.5)
    assert np.degrees(drift["rear"].sideslip) == pytest.approx(-33.5, abs=0.5)
    assert repr(drift["rear"]) == "Equilibrium((1.28, -0.85, 2.28, 2.50) under (-0.30, 2.50), unstable)"


@pytest.mark.parametrize("car", CARS.values(), ids=CARS)
def test_right_is_the_mirror_of_left(car: Car) -> None:
    six = manoeuvres(car)
    assert list(six) == ["stop", "straight", "left", "right", "left drift", "right drift"]
    for left, right in (("left", "right"), ("left drift", "right drift")):
        np.testing.assert_allclose(six[right].state * MIRROR, six[left].state, atol=1e-9)
        np.testing.assert_allclose(six[right].eigenvalues.real, six[left].eigenvalues.real, atol=1e-5)


def test_a_car_on_a_slippery_road_has_its_own_manoeuvres() -> None:
    slippery = replace(REAR_DRIVE, friction=0.85 * 0.45)
    six = manoeuvres(slippery)
    assert abs(six["left drift"].state - manoeuvres(REAR_DRIVE)["left drift"].state).max() > 0.05
    assert all(abs(slippery.derivative([e.state], [e.action])).max() < 1e-8 for e in six.values())


def test_all_branches_of_a_command_are_found() -> None:
    """Countersteered at 2.5 m/s the rear-driven car has the drift, a tighter saddle and a stable spin."""
    found = equilibria_of(REAR_DRIVE, (-0.30, 2.5))
    assert [each.stable for each in found] == [True, False, False]
    np.testing.assert_allclose(found[-1].state, manoeuvres(REAR_DRIVE)["left drift"].state, atol=1e-8)
    assert found[0].state[2] < -4 and found[1].state[2] > 3


def test_a_straight_command_has_branches_in_mirrored_pairs() -> None:
    found = equilibria_of(REAR_DRIVE, (0.0, 1.9))
    assert found[0].state[2] == pytest.approx(0, abs=1e-9) and found[0].stable
    states = np.array([each.state for each in found])
    assert len(states) == 5
    for state in states:
        assert abs(states - state * MIRROR).max(axis=1).min() < 1e-6


def test_a_long_run_ends_in_a_stable_state_that_was_found() -> None:
    generator = np.random.default_rng(0)
    starts = generator.normal([1, 0, 0, 2], [0.5, 0.5, 2, 0.1], size=(40, 4))
    ends = REAR_DRIVE(starts, np.tile([0.2, 2.6], (40, 1)), 60.0)
    stable = np.array([each.state for each in equilibria_of(REAR_DRIVE, (0.2, 2.6)) if each.stable])
    assert (abs(ends[:, None] - stable).max(axis=2).min(axis=1) < 1e-3).all()


def test_a_search_that_finds_nothing_says_so() -> None:
    with pytest.raises(InputError, match=r"start: found no steady state from \(-9, 9, 40, 2\).*equilibria_of"):
        steady_state(REAR_DRIVE, (0.5, 3.6), (-9.0, 9.0, 40.0, 2.0))
    with pytest.raises(InputError, match="action at index"):
        steady_state(REAR_DRIVE, (np.nan, 3.6), (1.0, 0.0, 0.0, 2.0))
    with pytest.raises(InputError, match="states: found shape"):
        steady_state(REAR_DRIVE, (0.1, 3.6), (1.0, 0.0, 2.0))
