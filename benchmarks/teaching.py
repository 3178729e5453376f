"""The page for teaching: how soon subgoals stand on the screen, and what twenty teachers at once lose.

``python -m benchmarks.teaching`` prints one table. In a real browser (Chromium) a drawing of 600 points is made again
and again; the time is that from pen-up, in the page, until the frame with the subgoals has been drawn, by
``performance.now()``. Then 20 clients on loopback send 60 points a second in strokes of ten seconds, six each, with two
seconds between; they do not end together. What the server holds is compared with what was sent, point by point. Server
and clients are processes on this machine. ``--quick`` does less of each.
"""

from __future__ import annotations

import asyncio
import json
import math
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

from benchmarks.common import Row
from subgoal.teach.drawing import Drawing
from subgoal.teach.learning import Tuning
from subgoal.teach.limits import Limits
from subgoal.teach.live import Live

POINTS, RATE, SCREEN_MS = 600, 100.0, 200.0
TEACHERS, STREAM_RATE, STROKE, REST = 20, 60, 10, 2.0
POINT_MS, ACKNOWLEDGED_MS = 2.0, 250.0
FLAGS = ["--no-sandbox", "--disable-quic"]
WATCH = """() => {
    window.waited = [];
    let lifted = null;
    addEventListener("pointerup", () => { lifted = performance.now(); }, true);
    new MutationObserver(() => {
        if (lifted === null || document.getElementById("stage").textContent !== "settling") return;
        const since = lifted;
        lifted = null;
        requestAnimationFrame(() => setTimeout(() => window.waited.push(performance.now() - since), 0));
    }).observe(document.getElementById("stage"), { childList: true, characterData: true, subtree: true });
}"""
Point = tuple[float, float, float]


@contextmanager
def serving() -> Iterator[str]:
    """The address of a server in a process of its own, without its scheme."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "subgoal.cli.main", "teach", "--no-open", "--out", folder]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            try:
                told = next((line for line in process.stdout or () if "http://" in line), "http://")
                yield told.split("http://")[1].strip()
            finally:
                process.send_signal(signal.SIGINT)


def corners(k: int) -> list[tuple[float, float]]:
    """Of the k-th polygon of 3 to 6 corners, shares of a canvas."""
    count = 3 + k % 4
    turns = [2 * math.pi * (each + 0.1 * (k % 7)) / count for each in range(count)]
    return [(0.5 + 0.33 * math.cos(turn), 0.5 + 0.38 * math.sin(turn)) for turn in turns]


def path(k: int, points: int) -> list[tuple[float, float]]:
    """``points`` places along it, slow at each corner."""
    spots = corners(k)
    made = []
    for i in range(points):
        leg, far = divmod(i * len(spots) / points, 1.0)
        (a, b), (c, d) = spots[int(leg)], spots[(int(leg) + 1) % len(spots)]
        gone = (1 - math.cos(math.pi * far)) / 2
        made.append((a + gone * (c - a), b + gone * (d - b)))
    return made


def on_screen(drawings: int) -> Row:
    """From the last of 600 points to subgoals on the screen."""
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium") or shutil.which("google-chrome")
    with serving() as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=FLAGS)
        page = browser.new_page(viewport={"width": 1300, "height": 900})
        page.goto(f"http://{address}")
        page.wait_for_selector("#link.here")
        page.evaluate(WATCH)
        held = [_draw(page, k) for k in range(drawings)]
        waited = np.array(page.evaluate("window.waited"))
        browser.close()
    p50, p95 = np.percentile(waited, [50, 95])
    told = f"on screen after {POINTS} points, {len(waited)} drawings of {min(held)}+, median {p50:.0f} ms, p95"
    return Row(told, f"{p95:.0f} ms", f"< {SCREEN_MS:.0f} ms", len(waited) == drawings and p95 < SCREEN_MS)


def _draw(page: Any, k: int) -> int:
    """One drawing by the mouse, on an empty sheet; how many points the page took."""
    box = page.locator("#plane").bounding_box()
    spots = [(box["x"] + box["width"] * a, box["y"] + box["height"] * b) for a, b in path(k, POINTS)]
    begin = time.monotonic()
    page.mouse.move(*spots[0])
    page.mouse.down()
    for i, spot in enumerate(spots):
        page.mouse.move(*spot)
        time.sleep(max(0.0, begin + i / RATE - time.monotonic()))
    page.mouse.up()
    page.wait_for_selector("#stage:text-is('settling')", timeout=10_000)
    page.wait_for_selector("#stage:not(:text-is('settling'))", timeout=10_000)
    points = page.evaluate("import('./main.js').then(({ plane }) => plane.strokes[0].length)")
    page.click("#clear")
    return int(points)


def per_point() -> Row:
    """Of the server, alone: checking, keeping and learning from a point, with an answer for every three of them."""
    times = []
    for k in range(6):
        drawing, live = Drawing(Limits()), Live()
        drawing.begin()
        spots = path(k, POINTS)
        for i in range(0, POINTS, 3):
            batch = tuple((j / STREAM_RATE, 4 * a - 2, 3 - 3 * b) for j, (a, b) in enumerate(spots[i : i + 3], i))
            begin = time.perf_counter()
            drawing.add(batch)
            if i > 30:
                live.answer(drawing.sheet(), Tuning())
            times.append((time.perf_counter() - begin) / len(batch) * 1000)
    p50, p95 = np.percentile(times, [50, 95])
    told = f"server time for each point and its share of an answer, median {p50:.2f} ms, p95"
    return Row(told, f"{p95:.2f} ms", f"< {1000 / STREAM_RATE:.1f} ms", p95 < 1000 / STREAM_RATE)


class Teacher:
    """A client that draws, and measures how long the server takes to say that a message is done."""

    def __init__(self, k: int, seconds: float) -> None:
        self.k, self.seconds = k, seconds
        self.strokes: list[list[Point]] = []
        self.waits: list[float] = []
        self.settled: list[float] = []
        self._number, self._sent, self._lifted = 0, dict[int, float](), 0.0

    async def teach(self, address: str) -> bool:
        """Draw for a while, come back, and see whether the server holds what was sent."""
        uri, origin = f"ws://{address}live", f"http://{address.split('/')[0]}"
        await asyncio.sleep(self.k * STROKE / TEACHERS)
        async with connect(uri, origin=origin, proxy=None, max_size=None) as socket:  # type: ignore[arg-type]
            session = (await self._hello(socket, None))["session"]
            hearing = asyncio.create_task(self._hear(socket))
            await self._draw(socket)
            await hearing
        async with connect(uri, origin=origin, proxy=None, max_size=None) as socket:  # type: ignore[arg-type]
            held = (await self._hello(socket, session))["drawing"]["strokes"]
        return bool(held == [[list(point) for point in stroke] for stroke in self.strokes])

    async def _hello(self, socket: ClientConnection, session: str | None) -> Any:
        await socket.send(json.dumps({"type": "hello", "page": f"teacher-{self.k}", "session": session}))
        while (message := json.loads(await socket.recv()))["type"] != "welcome":
            pass
        return message

    async def _do(self, socket: ClientConnection, kind: str, **fields: Any) -> None:
        self._number += 1
        self._sent[self._number] = time.perf_counter()
        await socket.send(json.dumps({"type": kind, "number": self._number, **fields}))

    async def _draw(self, socket: ClientConnection) -> None:
        begin, k = time.perf_counter(), 0
        while k < self.seconds * STREAM_RATE:
            self.strokes.append([])
            await self._do(socket, "begin")
            for a, b in path(self.k + len(self.strokes), STROKE * STREAM_RATE):
                point = (k / STREAM_RATE + REST * len(self.strokes), round(4 * a - 2, 6), round(3 - 3 * b, 6))
                self.strokes[-1].append(point)
                await self._do(socket, "points", points=[point])
                k += 1
                await asyncio.sleep(max(0.0, begin + k / STREAM_RATE - time.perf_counter()))
            self._lifted = time.perf_counter()
            await self._do(socket, "lift")
            begin += REST
            await asyncio.sleep(REST)

    async def _hear(self, socket: ClientConnection) -> None:
        """Until the answer to everything that was sent is there."""
        whole = -(-int(self.seconds) // STROKE) * (STROKE * STREAM_RATE + 2)
        while True:
            message, now = json.loads(await socket.recv()), time.perf_counter()
            if message["type"] == "done":
                for number in [each for each in self._sent if each <= message["number"]]:
                    self.waits.append(1000 * (now - self._sent.pop(number)))
            elif message["type"] == "answer" and message["stage"] != "drawing" and self._lifted:
                self.settled.append(1000 * (now - self._lifted))
                self._lifted = 0.0
                if message["number"] >= whole:
                    return


def many_teachers(seconds: float) -> list[Row]:
    """Twenty at once."""

    async def all_of_them(address: str) -> tuple[list[Teacher], list[bool]]:
        teachers = [Teacher(k, seconds) for k in range(TEACHERS)]
        return teachers, await asyncio.gather(*(each.teach(address) for each in teachers))

    with serving() as address:
        teachers, held = asyncio.run(all_of_them(address))
    waits, settled = (np.concatenate([getattr(each, name) for each in teachers]) for name in ("waits", "settled"))
    strokes = sum(len(each.strokes) for each in teachers)
    points = sum(len(stroke) for each in teachers for stroke in each.strokes)
    told = f"{TEACHERS} teachers at once for {seconds:g} s: {strokes} strokes, {points:,} points, held as sent"
    rows = [Row(told, f"{sum(held)} of {TEACHERS}", "all", all(held))]
    p50, p95 = np.percentile(waits, [50, 95])
    rows.append(Row(f"their points taken, median {p50:.1f} ms, p95", f"{p95:.0f} ms", f"< {ACKNOWLEDGED_MS:.0f} ms",
                    bool(p95 < ACKNOWLEDGED_MS)))  # fmt: skip
    p50, p95 = np.percentile(settled, [50, 95])
    rows.append(Row(f"their answers after pen-up, median {p50:.0f} ms, p95", f"{p95:.0f} ms", "", True))
    return rows


def main() -> int:
    """1 if a target is missed."""
    quick = "--quick" in sys.argv[1:]
    rows = [per_point()]
    print(rows[-1], flush=True)
    rows.append(on_screen(4 if quick else 40))
    print(rows[-1], flush=True)
    for row in many_teachers(10 if quick else 60):
        print(row, flush=True)
        rows.append(row)
    return 0 if all(row.met for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
