"""A hand on a page in a real browser."""

from __future__ import annotations

import math
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

CORNERS = ((0.25, 0.8), (0.75, 0.8), (0.75, 0.2), (0.25, 0.2))
"""Of a square on the canvas, shares of its width and height: y from −1 to 1, z from 0.6 to 2.4."""
PLACES = tuple((4 * across - 2, 3 * (1 - down)) for across, down in CORNERS)
FLAGS = ("--no-sandbox", "--disable-quic")


@contextmanager
def browser() -> Iterator[Any]:
    """Debian's Chromium without a window; the test is skipped where there is none."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("no chromium on this machine: apt-get install chromium")
    with playwright.sync_playwright() as driver:
        started = driver.chromium.launch(executable_path=program, args=list(FLAGS))
        try:
            yield started
        finally:
            started.close()


def path(points: int = 160, corners: tuple[tuple[float, float], ...] = CORNERS) -> list[tuple[float, float]]:
    """Shares of the canvas along the closed path through the corners, slow at each."""
    count, made = points // len(corners), [corners[0]]
    for (a, b), (c, d) in zip(corners, (*corners[1:], corners[0]), strict=True):
        for k in range(1, count + 1):
            far = (1 - math.cos(math.pi * k / count)) / 2
            made.append((a + far * (c - a), b + far * (d - b)))
    return made


def on_screen(page: Any, places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Pixels of the window."""
    box = page.locator("#plane").bounding_box()
    return [(box["x"] + box["width"] * across, box["y"] + box["height"] * down) for across, down in places]


def draw(page: Any, places: list[tuple[float, float]] | None = None, seconds: float = 1.6, half: Any = None) -> None:
    """Draw with the mouse; ``half`` is called in the middle, pen down."""
    spots = on_screen(page, places or path())
    begin = time.monotonic()
    page.mouse.move(*spots[0])
    page.mouse.down()
    for k, spot in enumerate(spots[1:], 1):
        page.mouse.move(*spot)
        if half is not None and k == len(spots) // 2:
            half()
        time.sleep(max(0.0, begin + seconds * k / len(spots) - time.monotonic()))
    page.mouse.up()


def touch(page: Any, places: list[tuple[float, float]], seconds: float = 1.6) -> None:
    """Draw with a finger."""
    session = page.context.new_cdp_session(page)
    spots = on_screen(page, places)
    begin = time.monotonic()
    for k, (x, y) in enumerate(spots):
        kind = "touchStart" if k == 0 else "touchMove"
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": y}]})
        time.sleep(max(0.0, begin + seconds * k / len(spots) - time.monotonic()))
    session.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


def inside(page: Any, expression: str) -> Any:
    """The value of an expression of the page's own objects: link, pen, plane."""
    return page.evaluate(f"import('./main.js').then(({{ link, pen, plane }}) => ({expression}))")


def converged(page: Any) -> None:
    """Wait until the default run stands on the page."""
    page.wait_for_selector("#stage:text-is('converged')", timeout=15_000)
