"""The page in a real browser: what is drawn, found, saved and flown."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from tests.teach.hand import converged, draw, inside, on_screen, path
from tests.teach.visit import STROKES, corners_missed, counted, photograph, save

pytestmark = [
    pytest.mark.t1, pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning"),
]  # fmt: skip


def test_a_drawn_square_has_four_subgoals_on_screen_and_in_the_saved_file_and_is_flown(page: Any) -> None:
    assert page.is_visible("#invitation")
    draw(page, seconds=3)
    converged(page)
    assert page.text_content("#headline") == "4 subgoals"
    assert len(page.query_selector_all("#goals li .disc")) == 4
    assert corners_missed(counted(page)) < 0.12
    assert "4 subgoals" in page.text_content("#news")
    folder = save(page)
    kept = [goal for goal in json.loads((folder / "summary.json").read_text())["subgoals"] if goal["counted"]]
    assert len(kept) == 4
    assert corners_missed([tuple(goal["position"]) for goal in kept]) < 0.12
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    page.click("#fly")
    page.wait_for_selector("#flown:not([hidden])", timeout=30_000)
    assert "from your path" in page.text_content("#message")
    photograph(page)
    before = inside(page, "plane.flight.progress")
    page.wait_for_timeout(300)
    assert before < inside(page, "plane.flight.progress") <= 1
    assert max(map(abs, inside(page, "plane.flight.tilt"))) > 0.05


def test_subgoals_appear_while_the_pen_is_down(page: Any) -> None:
    seen = []
    draw(page, half=lambda: (page.wait_for_timeout(300), seen.append(page.text_content("#headline")),
                             seen.append(page.text_content("#stage"))))  # fmt: skip
    assert re.fullmatch(r"[1-3] subgoals?", seen[0])
    assert seen[1] == "while you draw"


def test_the_sliders_change_the_answer(page: Any) -> None:
    draw(page)
    converged(page)
    before = inside(page, "plane.answer")
    for name, value in (("confidence", "-0.5"), ("concentration", "1")):
        page.fill(f"#{name}", value)
    page.wait_for_selector("#confidence-value:text-is('α = 0.32')")
    page.wait_for_selector("#stage:text-is('settling')")
    after = inside(page, "plane.answer")
    assert after["number"] > before["number"]
    assert after["counts"] != before["counts"]


def test_undo_and_clear_leave_what_was_before(page: Any) -> None:
    draw(page, path(60)[:20], seconds=0.4)
    draw(page, path(60)[30:45], seconds=0.3)
    page.keyboard.press("Control+z")
    assert len(inside(page, STROKES)) == 1
    page.click("#clear")
    assert inside(page, STROKES) == []
    assert page.text_content("#headline") == "No subgoals yet"
    assert page.is_disabled("#fly")


def test_a_recording_is_opened_and_waypoints_come_out(page: Any, tmp_path: Path) -> None:
    legs = tmp_path / "legs.csv"
    rows = [f"{0.1 * k},{min(k, 20) * 0.1 - 1},{0.5 + max(k - 20, 0) * 0.1}" for k in range(41)]
    legs.write_text("\n".join(["t,y,z", *rows]))
    page.set_input_files("#file", legs)
    converged(page)
    assert page.text_content("#headline") == "2 subgoals"
    with page.expect_download() as begun:
        page.click("#csv")
    lines = Path(begun.value.path()).read_text().splitlines()
    assert "y" in lines[0].split(",")
    assert len(lines) == 3


def test_what_is_no_recording_is_refused_with_a_sentence(page: Any, tmp_path: Path) -> None:
    wrong = tmp_path / "photo.jpg"
    wrong.write_bytes(b"\xff\xd8\xff")
    page.set_input_files("#file", wrong)
    page.wait_for_selector("#message.bad")
    assert "wanted" in page.text_content("#message")


def test_the_pen_stays_on_the_plane(page: Any) -> None:
    [(x, y)] = on_screen(page, [(0.5, 0.5)])
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(5, 890, steps=20)
    page.mouse.up()
    for _, across, up in inside(page, "plane.strokes[0]"):
        assert -2 <= across <= 2
        assert 0 <= up <= 3
