"""A page and its session over a socket: what is answered to a drawing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.teach.made import CORNERS, served, square

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")
LINE = [(0.05 * k, 0.02 * k, 1.0) for k in range(41)]


def test_a_square_has_its_four_corners(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square())
        found = page.answer("settled")
    assert (found["n"], found["converged"]) == (4, True)
    places = np.array([[goal["y"], goal["z"]] for goal in found["subgoals"] if goal["counted"]])
    gaps = np.linalg.norm(places[:, None] - CORNERS[None], axis=2).min(axis=1)
    assert gaps.max() < 0.1
    assert {cut["stroke"] for cut in found["segments"]} == {0}


def test_subgoals_appear_while_the_pen_is_down(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do("begin")
        points = square()
        page.do("points", points=points[: 3 * len(points) // 4])
        found = page.answer("drawing")
        assert found["n"] >= 2


def test_a_long_rest_with_the_pen_down_is_learned_from_too(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do("begin")
        page.do("points", points=[*LINE, *((t + 90, y, z + 0.02 * k) for k, (t, y, z) in enumerate(LINE))])
        assert page.answer("drawing")["n"] >= 1


def test_an_answer_to_a_drawing_that_is_gone_is_not_sent(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square())
        number = page.do("clear")
        while (found := page.hear("answer"))["number"] < number:
            pass
        assert found["subgoals"] == []


def test_other_parameters_give_another_answer(tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(square())
        before = page.answer("settled")
        number = page.do("tune", confidence=0.2, concentration=0.01)
        while (after := page.hear("answer"))["number"] < number:
            pass
    assert after["n"] != before["n"]


@pytest.mark.parametrize("points", [[(0.0, 0.0, 1.0)], [(0.1 * k, 0.5, 0.5) for k in range(20)]])
def test_what_does_not_move_has_no_subgoals_and_says_why(points: Any, tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.draw(points)
        while (found := page.hear("answer"))["number"] < page.number:
            pass
    assert found["subgoals"] == []
    assert found["status"] == "Draw a little more."


@pytest.mark.parametrize("kind", ["fly", "save", "export"])
def test_an_empty_sheet_is_not_flown_or_saved(kind: str, tmp_path: Path) -> None:
    with served(tmp_path) as server, server.opened() as page:
        page.do(kind, **({"format": "csv"} if kind == "export" else {}))
        assert page.hear("error")["code"] == "cannot"
    assert not any(tmp_path.iterdir())
