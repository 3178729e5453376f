"""Bags and poses on the command line."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from subgoal import load
from tests.cli.conftest import QUICK
from tests.demonstrations.valid_bags import START, pose, transforms, write_bag


@pytest.fixture
def flip(tmp_path):
    """A bag of a walk along y with a flip half way, 100 times a second, on one of two topics."""
    turn = np.concatenate([np.zeros(100), np.linspace(0, 2 * np.pi, 100), np.zeros(100)])
    along = np.concatenate([np.linspace(0, 2, 100), np.full(100, 2.0), np.linspace(2, 4, 100)])
    quaternions = Rotation.from_rotvec(turn[:, None] * [1, 0, 0]).as_quat()
    places = np.column_stack([0 * along, along, 1 + 0 * along, quaternions])
    stamps = [START + 10**7 * k for k in range(300)]
    topics = {
        "/quad": [(stamp, pose(stamp, place)) for stamp, place in zip(stamps, places, strict=True)],
        "/tf": [
            (stamp, transforms(stamp, {"a": place, "b": place})) for stamp, place in zip(stamps, places, strict=True)
        ],
    }
    return write_bag(tmp_path, "mcap", topics).parent


def test_a_flip_in_a_plane_is_learned_with_an_angle_that_wraps(subgoal, flip, tmp_path):
    out = tmp_path / "out"
    words = ("--topic", "/quad", "--plane", "yz", "--rate", 20, "--weights", "1,1,0.3", "--out", out, *QUICK)
    answer = subgoal("learn", flip, *words)
    assert answer.code == 0, answer.err
    posterior = load(out / "posterior.npz")
    assert posterior.candidates.metric.period.tolist() == [np.inf, np.inf, 2 * np.pi]
    assert posterior.demonstrations.names == ("y", "z", "angle")
    assert np.abs(posterior.demonstrations.actions[:, 2]).max() < 7


def test_topics_and_frames_are_asked_for_by_their_options(subgoal, flip, tmp_path):
    out = ("--out", tmp_path / "out")
    answer = subgoal("inspect", flip, *out)
    assert (answer.code, "Try: --topic /quad" in answer.err) == (2, True)
    answer = subgoal("learn", flip, "--topic", "/tf", *out)
    assert (answer.code, "Try: --frame a" in answer.err) == (2, True)
    answer = subgoal("inspect", flip, "--topic", "/tf", "--frame", "b", "--pose", *out)
    assert answer.code == 0, answer.err
    assert "qw: -1 to 1" in answer.out


def test_twists_are_for_odometry(subgoal, flip, tmp_path):
    for command in ("learn", "inspect"):
        answer = subgoal(command, flip, "--topic", "/quad", "--twist", "--out", tmp_path / "out")
        assert (answer.code, "twist" in answer.err) == (2, True)
