"""A page and its session over a socket: what is said, refused, logged, and found again."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from subgoal.teach.limits import Limits
from tests.teach.made import served

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")
LINE = [(0.05 * k, 0.02 * k, 1.0) for k in range(41)]
WRONG: dict[str, Any] = {
    "malformed": "no json",
    "out-of-range": {"type": "points", "number": 2, "points": [[0, 1e9, 0]]},
    "too-large": " " * 70_000,
    "out-of-order": {"type": "lift", "number": 9},
}


@pytest.mark.parametrize("code", WRONG)
def test_what_is_wrong_is_answered_and_the_next_right_message_done(code: str, tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do("begin")
        page.say(WRONG[code])
        assert page.hear("error")["code"] == code
        page.do("points", points=LINE)
        assert page.done()["points"] == len(LINE)


def test_bytes_that_are_no_file_are_answered(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.socket.send(b"\x00\x01")
        assert page.hear("error")["code"] == "malformed"


def test_hello_comes_first_and_once(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.connected() as page:
        page.do("begin")
        assert page.hear("error")["code"] == "out-of-order"
        page.hello()
        page.say({"type": "hello", "page": "page-0000", "session": None})
        assert page.hear("error")["code"] == "out-of-order"


def test_a_connection_that_never_says_hello_is_left(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.connected() as page:
        with pytest.raises(ConnectionClosed):
            for _ in range(30):
                page.say("no json")
                page.hear("error")
        with server.opened() as other:
            other.do("begin")
            assert other.done()["number"] == 1


def test_a_missing_number_is_asked_for(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do("begin")
        page.done()
        page.say({"type": "lift", "number": 3})
        error = page.hear("error", "done")
        assert (error.get("code"), error.get("expected")) == ("out-of-order", 2)


def test_what_was_done_is_not_done_again(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        for k in range(3):
            page.draw([(t + 10 * k, y, z) for t, y, z in LINE])
        number = page.do("undo")
        page.say({"type": "undo", "number": number})
        page.do("begin")
        assert page.done()["points"] == 2 * len(LINE)


def test_what_cannot_be_done_is_passed_over(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        number = page.do("undo")
        error = page.hear("error")
        assert (error["code"], error["number"]) == ("cannot", number)
        page.do("begin")
        assert page.done()["number"] == 2


def test_points_while_the_pen_is_up_are_refused(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do("points", points=LINE)
        assert page.hear("error")["code"] == "out-of-order"


def test_points_that_come_too_fast_may_come_again_later(tmp_path: Path) -> None:
    limits = Limits(points_per_second=500.0, points_at_once=50)
    with served(tmp_path, limits) as server, server.opened() as page:
        page.do("begin")
        page.do("points", points=LINE)
        message = {"type": "points", "number": 3, "points": [[t + 10, y, z] for t, y, z in LINE]}
        page.say(message)
        error = page.hear("error")
        assert (error["code"], error["number"]) == ("too-fast", 3)
        assert 0 < error["wait"] < 0.2
        time.sleep(error["wait"])
        page.say(message)
        page.number = 3
        assert page.done()["points"] == 2 * len(LINE)


def test_messages_that_come_too_fast_are_refused(tmp_path: Path) -> None:
    limits = Limits(messages_per_second=1.0, messages_at_once=2)
    with served(tmp_path, limits) as server, server.opened() as page:
        for _ in range(3):
            page.do("clear")
        assert page.hear("error")["code"] == "too-fast"


def test_each_kind_of_error_is_logged_once_for_a_session(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING, "subgoal.teach"), served(tmp_path) as server, server.opened() as page:
        for _ in range(20):
            page.say("no json")
            page.say({"type": "lift", "number": 9})
        for _ in range(40):
            page.hear("error")
    told = [record.getMessage() for record in caplog.records if record.name == "subgoal.teach"]
    assert len([text for text in told if ": malformed: " in text]) == 1
    assert len([text for text in told if ": out-of-order: " in text]) == 1


def test_two_sessions_do_not_see_each_other(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened("page-0001") as one, server.opened("page-0002") as other:
        one.draw(LINE)
        one.answer("settled")
        other.do("begin")
        assert other.done()["points"] == 0
        other.do("points", points=LINE[:3])
        assert other.answer("drawing")["pairs"] < 3


def test_errors_of_one_session_leave_another_alone(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened("page-0001") as one, server.opened("page-0002") as other:
        for wrong in WRONG.values():
            one.say(wrong)
        other.draw(LINE)
        assert other.done()["points"] == len(LINE)


def test_a_page_that_comes_back_finds_all_that_it_drew(tmp_path: Path) -> None:
    with served(tmp_path) as server:
        with server.connected() as page:
            session = page.hello()["session"]
            page.do("begin")
            page.do("points", points=LINE[:20])
            page.done()
        with server.connected() as page:
            welcome = page.hello(session)
            assert (welcome["session"], welcome["last"]) == (session, 2)
            assert welcome["drawing"]["strokes"] == [[list(point) for point in LINE[:20]]]
            assert welcome["drawing"]["drawn"]
            page.say({"type": "points", "number": 2, "points": LINE[:20]})
            page.do("points", points=LINE[20:])
            page.do("lift")
            assert page.done()["points"] == len(LINE)
            assert page.answer("settled")["pairs"] == 41


def test_a_page_that_is_loaded_anew_finds_the_answer_and_the_parameters(tmp_path: Path) -> None:
    with served(tmp_path) as server:
        with server.connected() as page:
            session = page.hello()["session"]
            page.do("tune", confidence=5.0, concentration=0.5)
            page.draw(LINE)
            full = page.answer("full")
        with server.connected() as page:
            welcome = page.hello(session, "page-0001")
            assert (welcome["confidence"], welcome["concentration"]) == (5.0, 0.5)
            assert page.hear("answer") == full


def test_a_copied_tab_gets_a_session_of_its_own(tmp_path: Path) -> None:
    with served(tmp_path, Limits(take_over_seconds=0.1)) as server, server.connected() as page:
        session = page.hello()["session"]
        page.draw(LINE)
        page.done()
        with server.connected() as copy:
            welcome = copy.hello(session, "page-0002")
            assert welcome["session"] != session
            assert welcome["drawing"]["strokes"] == []


def test_a_page_takes_its_session_up_while_the_server_still_holds_the_old_connection(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.connected() as page:
        session = page.hello()["session"]
        with server.connected() as again:
            assert again.hello(session)["session"] == session
            assert page.hear("error")["code"] == "closed"
            page.do("begin")
            again.do("begin")
            assert again.done()["number"] == 1


def test_what_is_said_after_the_session_went_on_elsewhere_is_refused(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.connected() as page:
        session = page.hello()["session"]
        with server.connected() as again:
            again.hello(session)
            assert page.hear("error")["code"] == "closed"
            page.say({"type": "clear", "number": 1})
            page.say("no json")
            assert page.hear("error")["code"] == "closed"
            again.do("begin")
            again.do("points", points=LINE)
            assert again.done()["points"] == len(LINE)


def test_an_unknown_session_is_a_new_one(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.connected() as page:
        assert page.hello("0123456789")["session"] != "0123456789"


def test_too_many_pages_are_refused_until_one_goes(tmp_path: Path) -> None:
    with served(tmp_path, Limits(sessions=1)) as server:
        with server.opened(), server.connected() as other:
            other.say({"type": "hello", "page": "page-0002", "session": None})
            assert other.hear("error", "welcome")["code"] == "full"
        with server.connected() as third:
            assert third.hello(None, "page-0003")["last"] == 0


def test_a_page_on_which_nothing_was_drawn_makes_room_first(tmp_path: Path) -> None:
    with served(tmp_path, Limits(sessions=2)) as server:
        with server.connected() as drawn:
            session = drawn.hello()["session"]
            drawn.do("begin")
            drawn.done()
        with server.opened("page-0002"):
            pass
        with server.connected() as third:
            third.hello(None, "page-0003")
            with server.connected() as again:
                assert again.hello(session)["last"] == 1
