"""The page in a real browser for everybody: keys, fingers, phones, dark, without motion."""

from __future__ import annotations

import re
from typing import Any

import pytest

from tests.teach.hand import converged, draw, inside, path, touch
from tests.teach.made import Server
from tests.teach.visit import DESK, PHONE, STROKES, opened

pytestmark = [
    pytest.mark.t1, pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning"),
]  # fmt: skip


def test_one_can_draw_with_the_keyboard_alone(page: Any) -> None:
    for _ in range(12):
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement.id") == "plane":
            break
    else:
        pytest.fail("the plane is not reached by Tab")
    page.keyboard.down(" ")
    for key in ("ArrowRight", "ArrowUp"):
        page.keyboard.down(key)
        page.wait_for_timeout(1300)
        page.keyboard.up(key)
    page.keyboard.up(" ")
    converged(page)
    assert page.text_content("#headline") == "2 subgoals"
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "fly"
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") != "none"


def test_p_puts_the_pen_down_and_lifts_it(page: Any) -> None:
    page.focus("#plane")
    page.keyboard.press("p")
    assert inside(page, "pen.down")
    page.keyboard.press("p")
    assert not inside(page, "pen.down")
    assert inside(page, STROKES) == [1]


def test_it_fits_a_phone_and_is_drawn_on_by_finger(chromium: Any, server: Server) -> None:
    with opened(chromium, server, **PHONE) as page:
        touch(page, path())
        converged(page)
        assert page.text_content("#headline") == "4 subgoals"
        assert page.evaluate("document.documentElement.scrollWidth") <= 375
        for box in [each.bounding_box() for each in page.query_selector_all("button")]:
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= 375
            assert box["y"] + box["height"] <= 667
            assert box["height"] >= 44
        assert page.evaluate("scrollY") == 0


def test_with_reduced_motion_the_flight_is_shown_at_once(chromium: Any, server: Server) -> None:
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    with opened(chromium, server, viewport=DESK, reduced_motion="reduce") as page:
        draw(page)
        page.wait_for_selector("#fly:enabled")
        page.click("#fly")
        page.wait_for_selector("#flown:not([hidden])", timeout=30_000)
        page.wait_for_selector("#flown:has-text('Flown')", timeout=5_000)
        assert inside(page, "plane.flight.progress") == 1


def test_dark_and_light(chromium: Any, server: Server) -> None:
    grounds = {}
    for scheme in ("dark", "light"):
        with opened(chromium, server, viewport=DESK, color_scheme=scheme) as page:
            colours = page.evaluate("""[getComputedStyle(document.documentElement).backgroundColor,
                getComputedStyle(document.body).color]""")
            grounds[scheme] = [sum(map(int, re.findall(r"\d+", each)[:3])) for each in colours]
            assert inside(page, "plane.ink.card") == ("#1a2026" if scheme == "dark" else "#ffffff")
    assert grounds["dark"][0] < 150 < 500 < grounds["dark"][1]
    assert grounds["light"][1] < 200 < 600 < grounds["light"][0]


def test_every_control_has_a_name_and_is_reached_by_tab(page: Any) -> None:
    nameless = page.evaluate("""[...document.querySelectorAll("button, input, canvas, summary")].filter((each) => !(
        each.getAttribute("aria-label") || each.labels?.[0]?.textContent.trim() || each.textContent.trim()
    )).map((each) => each.id)""")
    assert nameless == []
    draw(page, path(60)[:40], seconds=1)
    page.wait_for_selector("#fly:enabled")
    reached = []
    page.focus("#plane")
    for _ in range(11):
        reached.append(page.evaluate("document.activeElement.id || document.activeElement.tagName"))
        page.keyboard.press("Tab")
    assert reached == ["plane", "fly", "undo", "clear", "save", "csv", "json", "open", "confidence", "concentration",
                       "SUMMARY"]  # fmt: skip
    assert page.get_attribute("html", "lang") == "en"
    assert page.get_attribute("#news", "aria-live") == "polite"
