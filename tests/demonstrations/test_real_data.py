"""Real files, where they are there: counts and places that their makers published."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from subgoal.demonstrations import angular_velocities, demonstrate, read, read_recording, starting_in, summarise


@pytest.fixture
def data():
    given = os.environ.get("SUBGOAL_DATA")
    folder = Path(given) if given else Path(__file__).parents[2].parent / "shared" / "data"

    def find(name):
        if not (folder / name).is_file():
            pytest.skip(f"{name} is not there; SUBGOAL_DATA names the folder of the data sets")
        return folder / name

    return find


def test_edinburgh_forum(data):
    recording = read_recording(data("edinburgh_forum/tracks.01Jul.txt"))
    assert recording.n_trajectories == 1262
    dropped = recording.source.notes["samples of repeated time dropped"]
    assert (len(recording.positions), dropped) == (111230 - 92, 92)
    upper_right = starting_in(recording, [480, -np.inf], [np.inf, 140])
    assert upper_right.n_trajectories == 157
    demos = demonstrate(upper_right, every=5)
    ends = upper_right.positions[upper_right.offset[1:] - 1]
    assert np.array_equal(demos.final_states, ends)
    assert np.linalg.norm(demos.actions, axis=1).max() < 60
    assert any("quantised" in warning for warning in summarise(recording).warnings)


@pytest.mark.parametrize("shape", ["Angle", "Line", "Zshape"])
def test_lasa_handwriting(data, shape):
    from scipy.io import loadmat

    path = data(f"lasa_handwriting/{shape}.mat")
    demos = read(path, velocity="savgol", every=10)
    assert demos.n_trajectories == 7
    assert demos.n_observations == 700
    assert np.abs(demos.final_states).max() < 1e-6
    theirs = loadmat(path, squeeze_me=True, struct_as_record=False)["demos"]
    speeds = np.concatenate([demo.vel.T[::10] for demo in theirs])
    apart = np.linalg.norm(demos.actions - speeds, axis=1) / np.linalg.norm(speeds, axis=1).max()
    assert np.quantile(apart, 0.9) < 0.02


def test_tum_handheld(data):
    path = data("tum_rgbd_handheld/freiburg1_xyz-groundtruth.txt")
    recording = read_recording(path)
    assert len(recording.positions) == 3000
    demos = read(path, rate=100, every=5, thin=0.01)
    assert np.ptp(recording.positions, axis=0).max() == pytest.approx(0.9648 - 0.2674)
    assert 200 < demos.n_observations < 600
    plain = np.loadtxt(path)
    assert np.array_equal(recording.positions, plain[:, 1:4])


def test_tum_handheld_orientations(data):
    path = data("tum_rgbd_handheld/freiburg1_xyz-groundtruth.txt")
    recording = read_recording(path, pose=True)
    plain = np.loadtxt(path)
    assert np.array_equal(recording.positions[:, :3], plain[:, 1:4])
    assert np.abs(np.abs((recording.positions[:, 3:] * plain[:, 4:]).sum(axis=1)) - 1).max() < 1e-3
    demos = read(path, pose=True, rate=20)
    speeds = np.linalg.norm(angular_velocities(demos.states[:, 3:], demos.actions[:, 3:]), axis=1)
    assert 0.1 < np.median(speeds) < np.quantile(speeds, 0.99) < 1.0  # held still by hand, rad/s


def test_mouse_labyrinth(data):
    path = data("mouse_labyrinth/node_visits.csv")
    for session, bouts, visits in (("D9a", 47, 3516), ("A1b", 21, 1586), ("D9b", 48, 4492)):
        demos = read(path, session=session)
        assert demos.n_trajectories == bouts
        assert demos.n_observations == visits - bouts
        assert (demos.final_states == 127).all()
    assert read(path).n_observations == 9478
