"""Edinburgh, TUM, LASA, labyrinth and Parquet files, small and by hand; which reader is chosen."""

from __future__ import annotations

import struct
import zlib

import numpy as np
import pandas as pd
import pytest
from scipy.io import loadmat, savemat

from subgoal.demonstrations import read, read_recording
from subgoal.demonstrations.readers import format_of
from subgoal.demonstrations.readers.matlab import read_variable
from subgoal.runtime.errors import InputError, ReadError
from tests.demonstrations.valid_files import EDINBURGH, LABYRINTH, TUM, write_all, write_lasa


@pytest.fixture
def file(tmp_path):
    def save(text, name="file.txt"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return save


def test_formats_are_found_by_content(tmp_path):
    found = {name: format_of(path) for name, (path, _) in write_all(tmp_path).items()}
    assert found == {
        "csv.csv": "csv", "sheet.csv": "csv", "edinburgh.txt": "edinburgh", "tum.txt": "tum",
        "labyrinth.csv": "labyrinth", "table.parquet": "parquet", "plain.npz": "npz", "packed.npz": "npz",
        "pairs.npz": "pairs", "single.csv": "deeplabcut", "several.h5": "deeplabcut", "sleap.h5": "sleap",
        "lasa.mat": "lasa", "euroc.csv": "euroc", "b.bag": "rosbag", "b.db3": "rosbag", "b.mcap": "rosbag",
    }  # fmt: skip
    with pytest.raises(InputError, match="found 'word', wanted 'csv', 'parquet'"):
        format_of(tmp_path / "csv.csv", "word")


def test_edinburgh_tracks(file):
    recording = read_recording(file(EDINBURGH))
    assert recording.trajectory_names == ("R1", "R2")
    assert recording.positions.tolist() == [[593, 42], [588, 48], [583, 56], [1, 2], [3, 4]]
    assert recording.times.tolist() == [95, 96, 97, 367, 369]
    assert (recording.units, recording.time_unit) == ("px", "frame")
    assert recording.source.notes == {"samples of repeated time dropped": 1}
    metres = read_recording(file(EDINBURGH), rate=10, scale=0.0247, units="m")
    assert metres.positions[4] == pytest.approx([0.0741, 0.0988])
    assert (metres.times[3], metres.units, metres.time_unit) == (36.7, "m", "s")


def test_edinburgh_clock_and_absent_tracks(file):
    text = EDINBURGH.replace("[3 4 369]", "[3 4 360]").replace("file are  2", "file are  5")
    with pytest.raises(ReadError, match="360 after 367"):
        read_recording(file(text))
    recording = read_recording(file(text), clock="split")
    assert recording.trajectory_names == ("R1", "R2/0", "R2/1")
    assert recording.source.notes["tracks announced but not in the file"] == 3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[3 4 369]];", "[3 4 3", "TRACK.R2: found a torn track"),
        ("[[1 2 367]", "1 2 367]", "TRACK.R2: found a torn track"),
        ("[3 4 369]", "[3 4]", "TRACK.R2.*three numbers a point"),
        ("[3 4 369]", "[3 four 369]", "three numbers a point"),
        ("[3 4 369]", "[3 1e400 369]", "three numbers a point"),
        ("TRACK.R2", "TRACK.R1", "TRACK.R1: found the name twice"),
        ("TRACK", "TRUCK", "at least one track"),
    ],
)
def test_torn_edinburgh_files_are_refused(file, old, new, message):
    with pytest.raises(ReadError, match=message):
        read_recording(file(EDINBURGH.replace(old, new)), format="edinburgh")


def test_tum_trajectories(file):
    recording = read_recording(file(TUM))
    assert recording.positions[2].tolist() == [1.2, 0.5, -0.25]
    assert recording.times.tolist() == [k / 4 for k in range(12)]
    assert (recording.names, recording.units, recording.time_unit) == (("tx", "ty", "tz"), "m", "s")
    assert read_recording(file(TUM.replace(" ", "\t  ")), position=["tz", "qw"]).positions[4].tolist() == [-0.5, 1]
    for text, message in (
        (TUM.replace(" 0 1\n", " 0\n"), "7 columns"),
        (TUM.replace("# timestamp", "stamp"), "header line"),
        (TUM.replace("1.3000", "one"), "column 'tx', data row 4"),
        (TUM.replace("1305031098.2500", "now"), "column 'timestamp'|header"),
    ):
        with pytest.raises(ReadError, match=message):
            read_recording(file(text), format="tum")


def test_lasa_demonstrations(tmp_path):
    write_lasa(tmp_path / "l.mat")
    recording = read_recording(tmp_path / "l.mat", scale=0.001, units="m")
    assert recording.offset.tolist() == [0, 5, 11]
    assert recording.positions[-1] == pytest.approx([0.005, -0.0025])
    assert recording.times[5:8] == pytest.approx([0, 0.1, 0.2])
    assert recording.trajectory_names == ("demo 1", "demo 2")


def test_lasa_files_that_are_none_are_refused(tmp_path):
    path = tmp_path / "l.mat"
    for content, message in (
        ({"other": 1.0}, r"variables \['other'\]"),
        ({"demos": np.ones((2, 3))}, "found numbers"),
        ({"demos": {"pos": np.ones((2, 3))}}, r"fields \['pos'\], wanted pos and t"),
        ({"demos": {"pos": np.ones((3, 3)), "t": np.arange(3.0)}}, r"pos \(3, 3\)"),
        ({"demos": {"pos": "text", "t": np.arange(3.0)}}, "numbers"),
        ({"demos": np.empty((0, 0), dtype=object)}, "empty 'demos'"),
    ):
        savemat(path, content)
        with pytest.raises(ReadError, match=message):
            read_recording(path)
    savemat(path, {"demos": 1.0}, format="4")
    with pytest.raises(ReadError, match="another header"):
        read_recording(path)


def element(kind, body):
    """An element of a MATLAB file, padded to eight bytes."""
    return struct.pack("<II", kind, len(body)) + body + bytes(-len(body) % 8)


def matrix(kind, shape, *rest, name=b"demos"):
    flags = element(6, struct.pack("<II", kind, 0))
    return element(14, flags + element(5, struct.pack(f"<{len(shape)}i", *shape)) + element(1, name) + b"".join(rest))


NUMBER = matrix(6, [1, 1], element(9, bytes(8)), name=b"")


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (b"\1\2\3", "inside a tag"),
        (struct.pack("<II", 14, 10**9), "an element of 1000000000 bytes where 0 are left"),
        (element(14, struct.pack("<HH", 6, 200) + bytes(4)), "a short element of 200 bytes"),
        (element(14, element(99, b"")), "type 99 where numbers belong"),
        (element(14, element(6, bytes(4))), "inside a tag"),
        (matrix(1, [-1, 3]), "shape"),
        (matrix(6, [2, 2], element(9, bytes(24))), r"3 numbers for shape \[2, 2\]"),
        (matrix(1, [10**9, 10**9]), "parts in"),
        (matrix(2, [10**9, 10**9], element(5, struct.pack("<i", 8)), element(1, b"")), "parts in"),  # no fields
        (matrix(1, [1, 1], element(9, bytes(8))), "type 9 where a matrix belongs"),
        (matrix(2, [1, 1], element(5, bytes(4)), element(1, b"abcd")), "field names"),
        (element(15, zlib.compress(struct.pack("<II", 14, 100) + bytes(50))), "50 bytes unpacked"),
        (element(15, zlib.compress(struct.pack("<II", 14, 2**31) + bytes(50))), "packed into"),
        (element(15, b"noise"), "found error"),
    ],
)
def test_torn_matlab_files_are_refused(tmp_path, body, message):
    path = tmp_path / "a.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + body)
    with pytest.raises(ReadError, match=message):
        read_variable(path, "demos")


def test_matlab_cells_in_cells_end_somewhere(tmp_path):
    body = NUMBER
    for _ in range(30):
        body = matrix(1, [1, 1], body)
    path = tmp_path / "a.mat"
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + body)
    with pytest.raises(ReadError, match="more than 20 levels"):
        read_variable(path, "demos")
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + matrix(1, [1, 2], NUMBER, element(14, b"")))
    assert [value.shape for value in read_variable(path, "demos")] == [(1, 1), (0, 0)]


def same(ours, theirs):
    """Our lists and dictionaries against the objects SciPy makes."""
    if isinstance(ours, dict):
        return all(same(ours[name], getattr(theirs, name)) for name in theirs._fieldnames)
    if isinstance(ours, list):
        return len(ours) == theirs.size and all(map(same, ours, theirs.ravel(order="F")))
    return ours.shape == theirs.shape and np.array_equal(ours, theirs)


@pytest.mark.parametrize("packed", [False, True])
def test_matlab_values_are_those_scipy_reads(tmp_path, packed):
    rng = np.random.default_rng(1)
    cell = np.empty((2, 3), dtype=object)
    for k in range(6):
        cell[k % 2, k // 2] = [rng.normal(size=(k, 2)), np.arange(k, dtype=np.int16), {"a": np.uint8(k), "bb": [1.5]}][
            k % 3
        ]
    path = tmp_path / "v.mat"
    savemat(path, {"before": "text", "v": cell, "after": 3}, do_compression=packed)
    theirs = loadmat(path, struct_as_record=False)["v"]
    assert same(read_variable(path, "v"), theirs)
    assert read_variable(path, "after").tolist() == [[3.0]]
    assert read_variable(path, "before") is None


def test_labyrinth_walks(file):
    demos = read(file(LABYRINTH, "visits.csv"))
    assert demos.states.tolist() == [0, 2, 0, 0, 1]
    assert demos.actions.tolist() == [1, 2, 2, 0, 1]
    assert demos.offset.tolist() == [0, 3, 5]
    assert demos.final_states.tolist() == [127, 4]
    assert demos.truncated.tolist() == [False, True]
    assert demos.times.tolist() == [4, 9, 11, 3, 5]
    assert demos.trajectory_names == ("A/0", "B/0")
    assert demos.source.notes == {"bouts of one visit dropped": 1}
    assert read(file(LABYRINTH), format="labyrinth", session="B").trajectory_names == ("B/0",)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "A,0,1,2,9",
            "A,0,1,3,9",
            "data row 2, counted from 1: found a step from 3 to 0|data row 1, counted from 1: found a step from 0 to 3",
        ),
        ("A,0,1,2,9", "A,0,1,200,9", "column 'node', data row 2, counted from 1: found 200"),
        ("A,0,1,2,9", "A,0,7,2,9", "column 'step', data row 2, counted from 1: found 7"),
        ("A,0,1,2,9", "A,0,1,2.5,9", "column 'node', data row 2, counted from 1: found 2.5"),
        ("A,0,1,2,9", "A,0,1,,9", "data row 2, counted from 1: found nan"),
        ("B,0,0,0,3", "A,0,4,127,3", "corridor|two places|step"),
        ("node", "nodule", "column 'node'"),
    ],
)
def test_walks_through_walls_are_refused(file, old, new, message):
    with pytest.raises(ReadError, match=message):
        read(file(LABYRINTH.replace(old, new, 1)), format="labyrinth")


def test_labyrinth_sessions_and_lone_visits_are_refused(file):
    with pytest.raises(ReadError, match=r"found 'Z', wanted one of \['A', 'B'\]"):
        read(file(LABYRINTH), format="labyrinth", session="Z")
    lone = "\n".join(LABYRINTH.split("\n")[:2]) + "\n"
    with pytest.raises(ReadError, match="one visit only"):
        read(file(lone), format="labyrinth")


def test_parquet_tables(tmp_path):
    path = tmp_path / "t.parquet"
    stamps = pd.to_datetime(
        ["2024-01-01T00:00:01", "2024-01-01T00:00:00", "2024-01-01T00:00:00.5"], utc=True, format="ISO8601"
    )
    frame = pd.DataFrame(
        {"who": ["a", "b", "a"], "when": stamps, "x": [1, 2, 3], "y": [0.5, np.nan, 1.5], "w": [7, 8, 9]}
    )
    frame.loc[2, "when"] = stamps[0] + pd.Timedelta(1, "s")
    frame["list"] = [[1], [2], [3]]
    frame.to_parquet(path)
    recording = read_recording(path, time="when", trajectory="who", scale=10.0, action="w")
    assert recording.positions.tolist() == [[10, 5], [30, 15]]
    assert recording.times.tolist() == [1, 2]
    assert recording.actions.ravel().tolist() == [7, 9]
    assert recording.source.notes == {"rows without a position dropped": 1}
    for options, message in (
        ({"position": ["x", "list"]}, "column 'list': found type list"),
        ({"position": ["x", "when"]}, "column 'when': found datetime64"),
        ({"position": ["x", "who"]}, "column 'who', data row 1, counted from 1: found 'a'"),
        ({"position": ["x", "z"]}, "column 'z'"),
    ):
        with pytest.raises(ReadError, match=message):
            read_recording(path, **options)
