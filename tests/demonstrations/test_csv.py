"""Tables of text as people have them: spreadsheets, several animals in one file, clocks that jump."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

from subgoal.demonstrations import read, read_recording
from subgoal.runtime.errors import InputError, ReadError
from tests.demonstrations.valid_files import CSV, SHEET


@pytest.fixture
def table(tmp_path):
    def reader(text, *, name="table.csv", **options):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_recording(path, **options)

    return reader


def rows(recording):
    return recording.positions.tolist()


def test_columns_x_y_and_t_are_found_without_being_named(table):
    recording = table("t,other,x,y\n0.5,7,1,2\n1,8,3,4e0\n")
    assert rows(recording) == [[1, 2], [3, 4]]
    assert recording.times.tolist() == [0.5, 1]
    assert (recording.names, recording.time_unit, recording.units) == (("x", "y"), "s", "")
    assert rows(table("Z;Y;X\n3;2;1\n6;5;4\n")) == [[1, 2, 3], [4, 5, 6]]


def test_the_checksum_and_name_of_the_file_are_kept(table):
    recording = table("x,y\n1,2\n", name="walk.csv")
    assert recording.source.name == "walk.csv"
    assert recording.source.checksum == hashlib.sha256(b"x,y\n1,2\n").hexdigest()


def test_a_spreadsheet_with_decimal_comma_byte_order_mark_and_timestamps(table):
    recording = table(SHEET, position=["X in m", "Y in m"], time="Zeit", trajectory="Wer", units="m")
    assert rows(recording) == [[1.5, 2], [1.75, 2.25], [0, -15], [1, 1]]
    assert recording.times.tolist() == [0, 0.5, 0.5, 1]
    assert recording.trajectory_names == ("a", "b")
    assert recording.source.notes == {"rows without a position dropped": 1}


def test_interleaved_trajectories_are_brought_apart_in_order_of_appearance(table):
    recording = table("id,t,x,y\n7,0,0,0\n03,0,5,5\n7,1,1,1\n03,1,6,6\n7,2,2,2\n", trajectory="id")
    assert recording.trajectory_names == ("7", "03")
    assert recording.offset.tolist() == [0, 3, 5]
    assert recording.positions[:, 0].tolist() == [0, 1, 2, 5, 6]


JUMP = "t,x,y\n0,0,0\n1,1,0\n2,2,0\n0.5,3,0\n1.5,4,0\n2.5,5,0\n2.5,6,0\n"


def test_a_clock_that_jumps_is_refused_with_its_row_and_advice(table):
    with pytest.raises(
        ReadError, match=r"data row 4, counted from 1 \(1 such place\): found 0\.5 after 2.*clock='sort'.*trajectory="
    ):
        table(JUMP)


@pytest.mark.parametrize(
    ("clock", "x", "offset", "notes"),
    [
        ("sort", [0, 3, 1, 4, 2, 5], [0, 6], {"places where the clock jumped back sorted": 1}),
        ("split", [0, 1, 2, 3, 4, 5], [0, 3, 6], {"trajectories split where the clock jumped back": 1}),
        ("drop", [0, 1, 2, 5], [0, 4], {"samples of a clock that jumped back dropped": 2}),
    ],
)
def test_a_clock_that_jumps_is_treated_as_asked(table, clock, x, offset, notes):
    recording = table(JUMP, clock=clock)
    assert recording.positions[:, 0].tolist() == x
    assert recording.offset.tolist() == offset
    assert recording.source.notes == {"samples of repeated time dropped": 1, **notes}
    if clock == "split":
        assert recording.trajectory_names == ("T0/0", "T0/1")


def test_sorting_drops_times_that_meet_only_then(table):
    recording = table("t,x,y\n0,0,0\n2,2,0\n1,1,0\n2,9,0\n", clock="sort")
    assert recording.positions[:, 0].tolist() == [0, 1, 2]
    assert recording.source.notes["samples of repeated time dropped"] == 1


def test_splitting_counts_pieces_in_each_trajectory(table):
    text = "id,t,x,y\na,0,0,0\nb,5,0,0\na,1,1,0\nb,4,1,0\nb,3,2,0\na,0,2,0\n"
    recording = table(text, trajectory="id", clock="split")
    assert recording.trajectory_names == ("a/0", "a/1", "b/0", "b/1", "b/2")
    assert recording.times.tolist() == [0, 1, 0, 5, 4, 3]


def test_without_a_clock_samples_are_numbered_within_their_trajectory_even_where_one_is_missing(table):
    text = "id,x,y\na,0,0\nb,9,9\na,,0\na,2,0\nb,8,9\n"
    recording = table(text, trajectory="id")
    assert (recording.times.tolist(), recording.time_unit) == ([0, 2, 0, 1], "sample")
    recording = table(text, trajectory="id", rate=10)
    assert (recording.times.tolist(), recording.time_unit) == ([0, 0.2, 0, 0.1], "s")


def test_scale_units_and_milliseconds(table):
    recording = table("t,x,y\n0,100,0\n500,200,50\n", scale=0.5, units="m", time_scale=1e-3)
    assert rows(recording) == [[50, 0], [100, 25]]
    assert recording.times.tolist() == [0, 0.5]
    assert recording.units == "m"


def test_unlikely_and_incomplete_rows_are_dropped_and_counted_once_each(table):
    text = "id,t,x,y,p\na,0,1,1,.9\n,1,1,1,.9\na,1,NaN,1,.1\na,,1,1,.9\na,3,1,1,.59\na,4,1,1,\na,5,2,2,.6\n"
    recording = table(text, trajectory="id", likelihood="p")
    assert recording.times.tolist() == [0, 5]
    assert recording.source.notes == {
        "rows without a trajectory dropped": 1,
        "rows without a position dropped": 1,
        "rows without a time dropped": 1,
        "rows of low likelihood dropped": 2,
    }
    assert table(text, trajectory="id", likelihood="p", min_likelihood=0.5).times.tolist() == [0, 3, 5]


def test_recorded_actions_are_read_beside_the_positions(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,x,y,vx,vy\n0,0,0,1,2\n1,1,1,3,4\n2,2,2,,5\n3,3,3,5,6\n")
    demos = read(path, action=["vx", "vy"])
    assert demos.actions.tolist() == [[1, 2], [3, 4], [5, 6]]
    assert demos.source.notes == {"rows without an action dropped": 1}


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("x\ty\n1\t2\n3\t4\n", [[1, 2], [3, 4]]),
        ("x|y\r\n1|2\r\n3|4\r\n", [[1, 2], [3, 4]]),
        ("  x   y\n 1   2\n 3   4\n", [[1, 2], [3, 4]]),
        ("x;y\n1,5;2\n3;4,25\n", [[1.5, 2], [3, 4.25]]),
        ("x;y\n1.5;2\n3;4\n", [[1.5, 2], [3, 4]]),
        ('"x","y","said"\n1,2,"no, no"\n3,4,"a ""b"""\n', [[1, 2], [3, 4]]),
        ("# made by hand\n\n# t,x,y\n0,1,2\n1,3,4\n", [[1, 2], [3, 4]]),
        ("x,y,\n1,2,\n3,4,\n", [[1, 2], [3, 4]]),
        ("x,y\n1,2,\n3,4,\n", [[1, 2], [3, 4]]),
        ("x,y\n1,2\n\n3,4", [[1, 2], [3, 4]]),
        ("x,y\n1,2\n3,4\n5\n", [[1, 2], [3, 4]]),
        ("x,y\r1,2\r3,0.1\r", [[1, 2], [3, 0.1]]),
        ("x,y\n1,2\n3,4\n".encode("utf-16"), [[1, 2], [3, 4]]),
        ("x,y,wide\u2028open\x85\n1,2,3\n3,4,5\n", [[1, 2], [3, 4]]),
        ("x,y,Straße\n1,2,ü\n3,4,ß\n".encode("latin-1"), [[1, 2], [3, 4]]),
    ],
)
def test_layouts_are_found_out(table, text, wanted):
    assert rows(table(text)) == wanted


def test_a_layout_found_wrongly_can_be_set(table):
    assert rows(table("x:y\n1,5:2\n", separator=":", decimal=",")) == [[1.5, 2]]


def test_files_without_a_header_have_numbered_columns(table):
    text = "stamp,0.5,1,2\nstamp,1.5,3,4\n"
    recording = table(text, position=[2, 3], time=1)
    assert rows(recording) == [[1, 2], [3, 4]]
    assert recording.times.tolist() == [0.5, 1.5]
    assert rows(table(",0,1\n0,1.5,2\n1,3.5,4\n", position=[0, 1])) == [[1.5, 2], [3.5, 4]]


def test_options_reach_both_steps_of_read(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(CSV)
    demos = read(path, trajectory="id", every=3, velocity="forward", window=2, scale=2)
    assert demos.trajectory_names == ("a", "b")
    assert demos.states[:3, 0].tolist() == [0, 6, 12]
    assert demos.actions[:3, 0] == pytest.approx([10, 10, 10])


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("t,a,b\n0,1,2\n", {}, r"columns 't', 'a', 'b', wanted columns x and y.*position=\['a', 'b'\]"),
        ("x,y\n1,2\n", {"time": "clock"}, "column 'clock': found columns 'x', 'y'"),
        ("x,y,x\n1,2,3\n", {}, "column 'x': found 2 columns of that name"),
        ("x,y\n1,2\n1,two\n", {}, "column 'y', data row 2, counted from 1: found 'two', wanted a number"),
        ("t;x;y\n0;1;2.5\n1;1;3,5\n", {}, r"data row 2, counted from 1: found '3,5'.*decimal=','"),
        ("x,y\n1,2\n1,1e400\n", {}, "column 'y', data row 2, counted from 1: found inf, wanted a finite number"),
        ("x,y\n1,2\n1," + "9" * 400 + "\n", {}, "column 'y', data row 2, counted from 1: found inf"),
        ("x,y\n1,2\n1,2,3\n", {}, "as many cells"),
        ("x,y\n1,2,3\n1,2,3\n", {}, "as many cells"),
        ('x,y\n1,2\n"1,2\n', {}, "EOF inside string"),
        ("x,y\n1,2\n\0\n", {}, "byte 8: found a zero byte"),
        ("x,y\n", {}, "found no row of data, wanted"),
        ("x,y\n,\n", {}, r"no complete row \(1 rows without a position dropped\)"),
        ("# only\n# comments\n", {}, "no line that is not"),
        (
            "t,x,y\nmorning,1,2\n",
            {},
            "column 't', data row 1, counted from 1: found 'morning', wanted a number, or a timestamp",
        ),
        ("x,y\n1,2\n", {"clock": "mend"}, "clock"),
        ("x,y\n1,2\n", {"scale": 0}, "scale"),
        ("x,y\n1,2\n", {"scale": float("nan")}, "scale"),
        ("x,y\n1,2\n", {"position": []}, "position"),
        ("x,y\n1,2\n", {"position": ["x", "x"]}, "different columns"),
        ("x,y\n1,2\n", {"position": 7}, "position"),
        ("x,y\n1,2\n", {"time": 1.5}, "time"),
        ("x,y\n1,2\n", {"separator": "::"}, "separator"),
        ("x,y\n1,2\n", {"decimal": "·"}, "decimal"),
        ("x,y\n1,2\n", {"colour": "red"}, "found colour=, wanted those of 'csv' files: action=, clock="),
        ("x,y\n1e308,2\n", {"scale": 100.0}, "positions at index"),
    ],
)
def test_bad_tables_are_refused_by_name_and_place(table, text, options, message):
    with pytest.raises(InputError, match=message):
        table(text, **options)


def test_rows_of_a_message_count_from_the_file_even_after_drops(table):
    with pytest.raises(ReadError, match=r"times at data row 4, "):
        table("t,x,y\n0,0,0\n1,,0\n2,0,0\n1,0,0\n")


def test_large_numbers_survive_to_the_last_digit(table):
    values = np.random.default_rng(0).normal(size=(200, 2))
    text = "x,y\n" + "".join(f"{a!r},{b!r}\n" for a, b in values.tolist())
    assert table(text).positions == pytest.approx(values, rel=1e-15)
