"""Waypoints on disk: what is written is read again, by this library and by rosbags."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace

import numpy as np
import pytest

from subgoal.flight import Waypoints, read_waypoints, waypoints, write_waypoints
from subgoal.runtime.errors import InputError, MissingExtraError, ReadError
from tests.flight.made import flip, loop, square

FIELDS = ("names", "cyclic", "dimensions", "units", "period", "notes")
ARRAYS = ("positions", "labels", "dwell", "start", "turns", "roundness")
CORNERS = Waypoints(
    np.array([[0.0, 0.0], [1.5, 0.25]]), ("door", "kiosk, north"), [4, 2], [0.0, 2.5], True, notes=("a note",)
)  # fmt: skip


@pytest.mark.parametrize(
    "made", [waypoints(square()), waypoints(flip(width=0.2)), CORNERS], ids=["square", "flip", "named"]
)
def test_json_holds_everything(tmp_path, made) -> None:
    again = read_waypoints(write_waypoints(made, tmp_path / "w.json"))
    assert [getattr(again, name) for name in FIELDS] == [getattr(made, name) for name in FIELDS]
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(again, name), getattr(made, name))


def test_a_table_holds_places_labels_names_and_dwells(tmp_path) -> None:
    again = read_waypoints(write_waypoints(CORNERS, tmp_path / "w.csv"), units="cm")
    np.testing.assert_array_equal(again.positions, CORNERS.positions)
    np.testing.assert_array_equal(again.dwell, CORNERS.dwell)
    assert (again.names, again.labels.tolist(), again.units) == (CORNERS.names, [4, 2], "cm")


def test_a_table_holds_the_unit(tmp_path) -> None:
    path = write_waypoints(replace(CORNERS, units="mm"), tmp_path / "w.csv")
    assert read_waypoints(path).units == "mm"
    assert read_waypoints(path, units="cm").units == "cm"
    assert read_waypoints(write_waypoints(CORNERS, tmp_path / "w.csv")).units == "m"
    path.write_text("x,y,unit\n0,0,mm\n1,1,m\n")
    with pytest.raises(ReadError, match="line 3, column unit: found 'm', wanted 'mm', as in the lines before"):
        read_waypoints(path)


def test_a_table_needs_coordinates_alone(tmp_path) -> None:
    (tmp_path / "w.csv").write_text("y,z\n0,1\n2,1\n")
    assert read_waypoints(tmp_path / "w.csv").dimensions == ("y", "z")


def bag_of(path):
    highlevel = pytest.importorskip("rosbags.highlevel")
    with highlevel.AnyReader([path]) as reader:
        ((connection, _, content),) = reader.messages()
        return connection, reader.deserialize(content, connection.msgtype)


@pytest.mark.parametrize("suffix", ["bag", "mcap", "db3"])
def test_a_bag_holds_the_path_in_metres(tmp_path, suffix) -> None:
    made = Waypoints(np.array([[0.0, 50.0], [150.0, 60.0]]), dimensions=("y", "z"), units="cm")
    for _ in range(2):
        path = write_waypoints(made, tmp_path / f"w.{suffix}", frame="room")
    connection, message = bag_of(path)
    assert (connection.topic, connection.msgtype) == ("/waypoints", "nav_msgs/msg/Path")
    assert message.header.frame_id == "room"
    places = [(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in message.poses]
    np.testing.assert_allclose(places, [[0, 0, 0.5], [0, 1.5, 0.6]])
    assert [p.name for p in tmp_path.iterdir()] == ["w" if suffix == "db3" else f"w.{suffix}"]


def test_a_bag_holds_the_attitude_and_closes_a_round(tmp_path) -> None:
    from scipy.spatial.transform import Rotation

    _, message = bag_of(write_waypoints(loop(), tmp_path / "w.mcap"))
    four = [[getattr(p.pose.orientation, axis) for axis in "xyzw"] for p in message.poses]
    thrust = Rotation.from_quat(four).apply([0, 0, 1])
    np.testing.assert_allclose(thrust, [[0, 0, 1], [0, 0, -1], [0, 0, 1]], atol=1e-12)


def test_tilts_in_a_bag_turn_as_angles_do(tmp_path) -> None:
    from scipy.spatial.transform import Rotation

    period = (np.inf, np.inf, 2 * np.pi)
    made = Waypoints([[0.0, 0, 0.5], [1.0, 0, 0]], dimensions=("y", "z", "angle"), units="m", period=period)
    _, message = bag_of(write_waypoints(made, tmp_path / "w.mcap"))
    four = [getattr(message.poses[0].pose.orientation, axis) for axis in "xyzw"]
    np.testing.assert_allclose(Rotation.from_quat(four).apply([0, 0, 1]), [0, -np.sin(0.5), np.cos(0.5)])


def test_headings_in_a_bag_are_about_the_vertical(tmp_path) -> None:
    period = (np.inf, np.inf, 2 * np.pi)
    made = Waypoints([[0.0, 0, 0.5], [1.0, 0, 0]], dimensions=("x", "y", "yaw"), units="m", period=period)
    _, message = bag_of(write_waypoints(made, tmp_path / "w.mcap"))
    turned = message.poses[0].pose.orientation
    np.testing.assert_allclose([turned.x, turned.y, turned.z, turned.w], [0, 0, np.sin(0.25), np.cos(0.25)])


def test_a_failure_leaves_the_old_file(tmp_path, monkeypatch) -> None:
    path = write_waypoints(CORNERS, tmp_path / "w.json")
    before = path.read_bytes()
    monkeypatch.setattr(json, "dumps", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_waypoints(CORNERS, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("name", ["w.txt", "w"])
def test_other_suffixes_are_refused(tmp_path, name) -> None:
    with pytest.raises(InputError, match=r"ends in \.csv, \.json, \.mcap"):
        write_waypoints(CORNERS, tmp_path / name)
    with pytest.raises(InputError, match=r"ends in \.csv or \.json"):
        read_waypoints(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [("w.json", "{"), ("w.json", "[]"), ("w.json", '{"kind": "subgoal waypoints", "version": 9}'),
     ("w.json", '{"kind": "subgoal waypoints", "version": 1}'), ("w.csv", ""), ("w.csv", "y,z\n")],
)  # fmt: skip
def test_damaged_files_are_refused(tmp_path, name, text) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(ReadError, match=r"w\."):
        read_waypoints(tmp_path / name)


@pytest.mark.parametrize(
    ("text", "told"),
    [("label,x,y\nq,0,0\n2,1,1\n", "line 2, column label: found 'q'"),
     ("label,x,y\n1,0,0\n0,1,1\n", "line 3, column label: found '0'"),
     ("x,y\n0,0\n\n1,oops\n", "line 4, column y: found 'oops'"), ("x,y\n0,inf\n1,1\n", "line 2, column y: found 'inf'"),
     ("x,y\n0,0\n1", "line 3: found 1 cells, wanted 2"), ("x,y\n0,0,7\n1,1\n", "line 2: found 3 cells, wanted 2"),
     ("x,x\n0,0\n1,1\n", "columns x, x, wanted names that differ"),
     ("label,dwell\n1,0\n2,0\n", "no column of coordinates"),
     ("x,y,dwell\n0,0,\n1,1,1\n", "line 2, column dwell: found ''"),
     ('x,y\n0,"0\n1,1\n', "line 3: found unexpected end")],
)  # fmt: skip
def test_what_is_wrong_in_a_table_is_told_with_its_line(tmp_path, text, told) -> None:
    (tmp_path / "w.csv").write_text(text)
    with pytest.raises(ReadError, match=re.escape(told)):
        read_waypoints(tmp_path / "w.csv")


def test_a_table_of_a_spreadsheet_is_read(tmp_path) -> None:
    (tmp_path / "w.csv").write_bytes(b"\xef\xbb\xbfy, z\r\n0, 1\r\n2, 1\r\n\r\n")
    assert read_waypoints(tmp_path / "w.csv").dimensions == ("y", "z")


def test_names_of_several_lines_come_back(tmp_path) -> None:
    made = replace(CORNERS, names=(" door\nwest", "kiosk\u2028north"))
    assert read_waypoints(write_waypoints(made, tmp_path / "w.csv")).names == made.names


ROW = {"label": 1, "name": "a", "position": [0, 0], "dwell": 0, "turn": 0, "roundness": 1}


@pytest.mark.parametrize(
    ("changed", "told"),
    [({"cyclic": "no"}, "w.json at cyclic: found 'no', wanted true or false"), ({"units": 3}, "at units: found 3"),
     ({"dimensions": None}, "at dimensions: found None, wanted a list"),
     ({"dimensions": "ab"}, "found 'ab', wanted a list"),
     ({"start": "here"}, "at start: found 'here', wanted a list"), ({"period": ["a", 1]}, "at period: found ['a', 1]"),
     ({"version": True}, "version True, wanted a file of kind 'subgoal waypoints', version 1"),
     ({"waypoints": [[]]}, "at waypoint 1: found [], wanted an object with keys"),
     ({"waypoints": [ROW, {**ROW, "label": "two"}]}, "at waypoint 2, label: found 'two', wanted a number"),
     ({"waypoints": [ROW, {**ROW, "dwell": True}]}, "at waypoint 2, dwell: found True, wanted a number"),
     ({"waypoints": [{k: v for k, v in ROW.items() if k != "turn"}]}, "at waypoint 1: found no 'turn', wanted one"),
     ({"waypoints": [ROW, {**ROW, "position": [1]}]}, "rows of different lengths"),
     ({"waypoints": [ROW, {**ROW, "name": 10 * "x" * 10 + "y", "position": 10 * "x" * 10}]}, "x…, wanted a list")],
)  # fmt: skip
def test_what_is_wrong_in_a_file_is_told_with_its_key(tmp_path, changed, told) -> None:
    path = write_waypoints(CORNERS, tmp_path / "w.json")
    path.write_text(json.dumps(json.loads(path.read_text()) | changed))
    with pytest.raises(InputError, match=re.escape(told)):
        read_waypoints(path)


def test_a_key_that_is_missing_is_named(tmp_path) -> None:
    path = write_waypoints(CORNERS, tmp_path / "w.json")
    path.write_text(json.dumps({key: value for key, value in json.loads(path.read_text()).items() if key != "units"}))
    with pytest.raises(ReadError, match=r"w\.json: found no 'units', wanted one beside 'kind', 'version'"):
        read_waypoints(path)


def test_missing_files_are_told(tmp_path) -> None:
    with pytest.raises(ReadError, match="No such file"):
        read_waypoints(tmp_path / "w.csv")


def test_rosbags_missing_is_said_by_name(tmp_path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(MissingExtraError, match=r"rosbags is not installed.*subgoal\[ros\]"):
        write_waypoints(CORNERS, tmp_path / "w.bag")
