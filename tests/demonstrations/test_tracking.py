"""Pose trackers: DeepLabCut as CSV and HDF5, SLEAP."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import h5py
import numpy as np
import pandas as pd
import pytest

from subgoal.demonstrations import read, read_recording
from subgoal.demonstrations.readers import hdf5
from subgoal.demonstrations.readers.hdf5_child import content
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError
from tests.demonstrations.valid_files import deeplabcut_frame, write_sleap


@pytest.fixture(params=["csv", "h5"])
def deeplabcut(request, tmp_path):
    def save(frame):
        path = tmp_path / f"tracks.{request.param}"
        if request.param == "csv":
            frame.to_csv(path)
        else:
            frame.to_hdf(path, key="df_with_missing", format="table", mode="w")
        return path

    return save


def test_one_animal(deeplabcut):
    recording = read_recording(deeplabcut(deeplabcut_frame()), bodypart="tail", scale=0.5, units="cm")
    assert recording.positions[:, 0].tolist() == [5, 5.5, 6.5, 7, 7.5, 8, 8.5]
    assert recording.positions[:, 1].tolist() == [10, 11, 13, 14, 15, 16, 17]
    assert recording.times.tolist() == [0, 1, 3, 4, 5, 6, 7]
    assert (recording.units, recording.time_unit, recording.trajectory_names) == ("cm", "frame", ("animal",))
    assert recording.source.notes == {"frames of low likelihood dropped": 1}


def test_several_animals_are_several_trajectories(deeplabcut):
    recording = read_recording(deeplabcut(deeplabcut_frame(("mother", "pup"))), bodypart="nose", min_likelihood=0)
    assert recording.trajectory_names == ("mother", "pup")
    assert recording.positions[:, 0].tolist() == [*range(8), *range(20, 28)]


def test_frames_become_seconds_and_short_gaps_are_bridged(deeplabcut):
    demos = read(deeplabcut(deeplabcut_frame()), bodypart="nose", rate=10)
    assert demos.time_unit == "s"
    assert demos.states[:, 0] == pytest.approx(np.arange(8.0))
    assert demos.actions == pytest.approx(np.tile([10.0, 20.0], (8, 1)))
    assert demos.source.notes == {"frames of low likelihood dropped": 1, "samples interpolated": 1}


def test_long_gaps_cut(deeplabcut):
    frame = deeplabcut_frame(count=60)
    frame.iloc[10:45, :3] = np.nan
    path = deeplabcut(frame)
    recording = read_recording(path, bodypart="nose")
    assert recording.trajectory_names == ("animal/0", "animal/1")
    assert recording.truncated.tolist() == [True, False]
    assert recording.source.notes == {
        "frames without a place dropped": 35, "frames of low likelihood dropped": 1, "gaps split": 1,
    }  # fmt: skip
    assert read_recording(path, bodypart="nose", max_gap=36).n_trajectories == 1
    assert read_recording(path, bodypart="nose", rate=40).n_trajectories == 1
    assert read_recording(path, bodypart="nose", rate=30).n_trajectories == 2
    assert read_recording(path, bodypart="nose", rate=30, max_gap=2).n_trajectories == 1


def test_the_body_part_must_be_named_where_there_are_several(deeplabcut):
    path = deeplabcut(deeplabcut_frame())
    for bodypart in (None, "ear"):
        with pytest.raises(InputError, match="wanted one of 'nose', 'tail'"):
            read_recording(path, bodypart=bodypart)
    assert read_recording(deeplabcut(deeplabcut_frame()[["net"]].iloc[:, :3])).n_trajectories == 1


def test_labels_without_a_likelihood_are_refused(deeplabcut):
    with pytest.raises(ReadError, match="body part 'nose': found no likelihood"):
        read_recording(deeplabcut(deeplabcut_frame().iloc[:, [0, 1, 5]]), bodypart="nose")


def test_nothing_seen_is_refused(deeplabcut):
    with pytest.raises(ReadError, match="no usable frame"):
        read_recording(deeplabcut(deeplabcut_frame()), bodypart="nose", min_likelihood=1)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("coords", "cords", "wanted scorer"),
        ("bodyparts,nose", "bodyparts", "different length"),
        ("tail", "nose", "twice"),
        ("\n3,", "\nthree,", "column '0', data row 4"),
        ("\n3,", "\n,", "data row 4, counted from 1: found no frame number"),
        ("\n3,", "\n2,", "data row 4"),
    ],
)
def test_broken_tables_are_refused(tmp_path, old, new, message):
    path = tmp_path / "a.csv"
    path.write_text(deeplabcut_frame().to_csv().replace(old, new))
    with pytest.raises(ReadError, match=message):
        read_recording(path, bodypart="nose", format="deeplabcut")


def test_the_process_that_reads_hdf5_finds_plain_arrays(tmp_path):
    write_sleap(tmp_path / "s.h5")
    with h5py.File(tmp_path / "s.h5", "a") as file:
        del file["node_names"]
        file["node_names"] = ["nose", "täil"]  # text of variable length, as some versions write it
    found = dict(content(str(tmp_path / "s.h5")))
    assert found["tracks"].shape == (2, 2, 2, 8)
    assert found["node_names"].tolist() == ["nose", "täil"]
    assert not any(array.dtype.hasobject for array in found.values())
    assert read_recording(tmp_path / "s.h5", bodypart="täil").n_trajectories == 2
    deeplabcut_frame().to_hdf(tmp_path / "d.h5", key="d", format="table", mode="w")
    found = dict(content(str(tmp_path / "d.h5")))
    assert found["fields"].tolist() == ["index", "values_block_0"]
    assert found["index"].tolist() == list(range(8))


@pytest.mark.skipif(sys.platform != "linux", reason="the limits are those of Linux")
@pytest.mark.parametrize(
    ("stuck", "code", "told"),
    [("while True: pass", -signal.SIGALRM, b""), ("bytearray(2**31)", 0, b"MemoryError")],
)
def test_the_process_that_reads_hdf5_stops_itself(tmp_path, stuck, code, told):
    write_sleap(tmp_path / "s.h5")
    program = f"""
from subgoal.demonstrations.readers import hdf5_child
def content(path):
    {stuck}
    yield "tracks", 0
hdf5_child.content = content
hdf5_child.main({str(tmp_path / "s.h5")!r})
"""
    child = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=20, check=False)
    assert child.returncode == code
    assert told in child.stdout.replace(b"\0", b"")


def test_an_hdf5_file_that_stops_its_library_is_refused(tmp_path, monkeypatch):
    write_sleap(tmp_path / "s.h5")
    monkeypatch.setattr(hdf5, "CHILD", "subgoal.no_such_module")
    with pytest.raises(ReadError, match=r"stopped the HDF5 library \(exit 1\)"):
        read_recording(tmp_path / "s.h5", bodypart="nose")


class Evil:
    def __reduce__(self):
        return (os.system, ("touch /tmp/never",))


def test_hdf5_of_other_kinds_and_pickled_classes_are_refused(tmp_path):
    path = tmp_path / "a.h5"
    deeplabcut_frame().to_hdf(path, key="d", format="fixed", mode="w")
    with pytest.raises(ReadError, match="table"):
        read_recording(path, bodypart="nose", format="deeplabcut")
    pd.DataFrame({"a": [1.0], "b": ["text"]}).to_hdf(path, key="d", format="table", mode="w")
    with pytest.raises(ReadError, match="fields"):
        read_recording(path, bodypart="nose")
    import pickle

    deeplabcut_frame().to_hdf(path, key="d", format="table", mode="w")
    with h5py.File(path, "a") as file:
        file["d/table"].attrs["values_block_0_kind"] = np.bytes_(pickle.dumps(Evil(), protocol=0))
    with pytest.raises(ReadError, match="is refused"):
        read_recording(path, bodypart="nose")


def test_sleap_exports(tmp_path):
    write_sleap(tmp_path / "s.h5")
    recording = read_recording(tmp_path / "s.h5", bodypart="tail")
    assert recording.trajectory_names == ("mother", "pup")
    assert recording.positions[:, 0].tolist() == [10, 11, 12, 13, 14, 16, 17, 110, 111, 112, 115, 116, 117]
    assert recording.positions[:3, 1].tolist() == [0, 2, 4]
    assert recording.source.notes == {"frames without a place dropped": 2, "frames of low likelihood dropped": 1}
    write_sleap(tmp_path / "s.h5", names=False)
    assert read_recording(tmp_path / "s.h5", bodypart="nose", max_gap=2).trajectory_names == (
        "track 0", "track 1/0", "track 1/1",
    )  # fmt: skip


def test_sleap_files_that_do_not_fit_are_refused(tmp_path):
    path = tmp_path / "s.h5"
    for change, message in (
        ({"tracks": np.zeros((2, 3, 2, 8))}, "tracks: found float64 of shape"),
        ({"tracks": None}, "'tracks'|table"),
        ({"node_names": np.array([b"a", b"a"])}, "different names"),
        ({"point_scores": np.zeros((2, 2, 7))}, "point_scores"),
        ({"tracks": np.full((2, 2, 2, 8), np.nan)}, "no usable frame"),
    ):
        write_sleap(path)
        with h5py.File(path, "a") as file:
            for name, value in change.items():
                del file[name]
                if value is not None:
                    file[name] = value
        with pytest.raises(ReadError, match=message):
            read_recording(path, bodypart="nose" if "node_names" not in change else "a", format="sleap")


def test_a_dataset_larger_than_its_file_is_not_unpacked(tmp_path):
    path = tmp_path / "s.h5"
    with h5py.File(path, "w") as file:
        file.create_dataset("tracks", shape=(2, 2, 2, 10**9), chunks=(1, 1, 1, 1000), dtype="f8")
    with pytest.raises(ReadError, match="bytes in a file of"):
        read_recording(path)


def test_h5py_missing_is_said_by_name(tmp_path, monkeypatch):
    write_sleap(tmp_path / "s.h5")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(MissingExtraError, match=r"h5py is not installed.*subgoal\[sleap\]"):
        read_recording(tmp_path / "s.h5", bodypart="nose")
