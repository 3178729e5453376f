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


def test_each_tap_of_an_arrow_key_moves_the_pen_and_the_pen_is_told_of(page: Any) -> None:
    page.focus("#plane")
    page.keyboard.press("p")
    assert page.text_content("#news") == "The pen is down."
    for _ in range(5):
        page.keyboard.press("ArrowRight")
    page.keyboard.press("p")
    assert page.text_content("#news") == "The pen is up."
    across = [y for _, y, _ in inside(page, "plane.strokes[0]")]
    assert across[-1] - across[0] >= 5 * 0.06 - 1e-6
    seen = inside(page, "(plane.cursor = () => { plane.crossed = true }, plane.draw(0), plane.crossed)")
    page.keyboard.press("Tab")
    assert seen
    assert not inside(page, "(plane.crossed = false, plane.draw(0), plane.crossed)")


@pytest.mark.parametrize("size", [(667, 375), (650, 450), (375, 667)])
def test_small_windows_hold_plane_and_buttons_whole(chromium: Any, server: Server, size: tuple[int, int]) -> None:
    with opened(chromium, server, viewport={"width": size[0], "height": size[1]}) as page:
        plane = page.locator("#plane").bounding_box()
        assert plane["width"] / plane["height"] == pytest.approx(4 / 3, abs=0.02)
        for each in page.query_selector_all(".tools button, #plane"):
            box = each.bounding_box()
            assert box["y"] + box["height"] <= size[1]
        found = page.locator(".found").bounding_box()
        assert (found["x"] > plane["x"] + plane["width"]) == (size[0] > size[1])
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
        for each in page.query_selector_all("button:not([hidden]), input:not([hidden]), summary"):
            assert min(each.bounding_box()["height"], each.bounding_box()["width"]) >= 44


def test_bars_and_dots_keep_their_colours_where_colours_are_forced(chromium: Any, server: Server) -> None:
    with opened(chromium, server, viewport=DESK, forced_colors="active") as page:
        draw(page, path(60)[:40], seconds=1)
        page.wait_for_selector("#goals .disc")
        for each in (".bar i", "#goals .disc", ".dot"):
            shown = page.evaluate("(name) => getComputedStyle(document.querySelector(name)).forcedColorAdjust", each)
            assert shown == "none"
        assert page.eval_on_selector(".found", "(part) => getComputedStyle(part).borderTopWidth") == "1px"


def test_discs_at_the_edge_are_whole(page: Any) -> None:
    assert inside(page, "plane.whole([0, 3], 20)") == [20, 20]
    assert inside(page, "plane.whole([300, 200], 20)") == [300, 200]


def test_it_fits_a_phone_and_is_drawn_on_by_finger(chromium: Any, server: Server) -> None:
    with opened(chromium, server, **PHONE) as page:
        touch(page, path())
        converged(page)
        assert page.text_content("#headline") == "4 subgoals"
        assert page.evaluate("document.documentElement.scrollWidth") <= 375
        for box in [each.bounding_box() for each in page.query_selector_all(".tools button")]:
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
        page.wait_for_selector("#message:has-text('Flown')", timeout=5_000)
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
