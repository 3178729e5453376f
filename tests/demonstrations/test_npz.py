"""NumPy archives: positions, ready pairs, and what must never be unpacked."""

from __future__ import annotations

import io
import pickle
import zipfile

import numpy as np
import pytest

from subgoal.demonstrations import read, read_recording
from subgoal.runtime.errors import InputError, ReadError

PLACES = np.arange(10.0).reshape(5, 2)


@pytest.fixture
def archive(tmp_path):
    def save(**arrays):
        np.savez(tmp_path / "a.npz", **arrays)
        return tmp_path / "a.npz"

    return save


def test_positions_times_and_offset(archive):
    path = archive(positions=PLACES, times=[0, 1, 0, 1, 3], offset=[0, 2, 5])
    recording = read_recording(path, scale=2.0, units="m")
    assert np.array_equal(recording.positions, 2 * PLACES)
    assert recording.times.tolist() == [0, 1, 0, 1, 3]
    assert recording.n_trajectories == 2
    assert recording.units == "m"


def test_without_times_samples_are_numbered_in_each_trajectory(archive):
    path = archive(positions=PLACES.astype(np.float32), offset=[0, 2, 5])
    assert read_recording(path).times.tolist() == [0, 1, 0, 1, 2]
    assert read_recording(path).time_unit == "sample"
    assert read_recording(path, rate=2).times.tolist() == [0, 0.5, 0, 0.5, 1]
    assert read_recording(archive(positions=np.arange(3))).positions.shape == (3, 1)


def test_recorded_actions(archive):
    path = archive(positions=PLACES, push=np.arange(5))
    assert read(path, action="push").actions.ravel().tolist() == [0, 1, 2, 3, 4]
    assert read(path, action=["push", "positions"]).actions[2].tolist() == [2, 4, 5]
    with pytest.raises(ReadError, match="array 'pull'"):
        read(path, action="pull")
    with pytest.raises(ReadError, match="equally long"):
        read(archive(positions=PLACES, push=np.arange(5), pull=np.arange(4)), action=["push", "pull"])


def test_ready_pairs_are_given_back_as_they_are(archive):
    path = archive(states=[3, 4, 5], actions=[0, 1, 0], offset=[0, 1, 3], final_states=[9, 8], truncated=[True, False])
    demos = read(path)
    assert demos.states.tolist() == [3, 4, 5]
    assert demos.states.dtype == demos.actions.dtype == np.int64
    assert demos.final_states.tolist() == [9, 8]
    assert demos.truncated.tolist() == [True, False]
    demos = read(archive(states=PLACES, actions=PLACES), thin=4)
    assert demos.offset.tolist() == [0, 1, 2, 3, 4, 5]
    with pytest.raises(InputError, match=r"ready pairs.*read\(path\)"):
        read_recording(path)
    with pytest.raises(InputError, match="states"):
        read(path, format="npz")


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"places": PLACES}, "array 'positions': found arrays 'places'"),
        ({"positions": np.array([{}, {}], dtype=object)}, "no objects"),
        ({"positions": PLACES + 1j}, "real numbers"),
        ({"positions": np.array(["a", "b"])}, "real numbers"),
        ({"positions": np.float64(3)}, "positions|offset"),
        ({"positions": PLACES, "times": np.zeros(5)}, "times at row 1"),
        ({"positions": PLACES, "times": np.arange(4)}, "times"),
        ({"positions": PLACES, "offset": np.array([0, 9])}, "offset"),
        ({"positions": PLACES, "offset": np.array([0.0, 5.0])}, "offset"),
        ({"positions": PLACES, "offset": np.array([0, 99, 5])}, "offset"),
        ({"positions": np.full((3, 2), np.nan)}, "positions at index"),
        ({"positions": np.empty((0, 2))}, "offset|positions"),
        ({"states": np.float64(1), "actions": np.float64(1)}, "arrays"),
        ({"states": PLACES, "actions": PLACES[:2]}, "actions"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(archive, arrays, message):
    with pytest.raises(InputError, match=message):
        read(archive(**arrays))


def zipped(path, *members, pack=zipfile.ZIP_STORED):
    with zipfile.ZipFile(path, "w", pack) as file:
        for name, content in members:
            file.writestr(name, content)
    return path


def npy(array):
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


class Evil:
    def __reduce__(self):
        return (open, ("/tmp/never", "w"))


@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_archives_that_are_not_to_be_trusted_are_refused(tmp_path):
    path = tmp_path / "a.npz"
    good = npy(PLACES)
    lying = good.replace(b"(5, 2)", b"(9, 2)")
    cases = [
        ([("positions.npy", pickle.dumps(Evil()))], "wanted arrays that are whole"),
        ([("positions.npy", npy(np.array([Evil()], dtype=object)))], "no objects"),
        ([("../positions.npy", good), ("positions.npy", good)], "a path"),
        ([("/positions.npy", good)], "a path"),
        ([("positions.npy", good), ("positions.npy", good)], "the name twice"),
        ([("positions.npy", lying)], r"found shape \(9, 2\) of float64 in 208 bytes, wanted 272 bytes"),
        ([("positions.npy", good[:100])], "whole|bytes"),
        ([], "array 'positions'"),
    ]
    for members, message in cases:
        with pytest.raises(ReadError, match=message):
            read_recording(zipped(path, *members))
    with pytest.raises(ReadError, match="packed into"):
        read_recording(zipped(path, ("positions.npy", bytes(2**24)), pack=zipfile.ZIP_BZIP2))


def test_a_torn_archive_is_refused(archive):
    path = archive(positions=PLACES)
    content = path.read_bytes()
    for size in range(0, len(content), 37):
        path.write_bytes(content[:size])
        with pytest.raises(ReadError):
            read_recording(path)
