"""Poses in text: TUM and EuRoC files with quaternions and in a plane."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from subgoal.demonstrations import angular_velocities, demonstrate, read, read_recording
from subgoal.runtime.errors import InputError, ReadError
from tests.demonstrations.valid_files import EUROC, TUM

HEAD = EUROC.splitlines()[0]


@pytest.fixture
def file(tmp_path):
    def save(text, name="file.csv"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return save


@pytest.fixture(params=["tum", "euroc"])
def poses(request, file):
    """Writes positions (m, 3), quaternions (m, 4) and nanoseconds in the format."""

    def save(stamps, places, quaternions):
        lines = []
        for stamp, place, (x, y, z, w) in zip(stamps, places, quaternions, strict=True):
            if request.param == "tum":
                lines.append(" ".join(map(repr, [stamp / 1e9, *map(float, (*place, x, y, z, w))])))
            else:
                lines.append(",".join(map(repr, [stamp, *map(float, (*place, w, x, y, z))])))
        head = "" if request.param == "tum" else HEAD + "\n"
        return file(head + "\n".join(lines) + "\n", "poses.txt" if request.param == "tum" else "poses.csv")

    return save


@pytest.fixture
def roll(poses):
    """A file of one and a half turns about x at 2 rad/s in a body that is mounted askew, 200 times a second."""
    times = np.arange(900) / 200
    quaternions = (Rotation.from_rotvec(times[:, None] * [2, 0, 0]) * Rotation.from_rotvec([0, 0, 0.3])).as_quat()
    quaternions[100:] *= -1
    quaternions *= 1.0005
    quaternions[::9] *= 2
    places = np.stack([0 * times, times, 3 - times], axis=1)
    return poses([10**9 + 5_000_000 * k for k in range(900)], places, quaternions)


def test_by_default_there_are_positions_alone(roll):
    recording = read_recording(roll)
    assert (recording.positions.shape, recording.quaternion, recording.period) == ((900, 3), None, ())
    assert recording.source.notes == {}


def test_quaternions_come_normalised_and_continuous(roll):
    recording = read_recording(roll, pose=True, scale=2, units="ft")
    assert recording.names[3:] in (("qx", "qy", "qz", "qw"), ("q_RS_x", "q_RS_y", "q_RS_z", "q_RS_w"))
    assert recording.positions[100, :3] == pytest.approx([0, 1, 5])
    assert recording.units == "ft"
    assert recording.source.notes == {"quaternions normalised": 100, "quaternions whose sign jumped": 1}
    demos = demonstrate(recording, rate=20)
    assert angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) == pytest.approx(
        np.tile([2.0, 0, 0], (len(demos.times), 1)), abs=1e-6
    )


def test_poses_in_a_plane_turn_and_wrap(roll):
    demos = read(roll, plane="yz", rate=20)
    assert demos.names[2] == "angle"
    assert np.diff(demos.times) == pytest.approx(np.full(len(demos.times) - 1, 0.05), abs=1e-2)
    assert demos.actions == pytest.approx(np.tile([1, -1, 2.0], (len(demos.times), 1)), abs=1e-4)
    assert np.ptp(demos.states[:, 2]) <= 2 * np.pi
    assert np.cos(demos.states[:, 2]) == pytest.approx(np.cos(2 * demos.times), abs=1e-4)
    assert "poses tilted out of the plane by over 45 degrees" not in demos.source.notes
    assert read(roll, plane="zy", rate=20).actions == pytest.approx(
        np.tile([-1, 1, -2.0], (len(demos.times), 1)), abs=1e-4
    )


def test_recordings_of_a_plane_know_that_the_angle_wraps(roll):
    recording = read_recording(roll, plane="yz")
    assert recording.period == (np.inf, np.inf, 2 * np.pi)
    assert recording.positions[-1, 2] == pytest.approx(2 * 899 / 200, abs=1e-4)


def test_poses_out_of_the_plane_are_counted(poses):
    tilts = np.array([0.1, 0.7, 0.9, 1.4])
    path = poses(
        [10**9 * k for k in range(1, 5)], np.zeros((4, 3)), Rotation.from_rotvec(tilts[:, None] * [0, 1, 0]).as_quat()
    )
    notes = read_recording(path, plane="xy").source.notes
    assert notes == {"poses tilted out of the plane by over 45 degrees": 2}


def test_a_pose_upside_down_to_the_plane_is_refused(poses):
    path = poses([10**9, 2 * 10**9], np.zeros((2, 3)), [[0, 0, 0, 1], [0, 1, 0, 0]])
    with pytest.raises(ReadError, match="1 s: found a pose upside down to the plane xy"):
        read_recording(path, plane="xy")
    assert read_recording(path, plane="zx").positions[:, 2] == pytest.approx([0, np.pi])


def test_a_quaternion_without_length_is_refused_where_it_is_needed(poses):
    path = poses([10**9, 2 * 10**9], np.zeros((2, 3)), [[0, 0, 0, 1], [0, 0, 0, 0]])
    with pytest.raises(ReadError, match=r"data row 2.*found the quaternion \[0.0, 0.0, 0.0, 0.0\]"):
        read_recording(path, pose=True)
    assert len(read_recording(path).times) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"pose": 1}, "pose: found 1"),
        ({"plane": "xx"}, "plane: found 'xx'"),
        ({"plane": "xyz"}, "plane: found 'xyz'"),
        ({"plane": "ab"}, "plane: found 'ab'"),
        ({"plane": 3}, "plane: found 3"),
        ({"plane": "xy", "pose": True}, "'xy' beside pose="),
        ({"pose": True, "scale": 0}, "scale"),
        ({"pose": True, "clock": "guess"}, "clock"),
    ],
)
def test_options_that_are_none_are_refused(roll, options, message):
    with pytest.raises(InputError, match=message):
        read_recording(roll, **options)


def test_columns_of_tum_are_chosen_or_poses_are(file):
    path = file(TUM, "tum.txt")
    assert read_recording(path, position=["tz", "qw"]).positions[0].tolist() == [0, 1]
    with pytest.raises(InputError, match="none beside pose= and plane="):
        read_recording(path, position=["tz", "qw"], pose=True)


def test_euroc_stamps_are_whole_nanoseconds(file):
    recording = read_recording(file(EUROC))
    assert recording.times == pytest.approx(np.arange(12) * 0.005, abs=1e-12)
    assert recording.names == ("p_RS_R_x", "p_RS_R_y", "p_RS_R_z")
    assert recording.positions[3].tolist() == [0.3, -0.6, 0.5]
    assert (recording.units, recording.time_unit) == ("m", "s")


def test_euroc_quaternions_begin_with_w(file):
    recording = read_recording(file(EUROC), pose=True)
    assert Rotation.from_quat(recording.positions[:, 3:]).as_rotvec()[:, 0] == pytest.approx(
        np.arange(12) / 10, abs=1e-5
    )


def test_euroc_positions_alone_are_read(file):
    text = "\n".join(",".join(line.split(",")[:4]) for line in EUROC.splitlines())
    assert read_recording(file(text)).positions.shape == (12, 3)
    with pytest.raises(ReadError, match="q_x"):
        read_recording(file(text), pose=True)


def test_further_columns_of_euroc_are_left_alone(file):
    lines = EUROC.splitlines()
    text = "\n".join([lines[0] + ", v_RS_R_x [m s^-1]", *(line + ",7" for line in lines[1:])])
    assert read_recording(file(text), pose=True).positions.shape == (12, 7)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("#timestamp [ns]", "#time", "timestamp"),
        ("p_RS_R_y", "p_RS_R_x", "p_x"),
        ("p_RS_R_y", "r_RS_R_y", "p_y"),
        (",0.5,", ",half,", "p_RS_R_z.*data row 1.*'half'"),
        ("1403636580843555648", "1403636580828555648", "times that do not go back"),
        ("1403636580843555648", "1e400", "finite"),
    ],
)
def test_damaged_euroc_files_are_refused(file, old, new, message):
    with pytest.raises(ReadError, match=message):
        read_recording(file(EUROC.replace(old, new, 1)), format="euroc")


def test_euroc_rows_without_a_value_are_dropped_and_counted(file):
    recording = read_recording(file(EUROC.replace(",-0.4,", ",,")), pose=True)
    assert recording.source.notes == {"rows without a position dropped": 1}
    assert len(recording.times) == 11
