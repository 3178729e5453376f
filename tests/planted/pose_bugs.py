"""Small wrongs in poses, and in the files and bags they come from."""

from __future__ import annotations

from tests.planted.bug import Bug

POSES, PREPARE, SAMPLES = "demonstrations/poses.py", "demonstrations/prepare.py", "demonstrations/recordings.py"
READER, BAG = "demonstrations/readers/poses.py", "demonstrations/readers/rosbag.py"
EUROC, MESSAGES = "demonstrations/readers/euroc.py", "demonstrations/readers/ros_messages.py"
OF_POSES, OF_FILES = "demonstrations/test_poses.py::test_", "demonstrations/test_pose_readers.py::test_"
OF_BAGS = "demonstrations/test_rosbags.py::test_"

POSE_BUGS = [
    Bug("turns of the body for turns of the world", POSES, "rotations[1:] * rotations[:-1].inv()",
        "rotations[:-1].inv() * rotations[1:]", OF_POSES + "a_known_rotation_has_its_angular_velocity"),
    Bug("quaternions turn at the whole rate", POSES, "np.sin(QUARTER / 2) - quaternions) / 2",
        "np.sin(QUARTER / 2) - quaternions)", OF_POSES + "rates_of_quaternions_are_their_derivatives"),
    Bug("rates are differences of quaternions", PREPARE, "if recording.quaternion is not None:", "if False:",
        OF_POSES + "a_known_rotation_has_its_angular_velocity"),
    Bug("quaternions are interpolated as numbers", SAMPLES, "if four is not None:", "if False:",
        OF_POSES + "resampling_is_on_the_shortest_way_at_even_speed"),
    Bug("signs are those of the file", POSES, "signs[a] * np.cumprod(steps[a : b - 1])", "signs[a]",
        OF_POSES + "signs_continue_within_trajectories_which_begin_near_the_first"),
    Bug("signs of later trajectories are their own", POSES, "-1.0 if unit[a] @ unit[0] < 0 else 1.0", "1.0",
        OF_POSES + "trajectories_that_begin_at_nearly_one_rotation_are_near_each_other"),
    Bug("a radian of a quaternion counts half", POSES, "(2 * length,) * 4", "(length,) * 4",
        OF_POSES + "distances_count_a_radian_as_the_length"),
    Bug("angles are half the turn", POSES, "sign * 2 * np.arctan2", "sign * np.arctan2",
        OF_POSES + "angles_in_a_plane_are_those_about_its_normal"),
    Bug("every plane turns one way", POSES, "1 if (second - first) % 3 == 1 else -1", "1",
        OF_POSES + "angles_in_a_plane_are_those_about_its_normal"),
    Bug("a recording's angles do not wrap", PREPARE, "period if period is not None else recording.period or None",
        "period", OF_FILES + "poses_in_a_plane_turn_and_wrap"),
    Bug("quaternions without length pass", READER, "if short.any():", "if False:",
        OF_FILES + "a_quaternion_without_length_is_refused_where_it_is_needed"),
    Bug("lengths are not scaled", READER, "recording.positions[:, :3] * how.scale", "recording.positions[:, :3]",
        OF_FILES + "quaternions_come_normalised_and_continuous"),
    Bug("EuRoC quaternions in the order of the file", EUROC, 'for axis in "xyzw"', 'for axis in "wxyz"',
        OF_FILES + "euroc_quaternions_begin_with_w"),
    Bug("nanoseconds lose their last digits", EUROC, "int(stamp) - first", "float(stamp) - float(first)",
        OF_FILES + "euroc_stamps_are_whole_nanoseconds"),
    Bug("twists stay in the frame of the body", READER, "rotations.apply(twist[:, :3]) * scale",
        "twist[:, :3] * scale", OF_BAGS + "twists_become_actions_in_the_world"),
    Bug("the first of several topics is taken", BAG, "topic is None and len(kinds) == 1", "topic is None",
        OF_BAGS + "several_topics_are_listed_and_chosen_among"),
    Bug("the clock is that of receipt", BAG, "if not all(stamps):", "if True:",
        OF_BAGS + "the_only_topic_of_poses_is_read"),
    Bug("stamps that are not set are the year 1970", BAG, "if not all(stamps):", "if not any(stamps):",
        OF_BAGS + "times_of_receipt_stand_in_for_stamps_that_are_not_set"),
    Bug("all frames are one", BAG, "if each.child == wanted]", "]",
        OF_BAGS + "the_child_frame_of_transforms_is_chosen"),
    Bug("frames of reference may change", BAG, "if len(parents) > 1:", "if False:",
        OF_BAGS + "poses_in_several_frames_are_refused"),
    Bug("stamps without their nanoseconds", MESSAGES, " + int(header.stamp.nanosec)", "",
        OF_BAGS + "the_only_topic_of_poses_is_read"),
]  # fmt: skip
