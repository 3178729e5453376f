"""Angles that wrap: velocities and interpolation go the shorter way round."""

from __future__ import annotations

import numpy as np
import pytest

from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import InputError

TURN = 2 * np.pi
RATE = 2.0


def turning(low: float) -> Recording:
    """A position and an angle that turns at 2 rad/s, recorded in [low, low + 2π)."""
    times = np.arange(200) * 0.05
    angle = (RATE * times - low) % TURN + low
    return Recording(np.column_stack([times, angle]), times, np.array([0, 200]), ("x", "heading"))


@pytest.mark.parametrize("low", [0.0, -np.pi])
@pytest.mark.parametrize("options", [{}, {"rate": 7.0}, {"velocity": "savgol"}, {"every": 3}])
def test_velocity_of_a_turning_angle_is_its_rate(low: float, options: dict) -> None:
    recording = turning(low)
    demos = demonstrate(recording, period=[np.inf, TURN], **options)
    np.testing.assert_allclose(demos.actions[:, 1], RATE, rtol=1e-9)
    np.testing.assert_allclose(demos.actions[:, 0], 1.0, rtol=1e-9)
    for places in (demos.states, demos.final_states):
        assert (places[:, 1] >= low - 1e-9).all()
        assert (places[:, 1] <= low + TURN + 1e-9).all()
    rows = np.isin(recording.times, demos.times)
    if "rate" not in options:
        np.testing.assert_allclose(demos.states, recording.positions[rows], atol=1e-9)


def test_without_a_period_nothing_wraps() -> None:
    assert np.abs(demonstrate(turning(0.0)).actions[:, 1]).max() > 10 * RATE


def test_each_trajectory_is_unwrapped_by_itself() -> None:
    angles = np.array([3.0, -3.0, -2.9, 3.0, 3.1])
    recording = Recording(angles[:, None], np.array([0.0, 1, 2, 0, 1]), np.array([0, 3, 5]), ("a",))
    demos = demonstrate(recording, period=[TURN], velocity="forward", window=1)
    np.testing.assert_allclose(demos.actions[:, 0], [TURN - 6, 0.1, 0.1], atol=1e-12)


@pytest.mark.parametrize("period", [[TURN], [np.nan, 1.0], [1.0, 0.0]])
def test_bad_periods_are_refused(period: list[float]) -> None:
    with pytest.raises(InputError):
        demonstrate(turning(0.0), period=period)


def test_thinning_goes_round_too() -> None:
    angles = np.array([3.1, -3.1, 0.0])
    recording = Recording(angles[:, None], np.arange(3.0), np.array([0, 3]), ("a",))
    assert demonstrate(recording, thin=0.2, period=[TURN]).n_observations == 2
