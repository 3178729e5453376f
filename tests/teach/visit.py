"""A visit to the page in a real browser: opening it, and what is asked of it again and again."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from tests.teach.hand import PLACES, inside
from tests.teach.made import TOKEN, Server

DESK = {"width": 1300, "height": 900}
PHONE = {"viewport": {"width": 375, "height": 667}, "has_touch": True, "is_mobile": True, "device_scale_factor": 2}
STROKES = "plane.strokes.map((stroke) => stroke.length)"


class opened:
    """A page in a context of its own."""

    def __init__(self, chromium: Any, server: Server, **how: Any) -> None:
        self.context, self.server, self.complaints = chromium.new_context(**how), server, []

    def __enter__(self) -> Any:
        page = self.context.new_page()
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("console", lambda line: self.complaints.append(line.text) if line.type == "error" else None)
        load(page, self.server)
        return page

    def __exit__(self, *failure: Any) -> None:
        self.context.close()
        if failure[0] is None:
            assert self.complaints == []


def load(page: Any, server: Server) -> None:
    page.goto(f"{server.address}/{TOKEN}/")
    page.wait_for_selector("#link.here")


def corners_missed(found: list[tuple[float, float]]) -> float:
    return max(min(math.dist(corner, each) for each in found) for corner in PLACES)


def counted(page: Any) -> list[tuple[float, float]]:
    goals = inside(page, "plane.answer.subgoals.filter((goal) => goal.counted)")
    return [(goal["y"], goal["z"]) for goal in goals]


def save(page: Any) -> Path:
    page.click("#save")
    page.wait_for_selector("#message:has-text('Saved in')", timeout=15_000)
    return Path(page.text_content("#message").removeprefix("Saved in "))


def photograph(page: Any) -> None:
    """A picture of the flight, on its way up and tilted, where one is asked for."""
    shots = os.environ.get("SUBGOAL_SCREENSHOTS")
    if not shots:
        return
    while inside(page, "plane.flight.z[plane.flight.row]") < 2.2 or (
        abs(inside(page, "plane.flight.tilt[plane.flight.row]")) < 0.08
    ):
        page.wait_for_timeout(20)
    Path(shots).mkdir(parents=True, exist_ok=True)
    page.screenshot(path=Path(shots) / "teach.png")
