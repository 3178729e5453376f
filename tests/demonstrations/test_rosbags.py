"""Bags of ROS 1 and ROS 2, written here: topics, frames, clocks, twists, damage."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from subgoal.demonstrations import angular_velocities, read, read_recording
from subgoal.demonstrations.readers import format_of
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError
from tests.demonstrations.valid_bags import KINDS, START, odometry, pose, text, transforms, write_bag

STEP = 10**7
COUNT = 60
STAMPS = [START + STEP * k for k in range(COUNT)]
TIMES = np.arange(COUNT) / 100
SPIN = np.array([0.3, 0, 2.0])
MOUNT = Rotation.from_rotvec([0.5, -0.2, 0.1])
TURNS = Rotation.from_rotvec(TIMES[:, None] * SPIN) * MOUNT
PLACES = np.hstack([TIMES[:, None] * [1, 2, 3], TURNS.as_quat()])


@pytest.fixture(params=KINDS)
def bag(request, tmp_path):
    """Writes a bag of each kind."""
    return lambda topics: write_bag(tmp_path, request.param, topics)


def posed(late=0, frame="map"):
    return [(stamp + late, pose(stamp, place, frame)) for stamp, place in zip(STAMPS, PLACES, strict=True)]


def moving():
    body = TURNS.inv()
    twists = np.hstack([body.apply(np.tile([1.0, 2, 3], (COUNT, 1))), body.apply(np.tile(SPIN, (COUNT, 1)))])
    return [(s, odometry(s, place, twist)) for s, place, twist in zip(STAMPS, PLACES, twists, strict=True)]


def test_the_only_topic_of_poses_is_read(bag):
    path = bag({"/chat": [(START, text("hello"))], "/pose": posed(late=3 * STEP)})
    assert format_of(path) == "rosbag"
    recording = read_recording(path)
    assert np.array_equal(recording.positions, PLACES[:, :3])
    assert recording.times == pytest.approx(TIMES, abs=1e-12)
    assert (recording.names, recording.units, recording.time_unit) == (("x", "y", "z"), "m", "s")
    assert recording.source.notes == {}
    assert recording.source.name == path.name


@pytest.mark.parametrize("kind", ["db3", "mcap"])
def test_folders_of_ros_2_bags_are_read(tmp_path, kind):
    folder = write_bag(tmp_path, kind, {"/pose": posed()}).parent
    assert format_of(folder) == "rosbag"
    recording = read_recording(str(folder))
    assert np.array_equal(recording.positions, PLACES[:, :3])
    assert len(recording.source.checksum) == 64
    other = write_bag(tmp_path, kind, {"/pose": posed()[1:]}, name="other").parent
    assert read_recording(other).source.checksum != recording.source.checksum


@pytest.mark.parametrize("how", ["bz2", "lz4"])
def test_packed_bags_of_ros_1_are_read(tmp_path, how):
    path = write_bag(tmp_path, "bag", {"/pose": posed()}, packed=how)
    assert np.array_equal(read_recording(path).positions, PLACES[:, :3])


@pytest.mark.parametrize("kind", ["db3", "mcap"])
@pytest.mark.parametrize("how", ["message", "file"])
def test_packed_bags_of_ros_2_are_read(tmp_path, kind, how):
    folder = write_bag(tmp_path, kind, {"/pose": posed()}, packed=how).parent
    assert np.array_equal(read_recording(folder).positions, PLACES[:, :3])


def test_folders_without_metadata_are_no_bags(tmp_path):
    folder = write_bag(tmp_path, "db3", {"/pose": posed()}).parent
    (folder / "metadata.yaml").unlink()
    with pytest.raises(ReadError, match="found a folder"):
        read(folder)


def test_poses_have_quaternions_and_their_rates(bag):
    demos = read(bag({"/pose": posed()}), pose=True, every=5)
    assert demos.names == ("x", "y", "z", "qx", "qy", "qz", "qw")
    assert angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) == pytest.approx(
        np.tile(SPIN, (12, 1)), abs=1e-9
    )


def test_several_topics_are_listed_and_chosen_among(bag):
    path = bag({"/a": posed(), "/b": moving()})
    for topic in (None, "/c", 3):
        with pytest.raises(InputError, match=r"one of '/a' \(geometry_msgs/msg/PoseStamped\), '/b' \(nav_msgs"):
            read_recording(path, topic=topic)
    for topic in ("/a", "/b"):
        assert np.array_equal(read_recording(path, topic=topic).positions, PLACES[:, :3])


def test_twists_become_actions_in_the_world(bag):
    path = bag({"/odom": moving()})
    assert read_recording(path).actions is None
    assert read_recording(path, twist=True, scale=2).actions == pytest.approx(np.tile([2.0, 4, 6], (COUNT, 1)))
    demos = read(path, twist=True, pose=True)
    assert demos.actions[:, :3] == pytest.approx(np.tile([1.0, 2, 3], (COUNT, 1)))
    assert angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]) == pytest.approx(np.tile(SPIN, (COUNT, 1)))
    assert read(path, twist=True, plane="yx").actions == pytest.approx(np.tile([2.0, 1, -2], (COUNT, 1)))
    assert read(path, twist=True, every=3).n_observations == 20
    slower = read(path, twist=True, rate=5)
    assert slower.actions[:, :3] == pytest.approx(np.tile([1.0, 2, 3], (slower.n_observations, 1)))


def test_other_messages_have_no_twist(bag):
    with pytest.raises(InputError, match="twist: found True for geometry_msgs/msg/PoseStamped"):
        read_recording(bag({"/pose": posed()}), twist=True)


def test_the_child_frame_of_transforms_is_chosen(bag):
    other = PLACES + np.array([9, 0, 0, 0, 0, 0, 0])
    told = [
        (s, transforms(s, {"base": place, "/arm": there}))
        for s, place, there in zip(STAMPS, PLACES, other, strict=True)
    ]
    path = bag({"/tf": told})
    for frame in (None, "leg", 3):
        with pytest.raises(InputError, match=r"frame at .*one of 'arm', 'base'"):
            read_recording(path, frame=frame)
    assert np.array_equal(read_recording(path, frame="base").positions, PLACES[:, :3])
    for frame in ("arm", "/arm"):
        assert np.array_equal(read_recording(path, frame=frame).positions, other[:, :3])


def test_the_only_frame_of_transforms_is_read(bag):
    path = bag({"/tf": [(s, transforms(s, {"base": place})) for s, place in zip(STAMPS, PLACES, strict=True)]})
    assert np.array_equal(read_recording(path).positions, PLACES[:, :3])


def test_frames_are_of_transforms_alone(bag):
    with pytest.raises(InputError, match="frame: found 'base', wanted None"):
        read_recording(bag({"/pose": posed()}), frame="base")


def test_poses_in_several_frames_are_refused(bag):
    with pytest.raises(ReadError, match="frames 'map', 'odom'"):
        read_recording(bag({"/pose": [*posed()[:5], *posed(frame="odom")[5:]]}))


def test_times_of_receipt_stand_in_for_stamps_that_are_not_set(bag):
    told = [(s, pose(0 if k == 7 else s + 5, place)) for k, (s, place) in enumerate(zip(STAMPS, PLACES, strict=True))]
    recording = read_recording(bag({"/pose": told}))
    assert recording.times == pytest.approx(TIMES, abs=1e-12)
    assert recording.source.notes == {"times of receipt taken for stamps that are not set": COUNT}


def test_stamps_that_go_back_are_treated_as_the_clock_says(bag):
    told = posed()
    told[3], told[4] = (told[3][0], told[4][1]), (told[4][0], told[3][1])
    path = bag({"/pose": told})
    with pytest.raises(ReadError, match=r"data row 5.*do not go back"):
        read_recording(path)
    assert np.array_equal(read_recording(path, clock="sort").positions, PLACES[:, :3])


def test_a_quaternion_without_length_is_refused(bag):
    path = bag({"/pose": [*posed()[:3], (STAMPS[3], pose(STAMPS[3], np.zeros(7)))]})
    with pytest.raises(ReadError, match="data row 4"):
        read_recording(path, plane="xy")
    assert len(read_recording(path).times) == 4


def test_places_that_are_no_numbers_are_dropped_or_refused(bag):
    nothing = PLACES[3] * [np.nan, 1, 1, 1, 1, 1, 1]
    recording = read_recording(bag({"/pose": [*posed()[:3], (STAMPS[3], pose(STAMPS[3], nothing))]}))
    assert recording.source.notes == {"rows without a position dropped": 1}


def test_bags_without_poses_are_refused(bag):
    with pytest.raises(ReadError, match="found topics '/chat', wanted messages of a kind that holds poses"):
        read_recording(bag({"/chat": [(START, text("hello"))]}))


def test_empty_bags_are_refused(bag):
    with pytest.raises(ReadError, match=r"found .*topic"):
        read_recording(bag({}))


def test_transforms_of_nothing_are_refused(bag):
    with pytest.raises(ReadError, match="without a transform"):
        read_recording(bag({"/tf": [(START, transforms(START, {}))]}))


def test_torn_bags_are_refused(bag):
    path = bag({"/pose": posed()})
    content = path.read_bytes()
    for keep in (0.2, 0.5, 0.9):
        path.write_bytes(content[: int(keep * len(content))])
        with pytest.raises(ReadError):
            read_recording(path)


def test_folders_with_damaged_metadata_are_refused(tmp_path):
    folder = write_bag(tmp_path, "mcap", {"/pose": posed()}).parent
    for content in ("", "a: [", "rosbag2_bagfile_information: {}", "\0"):
        (folder / "metadata.yaml").write_text(content)
        with pytest.raises(ReadError, match="wanted a bag of ROS"):
            read_recording(folder)


def test_rosbags_missing_is_said_by_name(tmp_path, monkeypatch):
    path = write_bag(tmp_path, "bag", {"/pose": posed()})
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingExtraError, match=r"rosbags is not installed.*subgoal\[ros\]"):
        read_recording(path)
