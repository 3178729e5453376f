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
    sure = page.text_content("#certainty")
    page.wait_for_function(
        "(text) => document.querySelector('#news').textContent.includes(text)", arg=f"4 subgoals, {sure}"
    )
    folder = save(page)
    kept = [goal for goal in json.loads((folder / "summary.json").read_text())["subgoals"] if goal["counted"]]
    assert len(kept) == 4
    assert corners_missed([tuple(goal["position"]) for goal in kept]) < 0.12
    pytest.importorskip("rotorpy", reason="the flight extra is not installed")
    page.click("#fly")
    page.wait_for_selector("#flown:not([hidden])", timeout=30_000)
    numbers = page.text_content("#message").removeprefix("Flying ").split(" → ")
    assert sorted(numbers) == ["1", "2", "3", "4"]
    goals = [inside(page, f"plane.discs.find((each) => each.slot === {int(each) - 1}).goal") for each in numbers]
    assert [round(goal["y"]) for goal in goals] == [1, 1, -1, -1]
    assert goals[0]["z"] < goals[1]["z"]
    photograph(page)
    before = inside(page, "plane.flight.progress")
    page.wait_for_timeout(300)
    assert before < inside(page, "plane.flight.progress") <= 1
    assert max(map(abs, inside(page, "plane.flight.tilt"))) > 0.05
    inside(page, "(plane.flight.begun -= 60000)")
    page.wait_for_selector("#message:has-text('from your path')")
    assert page.text_content("#flown").endswith(" s · " + " → ".join(numbers))


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
    assert page.text_content("#news") == "The last stroke is taken away."
    page.focus("#clear")
    page.keyboard.press("Enter")
    assert page.text_content("#news") == "The sheet is empty."
    assert page.evaluate("document.activeElement.id") == "plane"
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
    assert page.text_content("#message") == "legs.csv: 41 points, columns y and z, in m"
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


def test_the_headline_has_the_bar_that_stands_out_and_words_where_another_is_likelier(page: Any) -> None:
    page.evaluate("""import("./panel.js").then(({ showAnswer }) => showAnswer({
        stage: "full", converged: true, status: "converged", n: 3, counts: { 3: 0.34, 4: 0.38, 5: 0.28 },
        subgoals: [1, 2, 3].map((y) => ({ y, z: 1, share: 0.3, radius: 55, inclusion: 1, counted: true })),
    }, "", [0, 1, 2]))""")
    assert page.text_content("#headline") == "3 subgoals"
    assert page.text_content(".bar.most b") == "3"
    assert page.text_content("#certainty").startswith(
        "34 % sure; 3 reach 5 % of the path on average, though 4 is likelier"
    )
    assert page.text_content("#goals .faint") == "± 55 units"


def test_the_pen_stays_on_the_plane(page: Any) -> None:
    [(x, y)] = on_screen(page, [(0.5, 0.5)])
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(5, 890, steps=20)
    page.mouse.up()
    for _, across, up in inside(page, "plane.strokes[0]"):
        assert -2 <= across <= 2
        assert 0 <= up <= 3
