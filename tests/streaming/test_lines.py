"""Lines as they are written, and samples from them."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import pytest

from subgoal.runtime.errors import InputError, ReadError
from subgoal.streaming.lines import GrowingFile, Piped, lines_of
from subgoal.streaming.rows import Columns, is_empty


class Scripted:
    """A source that gives what it is told to."""

    def __init__(self, pieces: Iterable[bytes | None]) -> None:
        self._pieces = iter(pieces)

    def read(self) -> bytes | None:
        return next(self._pieces)


def test_lines_are_whole_however_they_come() -> None:
    found = list(lines_of(Scripted([b"\xef\xbb\xbfx,", b"", "y\r\n1,ü".encode()[:-1], b"\xbc\n\n3", b"", None])))
    assert found == ["x,y", None, "1,ü", "", None, "3"] or found == [None, "x,y", "1,ü", "", None, "3"]


def test_the_last_line_needs_no_end_unless_it_was_stopped() -> None:
    assert list(lines_of(Scripted([b"a\nb", None]))) == ["a", "b"]
    calls = iter([False, True])
    assert list(lines_of(Scripted([b"a\nb", None]), stopped=lambda: next(calls))) == ["a"]


def test_patience_ends() -> None:
    assert list(lines_of(Scripted([b"a\n", b"", b"b\n"]), patience=0.0)) == ["a"]


def test_a_file_is_read_on_when_it_has_grown(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("one\ntw")
    lines = lines_of(GrowingFile(path))
    assert [next(lines), next(lines)] == ["one", None]
    with path.open("a") as stream:
        stream.write("o\n")
    assert next(lines) == "two"
    assert next(lines) is None


def test_a_file_made_shorter_or_replaced_is_noticed(tmp_path: Path) -> None:
    path, other = tmp_path / "a.csv", tmp_path / "b.csv"
    path.write_text("one\ntwo\n")
    sources = GrowingFile(path), GrowingFile(path)
    assert [(source.read(), source.read(), source.rewritten) for source in sources] == [(b"one\ntwo\n", b"", False)] * 2
    path.write_text("one\n")
    assert (sources[0].read(), sources[0].rewritten) == (b"", True)
    other.write_text("one\ntwo\nthree\n")
    other.replace(path)
    assert (sources[1].read(), sources[1].rewritten) == (b"", True)


def test_a_pipe_ends_when_it_is_closed() -> None:
    reading, writing = os.pipe()
    lines = (line for line in lines_of(Piped(reading)) if line is not None)
    os.write(writing, b"one\ntwo\nth")
    assert [next(lines), next(lines)] == ["one", "two"]
    os.write(writing, b"ree")
    os.close(writing)
    assert list(lines) == ["three"]


def test_columns_are_found_by_name() -> None:
    columns = Columns.of("id; stamp ;x;y", position=("y", "x"), time="stamp", trajectory="id")
    assert columns.row("a;0.5;1;2") == (0.5, (2.0, 1.0), "a")
    assert Columns.of("t\tx", position=("x",), time="t").row("1\t2").trajectory == ""
    assert Columns.of("t,x:y", position=("t,x",), time="y", separator=":").row("1:2") == (2.0, (1.0,), "")


def test_numbers_may_have_a_decimal_comma_where_no_comma_parts_columns() -> None:
    assert Columns.of("t;x", position=("x",), time="t").row("0,5;-1,25")[:2] == (0.5, (-1.25,))
    assert Columns.of("t;x", position=("x",), time="t").row("0.5;-1.25")[:2] == (0.5, (-1.25,))
    assert Columns.of("t,x", position=("x",), time="t", decimal=",").row('"0,5","-1,25"')[:2] == (0.5, (-1.25,))
    with pytest.raises(InputError, match="'0,5', wanted numbers"):
        Columns.of("t;x", position=("x",), time="t", decimal=".").row("0,5;1")


def test_a_column_that_is_not_there_is_told() -> None:
    with pytest.raises(ReadError, match="header at line 1: found columns a, b, wanted columns x, t"):
        Columns.of("a,b", position=("x",), time="t")


@pytest.mark.parametrize(
    ("line", "told"),
    [("1", "1 fields, wanted 2"), ("1,2,3", "3 fields, wanted 2, as the header has"),
     ("1,here", "'here', wanted numbers")],
)  # fmt: skip
def test_a_line_that_is_no_sample_is_told(line: str, told: str) -> None:
    with pytest.raises(InputError, match=told):
        Columns.of("t,x", position=("x",), time="t").row(line)


def test_blank_lines_and_comments_are_empty() -> None:
    assert [line for line in ("", "  ", "# a", "1,2") if is_empty(line)] == ["", "  ", "# a"]
