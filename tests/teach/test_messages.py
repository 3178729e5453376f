"""Each message is checked field by field."""

from __future__ import annotations

import json
from typing import Any

import pytest

from subgoal.teach.limits import Limits
from subgoal.teach.messages import Dropped, Hello, Points, RefusedError, Tune, parse

LIMITS = Limits(message_bytes=2000, batch_points=3, file_bytes=10, reach=5.0, seconds=100.0)
POINT = [1.0, 0.5, 0.5]


def refused(message: Any) -> str:
    with pytest.raises(RefusedError) as problem:
        parse(message if isinstance(message, (str, bytes)) else json.dumps(message), LIMITS)
    return problem.value.code


def points(*rows: Any) -> dict[str, Any]:
    return {"type": "points", "number": 1, "points": list(rows)}


def test_points_become_tuples_of_floats() -> None:
    found = parse(json.dumps(points([1, 0.5, 2])), LIMITS)
    assert found == Points(1, ((1.0, 0.5, 2.0),))


def test_hello_with_and_without_a_session() -> None:
    assert parse('{"type": "hello", "page": "abcdefgh", "session": null}', LIMITS) == Hello("abcdefgh", None)
    assert parse('{"type": "hello", "page": "abcdefgh", "session": "12345678"}', LIMITS) == Hello(
        "abcdefgh", "12345678"
    )


def test_parameters() -> None:
    text = '{"type": "tune", "number": 7, "confidence": 2, "concentration": 0.5}'
    assert parse(text, LIMITS) == Tune(7, 2.0, 0.5)


def test_a_file_is_a_line_and_its_bytes() -> None:
    assert parse(b'{"type": "file", "number": 2, "name": "a.csv"}\nx,y\n1,2', LIMITS) == Dropped(
        2, "a.csv", b"x,y\n1,2"
    )


@pytest.mark.parametrize("message", [
    "", "no json", "[]", "3", "null", '"hello"', "{", "[" * 1500, {}, {"type": None}, {"type": "nothing", "number": 1},
    '{"type": "points", "number": 1, "points": [[NaN, 1, 1]]}',
    '{"type": "points", "number": 1, "points": [[1, Infinity, 1]]}',
    {"type": ["begin"], "number": 1}, {"type": {}, "number": 1}, {"type": "begin"}, {"type": "begin", "number": "1"},
    {"type": "begin", "number": True}, {"type": "begin", "number": 1.5}, {"type": "begin", "number": 0},
    {"type": "begin", "number": 1, "more": 2}, points(), points([1, 2]), points([1, 2, 3, 4]), points({"t": 1}),
    points([1, "2", 3]), points([1, None, 3]), points([True, 1, 1]), {"type": "points", "number": 1, "points": "123"},
    {"type": "points", "number": 1}, {"type": "hello"}, {"type": "hello", "page": "short"},
    {"type": "hello", "page": "abcdefgh", "session": 5}, {"type": "hello", "page": "abcdefgh", "session": "../../etc"},
    {"type": "tune", "number": 1, "confidence": 3},
    {"type": "tune", "number": 1, "confidence": "3", "concentration": 1},
    {"type": "export", "number": 1, "format": "exe"}, {"type": "export", "number": 1}, b"", b"no line",
    b"\xff\xfe\nabc", b'{"type": "begin", "number": 1}\nabc', b'{"type": "file", "number": 1}\nabc',
    b'{"type": "file", "number": 1, "name": ""}\nabc', b'{"type": "file", "number": 1, "name": "\\ud800"}\nabc',
    b'{"type": "file", "name": "a.csv"}\nabc', b'{"type": "file", "number": 1, "name": "a.csv", "more": 1}\nabc',
])  # fmt: skip
def test_malformed(message: Any) -> None:
    assert refused(message) == "malformed"


@pytest.mark.parametrize("message", [
    points([-1, 0, 0]), points([101, 0, 0]), points([1, 5.1, 0]), points([1, 0, -5.1]), points([1, 0, 1e300]),
    points([1, 10**400, 0]), {"type": "tune", "number": 1, "confidence": 0, "concentration": 1},
    {"type": "tune", "number": 1, "confidence": 1e9, "concentration": 1},
    {"type": "tune", "number": 1, "confidence": 3, "concentration": -1},
    '{"type": "tune", "number": 1, "confidence": 1e999, "concentration": 1}',
])  # fmt: skip
def test_out_of_range(message: Any) -> None:
    assert refused(message) == "out-of-range"


@pytest.mark.parametrize("message", [
    points(POINT, POINT, POINT, POINT), " " * 2001, '"' + "é" * 1500 + '"',
    b'{"type": "file", "number": 1, "name": "a.csv"}\n' + b"0" * 11,
])  # fmt: skip
def test_too_large(message: Any) -> None:
    assert refused(message) == "too-large"
