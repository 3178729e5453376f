"""The car against the vehicle models of CommonRoad (Althoff and Würsching), which share nothing with it but Newton."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from vehiclemodels.parameters_vehicle2 import parameters_vehicle2
from vehiclemodels.utils import tire_model
from vehiclemodels.vehicle_dynamics_st import vehicle_dynamics_st
from vehiclemodels.vehicle_dynamics_std import vehicle_dynamics_std

from subgoal._kernels.car import grip
from subgoal.dynamics import Car

SHIFTS = ("p_hx1", "p_vx1", "p_hy1", "p_vy1", "p_hy3", "p_vy3", "r_hx1", "r_hy1", "r_vy1", "r_vy3", "p_ex1", "p_ey1")
"""What the tyres of CommonRoad have beyond a magic formula of three numbers."""


def reference(*, weights: bool = True) -> Any:
    """The BMW 320i on tyres that are the same lengthwise as across; ``weights``: with their law of combined slip."""
    parameters = parameters_vehicle2()
    tyre = parameters.tire
    for name in SHIFTS if weights else (*SHIFTS, "r_bx1", "r_by1"):
        setattr(tyre, name, 0.0)
    tyre.p_cx1, tyre.p_dx1, tyre.p_kx1 = tyre.p_cy1, tyre.p_dy1, -tyre.p_ky1
    return parameters


def ours(parameters: Any, **fields: Any) -> Car:
    """A car with the mass, axles and cornering stiffness μ B C of theirs."""
    tyre = parameters.tire
    return Car(
        mass=parameters.m, inertia=parameters.I_z, front=parameters.a, rear=parameters.b, friction=tyre.p_dy1,
        stiffness=-tyre.p_ky1 / (tyre.p_dy1 * tyre.p_cy1), shape=tyre.p_cy1, rolling=0.0, smoothing=0.05,
        step=5e-5, **fields,
    )  # fmt: skip


@pytest.mark.parametrize("slip", [0.01, 0.05, 0.2, 1.0])
def test_forces_in_pure_slip_are_theirs(slip: float) -> None:
    parameters = reference(weights=False)
    build, tyre = ours(parameters)._build, parameters.tire
    np.testing.assert_allclose(grip(slip, 0.0, build)[0], tire_model.formula_longitudinal(slip, 0, 1, tyre), rtol=1e-12)
    np.testing.assert_allclose(grip(0.0, slip, build)[1], tire_model.formula_lateral(slip, 0, 1, tyre)[0], rtol=1e-12)


@pytest.mark.parametrize("across", [0.03, 0.08, 0.15, 0.3])
@pytest.mark.parametrize("along", [0.0, 0.03, 0.08, 0.15, 0.3, 0.6])
def test_forces_in_combined_slip_are_near_a_measured_law(along: float, across: float) -> None:
    """Their weights were fitted to a tyre, ours is a friction circle: lengthwise 0.04 F_z, in size 0.13 F_z apart."""
    parameters = reference()
    tyre = parameters.tire
    pure, (pure_across, mu) = (
        tire_model.formula_longitudinal(along, 0, 1, tyre),
        tire_model.formula_lateral(across, 0, 1, tyre),
    )
    x = tire_model.formula_longitudinal_comb(along, across, pure, tyre)
    y = tire_model.formula_lateral_comb(along, across, 0, mu, 1, pure_across, tyre)
    told = grip(along, across, ours(parameters)._build)
    assert abs(told[0] - x) < 0.045
    assert abs(np.hypot(*told) - np.hypot(x, y)) < 0.13


@pytest.mark.parametrize("speed", [8.0, 20.0])
def test_a_step_steer_is_that_of_the_linear_single_track_model(speed: float) -> None:
    """0.001 rad for 1.5 s: yaw rate and sideslip within 5e-4 of their largest values."""
    parameters, times, angle = reference(), np.linspace(0, 1.5, 31), 0.001
    theirs = solve_ivp(
        lambda _, x: vehicle_dynamics_st(list(x), [0.0, 0.0], parameters), (0, 1.5), [0, 0, angle, speed, 0, 0, 0],
        t_eval=times, rtol=1e-9, atol=1e-12,
    ).y  # fmt: skip
    car, states = ours(parameters, drive="all"), [np.array([speed, 0.0, 0.0, speed])]
    for _ in times[1:]:
        states.append(car(states[-1][None], [[angle, speed]], 0.05)[0])
    ran = np.array(states)
    for found, wanted in ((ran[:, 2], theirs[5]), (np.arctan2(ran[:, 1], ran[:, 0]), theirs[6])):
        np.testing.assert_allclose(found, wanted, atol=5e-4 * abs(wanted).max())
    assert abs(theirs[6]).max() > 1e-4


@pytest.mark.parametrize(
    ("speed", "sideslip", "rate", "angle"),
    [(15.0, -0.35, 0.8, 0.05), (15.0, -0.5, 1.2, -0.2), (15.0, 0.0, 0.0, 0.15), (10.0, 0.3, -1.0, 0.0)],
)
def test_a_coasting_slide_is_that_of_the_drift_model(speed: float, sideslip: float, rate: float, angle: float) -> None:
    """Tyres far beyond their peak, wheels free: yaw rate, sideslip (to 1 rad) and speed within 3 % over 0.8 s.

    They take the magic formula of the slip angle, we of its tangent, and their wheels have inertia: hence no nearer.
    """
    parameters, times = reference(weights=False), np.linspace(0, 0.8, 9)
    vx, vy = speed * np.cos(sideslip), speed * np.sin(sideslip)
    at_front = vx * np.cos(angle) + (vy + parameters.a * rate) * np.sin(angle)
    begin = [0, 0, angle, speed, 0, rate, sideslip, at_front / parameters.R_w, vx / parameters.R_w]
    theirs = solve_ivp(
        lambda _, x: vehicle_dynamics_std(list(x), [0.0, 0.0], parameters), (0, 0.8), begin,
        t_eval=times, rtol=1e-8, atol=1e-10, method="LSODA",
    ).y  # fmt: skip
    car, states = ours(parameters, drive="rear", lag=0.002), [np.array([vx, vy, rate, vx])]
    for _ in times[1:]:
        state = states[-1][None]
        for _ in range(100):
            state = car(state, [[angle, state[0, 0]]], 0.001)
        states.append(state[0])
    ran = np.array(states)
    sizes = np.hypot(ran[:, 0], ran[:, 1])
    for found, wanted in ((ran[:, 2], theirs[5]), (np.arctan2(ran[:, 1], ran[:, 0]), theirs[6]), (sizes, theirs[3])):
        np.testing.assert_allclose(found, wanted, atol=0.03 * abs(wanted).max())
