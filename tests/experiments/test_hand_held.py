"""The simulated hand does what the cards of Figures 7-2 to 7-4 say: speed, corners, tremor, noise, turn."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import periodogram

from experiments.fig_7_4 import angles_off
from experiments.hand_held import CORNERS, FLOOR, HAND, Hand, arc, flip, hops, round_the_square, through, trembling
from experiments.hand_held_study import misses

STILL = Hand(tremor=0.0, noise=0.0, angle_noise=0.0)


def test_the_hand_goes_at_its_speed() -> None:
    steps = np.linalg.norm(np.diff(round_the_square(0, hand=STILL).positions[:, :2], axis=0), axis=1)
    np.testing.assert_allclose(steps, HAND.speed / HAND.rate, rtol=0.02)


def test_corners_are_rounded_from_8_cm_before_to_8_cm_after() -> None:
    path = through(CORNERS[:3])
    on_first = np.abs(path[:, 1] - CORNERS[1, 1]) < 1e-9
    assert path[on_first, 0].max() == pytest.approx(CORNERS[1, 0] - 0.08, abs=0.005)
    nearest = np.linalg.norm(path - CORNERS[1], axis=1).min()
    assert nearest == pytest.approx(0.08 * (np.sqrt(2) - 1), abs=1e-3)


def test_an_arc_touches_both_legs() -> None:
    points = arc(np.array([-0.08, 0.0]), np.zeros(2), np.array([0.0, -0.08]))
    np.testing.assert_allclose(points[[0, -1]], [[-0.08, 0], [0, -0.08]], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(points - [-0.08, -0.08], axis=1), 0.08, rtol=1e-12)


def test_straight_on_and_straight_back_are_not_rounded() -> None:
    for after in ((0.08, 0.0), (-0.08, 0.0)):
        points = arc(np.array([-0.08, 0.0]), np.zeros(2), np.array(after))
        np.testing.assert_array_equal(points, [[-0.08, 0], [0, 0], after])


def test_the_tremor_lies_between_8_and_12_hz_and_is_5_mm() -> None:
    shaken = trembling(20_000, np.random.default_rng(0))
    np.testing.assert_allclose(shaken.std(axis=0), 0.005, rtol=0.03)
    frequency, power = periodogram(shaken[:, 0], fs=HAND.rate)
    inside = (frequency > 7) & (frequency < 13)
    assert power[inside].sum() > 0.9 * power.sum()


def test_the_room_adds_a_millimetre_and_a_hundredth_of_a_radian() -> None:
    seen = round_the_square(3, hand=Hand(tremor=0.0)).positions - round_the_square(3, hand=STILL).positions
    np.testing.assert_allclose(seen.std(axis=0), [0.001, 0.001, 0.01], rtol=0.1)


def test_every_hop_goes_to_another_corner_and_seeds_differ() -> None:
    recording, order = hops(1, 60)
    assert len(order) == 61 and (np.diff(order) != 0).all() and set(order.tolist()) == {0, 1, 2, 3}
    assert misses(recording.positions, CORNERS).max() < 0.05
    assert hops(2, 60)[1].tolist() != order.tolist()


def test_a_flip_is_level_below_and_inverted_above_and_turns_once() -> None:
    poses = flip(0, hand=STILL).positions
    top = int(poses[:, 1].argmax())
    assert poses[top, 1] == pytest.approx(FLOOR + 1.0, abs=1e-3)
    assert poses[top, 2] == pytest.approx(np.pi, abs=0.02)
    assert poses[0].tolist() == [0, FLOOR, 0] and poses[-1, 2] == pytest.approx(2 * np.pi, abs=0.02)
    assert np.abs(poses[:, 0]).max() == pytest.approx(0.075, abs=1e-3)


def test_a_missing_subgoal_is_infinitely_far_and_angles_wrap() -> None:
    assert np.isinf(misses(np.empty((0, 3)), CORNERS)).all()
    level, inverted = angles_off(np.array([[0, 0, 6.2], [0, 1, -3.0]]))
    assert level == pytest.approx(2 * np.pi - 6.2) and inverted == pytest.approx(np.pi - 3.0)
