"""The page in a real browser: reloads, broken connections, other tabs and other origins."""

from __future__ import annotations

import csv
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from threading import Thread
from typing import Any

import pytest

from subgoal.teach.limits import Limits
from tests.teach.hand import converged, draw, inside, on_screen, path
from tests.teach.made import TOKEN, Server, served
from tests.teach.visit import DESK, STROKES, load, opened, save

pytestmark = [
    pytest.mark.t1, pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning"),
]  # fmt: skip


def test_a_page_that_is_loaded_again_has_kept_the_work(page: Any) -> None:
    draw(page)
    converged(page)
    before = inside(page, "plane.strokes")
    page.reload()
    page.wait_for_selector("#link.here")
    converged(page)
    assert inside(page, "plane.strokes") == before
    assert page.text_content("#headline") == "4 subgoals"
    draw(page, path(40)[:30], seconds=0.5)
    page.click("#undo")
    assert inside(page, "plane.strokes") == before


def test_no_point_is_lost_when_the_connection_breaks_while_one_draws(page: Any) -> None:
    draw(page, half=lambda: inside(page, "link.socket.close()"))
    page.wait_for_selector("#link.here")
    converged(page)
    with (save(page) / "recording.csv").open() as stream:
        kept = [[float(row[name]) for name in ("time", "y", "z")] for row in csv.DictReader(stream)]
    assert kept == inside(page, "plane.strokes[0]")
    assert len(kept) > 80


def test_what_is_drawn_before_and_while_it_connects_is_kept(chromium: Any, server: Server) -> None:
    context = chromium.new_context(viewport=DESK)
    page = context.new_page()
    page.add_init_script("""{
        const send = WebSocket.prototype.send;
        WebSocket.prototype.send = function (text) { setTimeout(() => send.call(this, text), 900); };
    }""")
    page.goto(f"{server.address}/{TOKEN}/")
    draw(page, path(60)[:20], seconds=0.3)
    draw(page)
    converged(page)
    with (save(page) / "recording.csv").open() as stream:
        kept = [[float(row[name]) for name in ("time", "y", "z")] for row in csv.DictReader(stream)]
    assert kept == inside(page, "plane.strokes.flat()")
    assert len(inside(page, STROKES)) == 2
    assert not page.is_visible("#message.bad")
    context.close()


def test_what_came_too_fast_for_the_server_is_sent_again(chromium: Any, tmp_path: Path) -> None:
    limits = Limits(points_per_second=80.0, points_at_once=30)
    with served(tmp_path, limits) as slow, opened(chromium, slow, viewport=DESK) as page:
        draw(page, seconds=1)
        converged(page)
        with (save(page) / "recording.csv").open() as stream:
            assert len(list(csv.DictReader(stream))) == inside(page, STROKES)[0]
        assert not page.is_visible("#message.bad")


def test_a_stroke_that_was_cut_off_by_loading_anew_is_ended(page: Any) -> None:
    page.mouse.move(*on_screen(page, [(0.3, 0.3)])[0])
    inside(page, "(link.welcomed = false, link.socket.onclose = null, link.socket.close())")
    page.mouse.down()
    page.mouse.move(*on_screen(page, [(0.6, 0.3)])[0], steps=10)
    page.reload()
    page.wait_for_selector("#link.here")
    page.mouse.up()
    draw(page, path(60)[:30], seconds=0.5)
    page.wait_for_selector("#save:enabled")
    assert len(inside(page, STROKES)) == 2
    assert not page.is_visible("#message.bad")


def test_what_waits_to_be_sent_outlives_the_page(page: Any) -> None:
    def offline() -> None:
        inside(page, "(link.welcomed = false, link.socket.onclose = null, link.socket.close())")

    draw(page, half=offline)
    before = inside(page, STROKES)
    page.reload()
    page.wait_for_selector("#link.here")
    converged(page)
    assert inside(page, STROKES) == before
    assert inside(page, "link.waiting.length") == 0


def test_a_server_that_was_started_anew_is_told_of_and_the_drawing_can_be_kept(chromium: Any, server: Server) -> None:
    visit = opened(chromium, server, viewport=DESK)
    with visit as page:
        draw(page, seconds=0.8)
        page.wait_for_selector("#fly:enabled")
        points = inside(page, STROKES)[0]
        assert not page.is_visible("#keep")
        page.evaluate("""import("./main.js").then(({ link }) => {
            history.replaceState(null, "", "/another/");
            link.socket.close();
        })""")
        page.wait_for_selector("#message:has-text('started anew')", timeout=5_000)
        assert page.text_content("#link-text") == "not connected"
        for name in ("fly", "save", "csv", "json", "open"):
            assert page.is_disabled(f"#{name}")
        with page.expect_download() as begun:
            page.click("#keep")
        with Path(begun.value.path()).open() as stream:
            kept = list(csv.DictReader(stream))
        assert len(kept) == points
        assert list(kept[0]) == ["time", "y", "z", "stroke"]
        visit.complaints.clear()


def test_two_tabs_are_two_sessions(chromium: Any, server: Server) -> None:
    with opened(chromium, server, viewport=DESK) as one:
        other = one.context.new_page()
        load(other, server)
        one.bring_to_front()
        draw(one)
        other.bring_to_front()
        draw(other, [(0.1, 0.5), *[(0.1 + 0.008 * k, 0.5) for k in range(1, 100)]], seconds=1.5)
        for tab in (one, other):
            converged(tab)
        assert one.text_content("#headline") == "4 subgoals"
        assert other.text_content("#headline") == "1 subgoal"


def test_a_malformed_message_harms_nothing(page: Any) -> None:
    inside(page, 'link.socket.send(\'{"type": "points", "number": 1, "points": [[NaN, 0, 0]]}\')')
    page.wait_for_selector("#message.bad")
    draw(page)
    converged(page)
    assert page.text_content("#headline") == "4 subgoals"


def test_a_page_of_another_origin_gets_nothing(chromium: Any, server: Server) -> None:
    foreign = HTTPServer(("127.0.0.1", 0), Blank)
    Thread(target=foreign.serve_forever, daemon=True).start()
    context = chromium.new_context()
    page = context.new_page()
    page.goto(f"http://localhost:{foreign.server_port}/")
    socket = page.evaluate("""(url) => new Promise((done) => {
        const socket = new WebSocket(url);
        socket.onopen = () => done("open");
        socket.onerror = () => done("refused");
    })""", f"ws://127.0.0.1:{server.port}/{TOKEN}/live")  # fmt: skip
    asked = page.evaluate(
        "(url) => fetch(url, { mode: 'no-cors' }).then((a) => a.status || 'opaque', () => 'refused')",
        f"{server.address}/{TOKEN}/main.js",
    )
    context.close()
    foreign.shutdown()
    assert socket == "refused"
    assert asked == "refused"


class Blank(BaseHTTPRequestHandler):
    def do_GET(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.end_headers()
        self.wfile.write(b"<!doctype html><title>elsewhere</title>")

    def log_message(self, *_: Any) -> None:
        pass
