"""Orientations in recordings: signs, rates, slerp, distances, angles in a plane."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from subgoal.demonstrations import (
    Recording,
    angular_velocities,
    continue_quaternions,
    demonstrate,
    pose_metric,
    resample,
    split_at_gaps,
    starting_in,
    towards_pose,
)
from subgoal.demonstrations.poses import plane_angles, quaternion_rates, slerped
from subgoal.runtime.errors import InputError

SPIN = np.array([1.0, -2.0, 0.5])
"""Angular velocity, rad/s."""
SPEED = np.array([0.3, 0.0, -1.0])


def turns(times, spin=SPIN, start=None):
    """(m, 4) quaternions that turn with ``spin``, as they come: of any sign."""
    start = Rotation.from_rotvec([0.4, 0.3, -2.0]) if start is None else start
    return (Rotation.from_rotvec(times[:, None] * spin) * start).as_quat()


def spinning(times, offset=None, flips=None):
    offset = [0, len(times)] if offset is None else offset
    quaternions = turns(times) * (1 if flips is None else flips[:, None])
    positions = np.hstack([times[:, None] * SPEED, continue_quaternions(quaternions, offset)])
    return Recording(positions, times, offset, (), quaternion=3)


@pytest.fixture
def times():
    return np.sort(np.random.default_rng(0).uniform(0, 9, 300))


@pytest.mark.parametrize(
    "how",
    [{}, {"every": 5}, {"window": 40}, {"velocity": "forward"}, {"rate": 20}, {"rate": 50, "velocity": "savgol"}],
    ids=str,
)
def test_a_known_rotation_has_its_angular_velocity(times, how):
    demos = demonstrate(spinning(times), **how)
    assert np.abs(angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) - SPIN).max() < 1e-9
    assert np.abs(demos.actions[:, :3] - SPEED).max() < 1e-9


def test_a_window_may_hold_more_than_half_a_turn():
    recording = spinning(np.arange(200) / 50)
    demos = demonstrate(recording, window=180)
    assert np.abs(angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) - SPIN).max() < 1e-9


def test_poses_too_few_for_the_window_are_dropped_and_counted():
    recording = spinning(np.arange(20) / 50, offset=[0, 1, 4, 20])
    demos = demonstrate(recording, velocity="savgol")
    assert demos.trajectory_names == ("T2",)
    assert demos.source.notes == {
        "trajectories of one sample dropped": 1, "trajectories too short for the window dropped": 1,
    }  # fmt: skip
    assert resample(recording, 25).quaternion == 3


def test_rates_of_quaternions_are_their_derivatives(times):
    quaternions = continue_quaternions(turns(times), [0, len(times)])
    step = 1e-6
    for sign in (1, -1):
        rates = quaternion_rates(sign * quaternions, np.tile(SPIN, (len(times), 1)))
        after = continue_quaternions(turns(times + step), [0, len(times)])
        before = continue_quaternions(turns(times - step), [0, len(times)])
        after, before = (each * np.sign((each * quaternions).sum(axis=1, keepdims=True)) for each in (after, before))
        assert rates == pytest.approx(sign * (after - before) / (2 * step), abs=1e-8)
    assert np.linalg.norm(rates, axis=1) == pytest.approx(np.linalg.norm(SPIN) / 2)


def test_what_does_not_turn_has_no_rate():
    still = continue_quaternions(np.tile([0.1, 0.2, 0.3, 0.9], (5, 1)), [0, 5])
    assert not quaternion_rates(still, np.zeros((5, 3))).any()
    assert not angular_velocities(still, np.zeros((5, 4))).any()


def test_signs_of_quaternions_change_nothing(times):
    flips = np.random.default_rng(1).choice([-1.0, 1.0], len(times))
    plain, flipped = (demonstrate(spinning(times, flips=signs), rate=20) for signs in (None, flips))
    assert np.array_equal(plain.states, flipped.states)
    assert np.array_equal(plain.actions, flipped.actions)


def test_signs_continue_within_trajectories_which_begin_near_the_first():
    half = np.linspace(0, 4 * np.pi, 40)
    given = turns(half, np.array([0, 0, 1.0]), Rotation.identity())
    made = continue_quaternions(np.vstack([given, -given]), [0, 40, 80])
    assert made[0].tolist() == [0, 0, 0, 1]
    assert (made[1:40] * made[:39]).sum(axis=1).min() > 0.9
    assert made[20] @ made[0] < 0  # one turn later the same rotation is on the other side of the sphere
    assert np.array_equal(made[40:], made[:40])


def test_trajectories_that_begin_at_nearly_one_rotation_are_near_each_other():
    angles = np.radians([170, 190])
    made = continue_quaternions(turns(angles, np.array([0, 0, 1.0]), Rotation.identity()), [0, 1, 2])
    assert made[0] @ made[1] == pytest.approx(np.cos(np.radians(10)))


def test_quaternions_are_normalised():
    made = continue_quaternions(3 * turns(np.arange(9.0)), [0, 9])
    assert np.linalg.norm(made, axis=1) == pytest.approx(np.ones(9), abs=1e-15)


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        (np.eye(4)[:, :3], "3 columns"),
        (np.diag([1, 1, 0, 1]), "row 2: found .*wanted a rotation"),
        (1e-7 * np.eye(4), "row 0: found .*wanted a rotation"),
        (1e200 * np.eye(4), "row 0: found .*wanted a rotation"),
        (np.full((2, 4), np.nan), "finite"),
    ],
)
def test_what_is_no_rotation_is_refused(bad, message):
    with pytest.raises(InputError, match=message):
        continue_quaternions(bad, [0, len(bad)])


def test_resampling_is_on_the_shortest_way_at_even_speed(times):
    recording = spinning(times)
    made = resample(recording, 40)
    apart = Rotation.from_quat(made.positions[:, 3:]) * Rotation.from_quat(turns(made.times)).inv()
    assert apart.magnitude().max() < 1e-12
    assert (made.positions[1:, 3:] * made.positions[:-1, 3:]).sum(axis=1).min() > 0.99
    assert made.positions[-1] == pytest.approx(recording.positions[-1])


def test_slerp_half_way_is_half_the_turn():
    ends = continue_quaternions(turns(np.array([0.0, 1.0]), np.array([0, 1.2, 0]), Rotation.identity()), [0, 2])
    made = slerped(ends, np.array([0.0, 1.0]), np.array([0.25, 0.5]))
    assert Rotation.from_quat(made).as_rotvec() == pytest.approx(np.array([[0, 0.3, 0], [0, 0.6, 0]]))


def test_200_samples_a_second_become_20():
    fine = np.arange(1001) / 200
    for how in ({"rate": 20}, {"every": 10}):
        demos = demonstrate(spinning(fine), **how)
        assert demos.n_observations == 101
        assert np.diff(demos.times) == pytest.approx(np.full(100, 0.05))
        assert demos.states[:, 3:] == pytest.approx(spinning(fine[::10]).positions[:, 3:])


def test_recordings_stay_poses_when_they_are_cut_and_chosen(times):
    recording = spinning(np.where(times > 4, times + 10, times), offset=[0, 100, 300])
    cut = split_at_gaps(recording, 5)
    chosen = starting_in(cut, [-np.inf] * 7, [np.inf, np.inf, -4, *[np.inf] * 4])
    assert (cut.n_trajectories, chosen.n_trajectories) == (3, 1)
    assert chosen.quaternion == 3
    demos = demonstrate(chosen)
    assert np.abs(angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) - SPIN).max() < 1e-9


@pytest.mark.parametrize(
    ("at", "change", "message"),
    [
        (4, 1, "a column from 0 to 3"),
        (True, 1, "a column from 0 to 3"),
        (3, 1.001, r"norm 1\.001"),
        (3, [[1], [-1]] * 150, "row 1.*other sign"),
    ],
)
def test_recordings_with_other_columns_are_refused(times, at, change, message):
    recording = spinning(times)
    positions = np.array(recording.positions)
    positions[:, 3:] *= change
    with pytest.raises(InputError, match=message):
        Recording(positions, times, [0, len(times)], (), quaternion=at)


def test_recorded_periods_are_checked_and_used():
    times = np.arange(50) / 10
    angles = (times + np.pi) % (2 * np.pi) - np.pi
    recording = Recording(np.stack([times, angles], axis=1), times, [0, 50], (), period=(np.inf, 2 * np.pi))
    demos = demonstrate(recording, rate=7)
    assert demos.actions == pytest.approx(np.ones((len(demos.times), 2)))
    assert np.abs(demos.states[:, 1]).max() <= np.pi
    for wrong in ((1,), (0, 1), (np.nan, 1)):
        with pytest.raises(InputError, match="period"):
            Recording(recording.positions, times, [0, 50], (), period=wrong)


def test_distances_count_a_radian_as_the_length():
    angles = np.array([0.1, np.radians(56), np.pi])
    ends = turns(angles, np.array([0, 0, 1.0]), Rotation.identity())
    poses = np.hstack([np.zeros((3, 3)), ends])
    far = pose_metric(0.4).distance(np.array([0, 0, 0, 0, 0, 0, 1.0]), poses)
    assert far == pytest.approx(1.6 * np.sin(angles / 4))
    assert far / (0.4 * angles) == pytest.approx([1, 0.99, 0.9], abs=2e-3)
    planar = pose_metric(0.4, planar=True)
    assert planar.distance(np.array([0, 0, 3.0]), np.array([3, 0, -3.0])) == pytest.approx(
        np.hypot(3, 0.4 * (2 * np.pi - 6))
    )
    with pytest.raises(InputError, match="length"):
        pose_metric(0)


def test_the_straight_way_turns_about_the_axis_that_leads_there():
    here, there = turns(np.array([0.0])), turns(np.array([1.0]), np.array([0, 0.9, 0]))
    state, goal = np.hstack([[[1, 2, 3.0]], here]), np.hstack([[[1, 2, 4.0]], there])
    for sign in (1, -1):
        way = towards_pose(state[:, None], goal[None] * np.array([1, 1, 1, *[sign] * 4]))
        assert way.shape == (1, 1, 7)
        assert way[0, 0, :3].tolist() == [0, 0, 1]
        assert angular_velocities(here, way[0, :, 3:]) == pytest.approx(np.array([[0, 0.9, 0]]))


def test_poses_are_compared_with_the_straight_way():
    from subgoal import action_comparison, epsilon_net

    demos = demonstrate(spinning(np.arange(40) / 30))
    places = epsilon_net(demos, 0.2, metric=pose_metric(0.5))
    how = {"confidence": 5, "compare": "direction"}
    ahead = places.metric.distance(demos.states[0], places.points) > 0.1
    straight = action_comparison(demos, places, controller=towards_pose, **how).rows(0, 1)[0, ahead]
    chords = action_comparison(demos, places, **how).rows(0, 1)[0, ahead]
    assert np.ptp(straight) < 1e-9  # every place on the way is straight ahead
    assert np.ptp(chords) > 0.5


@pytest.mark.parametrize(("plane", "axis"), [("xy", 2), ("yz", 0), ("zx", 1)])
def test_angles_in_a_plane_are_those_about_its_normal(plane, axis):
    angles = np.linspace(0, 4 * np.pi, 90)
    normal = np.eye(3)[axis]
    aside = Rotation.from_rotvec(0.5 * np.roll(normal, 1))
    quaternions = (Rotation.from_rotvec(angles[:, None] * normal) * aside).as_quat()
    found, tilt = plane_angles(quaternions, np.array([0, 90]), plane)
    assert found == pytest.approx(angles, abs=1e-12)
    assert tilt == pytest.approx(np.full(90, 0.5))
    assert plane_angles(quaternions, np.array([0, 90]), plane[::-1])[0] == pytest.approx(-angles, abs=1e-12)
    flipped = quaternions * np.where(np.arange(90) % 3 == 1, -1, 1)[:, None]
    assert plane_angles(flipped, np.array([0, 90]), plane)[0][1:] == pytest.approx(found[1:], abs=1e-12)


def test_angles_begin_anew_in_each_trajectory():
    quaternions = turns(np.array([0, 1, 2, 3, 4, 0.0]), np.array([0, 0, 1.0]), Rotation.identity())
    found, _ = plane_angles(quaternions, np.array([0, 5, 6]), "xy")
    assert found == pytest.approx([0, 1, 2, 3, 4, 0])
