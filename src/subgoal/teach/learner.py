"""Keeps a session's answer up with its drawing: the newest state wins, and nothing that was drawn is left out."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from pathlib import Path
from typing import Any

from subgoal.answers.subgoals import Subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError, SubgoalError
from subgoal.teach.drawing import Drawing, Sheet
from subgoal.teach.files import read_dropped, save_project
from subgoal.teach.flying import flown, waypoint_text
from subgoal.teach.learning import DRAWING, FULL, SETTLED, Answer, Tuning, demonstrations_of, learn
from subgoal.teach.limits import Limits
from subgoal.teach.live import Live
from subgoal.teach.messages import RefusedError
from subgoal.teach.picture import nothing, picture, shown
from subgoal.teach.workshop import Lane, Workshop

LOG = logging.getLogger("subgoal.teach")
PAUSE = 0.05
"""Seconds between two answers while the pen is down."""
IDLE = 0.3
"""Seconds without a change before the default run begins."""
TOO_LITTLE = "Draw a little more."
Send = Callable[[dict[str, Any]], None]
Act = Callable[[Sheet, Subgoals, Posterior], Coroutine[Any, Any, None]]


class Learner:
    """The answers of one session, computed in threads; called from the event loop alone."""

    def __init__(self, drawing: Drawing, limits: Limits, workshop: Workshop, out: Path, send: Send) -> None:
        self._drawing, self._limits, self._workshop, self._out, self._send = drawing, limits, workshop, out, send
        self.tuning = Tuning()
        self._number = 0
        self._changed, self._lifted = asyncio.Event(), asyncio.Event()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._watching: asyncio.Task[None] | None = None
        self._resting: asyncio.Task[None] | None = None
        self._flying: asyncio.Task[None] | None = None
        self._flown = self._key()
        self._learned: tuple[Any, Answer | None] = (None, None)
        self._said: dict[str, Any] | None = None
        self._live = Live()

    def look(self, number: int) -> None:
        """Operation ``number`` has been done: see whether the drawing or the parameters are other than before."""
        self._number = number
        if self._learned[0] == self._key() and self._said is not None:
            return
        self._changed.set()
        if self._resting is not None:
            self._resting.cancel()
        flying = self._flying
        if flying is not None and not flying.done() and self._flown != self._key():
            flying.cancel()
            self._send({"type": "error", "code": "cannot", "text": "The drawing has changed: that flight was left."})
        if not self._drawing.drawn:
            self._lifted.set()
        if self._watching is None or self._watching.done():
            self._watching = self._start(self._watch())

    def tune(self, confidence: float, concentration: float) -> None:
        """Other parameters."""
        self.tuning = Tuning(confidence, concentration)

    def say_again(self) -> None:
        """The last answer, for a page that has come back."""
        if self._said is not None:
            self._send(self._said)

    def read(self, name: str, content: bytes) -> None:
        """A file in place of the drawing."""
        self._start(self._read(name, content))

    def fly(self) -> None:
        """Fly the subgoals of the drawing as it is; left if it changes. Raises ``RefusedError`` during another one."""
        if self._flying is not None and not self._flying.done():
            raise RefusedError("cannot", "A flight is being prepared already.")
        self._flown = self._key()
        self._flying = self._start(self._of_full("fly", self._fly))

    def save(self) -> None:
        """Write a project folder."""
        self._start(self._of_full("save", self._save))

    def export(self, kind: str) -> None:
        """Send waypoints."""
        self._start(self._of_full("export", lambda sheet, found, posterior: self._export(kind, posterior)))

    def close(self) -> None:
        """Nothing more is computed."""
        for task in self._tasks:
            task.cancel()

    def _key(self) -> tuple[int, Tuning]:
        return self._drawing.revision, self.tuning

    def _start(self, work: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        task = asyncio.get_running_loop().create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)
        return task

    def _ended(self, task: asyncio.Task[Any]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and task.exception() is not None:
            LOG.error("a computation failed", exc_info=task.exception())
            self._send({"type": "error", "code": "failed", "text": "Something went wrong here; the log says more."})

    async def _watch(self) -> None:
        """Answers until the drawing stands still; then, if it goes on to, the default run is made of it."""
        while self._changed.is_set():
            self._changed.clear()
            self._lifted.clear()
            if self._drawing.drawn:
                await self._unless_lifted(self._answer(DRAWING, Lane.MEANWHILE))
                await self._unless_lifted(asyncio.sleep(PAUSE))
            else:
                await self._answer(SETTLED, Lane.WAITED_FOR)
        if not self._drawing.drawn:
            self._resting = self._start(self._rest())

    async def _unless_lifted(self, work: Coroutine[Any, Any, Any]) -> None:
        """Until ``work`` is done or the pen is lifted: what has not begun by then is left."""
        tasks = self._start(work), self._start(self._lifted.wait())
        await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
        for task in tasks:
            task.cancel()

    async def _rest(self) -> None:
        await asyncio.sleep(IDLE)
        await self._answer(FULL, Lane.IDLE)

    async def _answer(self, stage: str, lane: Lane) -> tuple[Sheet, Answer | None]:
        """Learn from the drawing as it is, and tell the page unless the drawing has become another one since.

        Of a drawing whose pen is down that is done in the lane that has one thread, so that the stream is never told
        two things at once.
        """
        key, sheet, number = self._key(), self._drawing.sheet(), self._number
        if self._learned[0] == key and self._learned[1] is not None and self._learned[1].stage == FULL:
            return sheet, self._learned[1]
        answer, said = await self._workshop.do(
            lane, _work, sheet, self.tuning, stage, number, self._limits, self._live,
            lambda: stage != SETTLED or key == self._key(),
        )  # fmt: skip
        same = key == self._key() if stage != DRAWING else sheet.lineage == self._drawing.sheet().lineage
        if same and said is not None:
            self._learned, self._said = (key, answer), said
            self._send(said)
        return sheet, answer

    async def _of_full(self, what: str, act: Act) -> None:
        """``act`` on the default run of the drawing as it is; the page is told where that cannot be."""
        try:
            if self._drawing.drawn:
                raise RefusedError("cannot", "Lift the pen first.")
            sheet, answer = await self._answer(FULL, Lane.WAITED_FOR)
            if answer is None or answer.posterior is None:
                raise RefusedError("cannot", f"There is nothing to {what} yet: draw a path first.")
            await act(sheet, answer.found, answer.posterior)
        except (SubgoalError, OSError, RefusedError) as problem:
            text = f"Could not {what}: {problem.strerror}." if isinstance(problem, OSError) else str(problem)
            self._send({"type": "error", "code": "cannot", "text": text})

    async def _read(self, name: str, content: bytes) -> None:
        before = self._drawing.revision
        try:
            recording = await self._workshop.do(Lane.WAITED_FOR, read_dropped, name, content, self._limits)
            if self._drawing.revision != before:
                raise RefusedError("file", "The drawing has changed meanwhile: drop the file again.")
        except (SubgoalError, RefusedError) as problem:
            self._send({"type": "error", "code": "file", "text": str(problem)})
            return
        self._drawing.replace(recording)
        sheet = self._drawing.sheet()
        self._send(shown(sheet))
        self._send({"type": "opened", "name": sheet.source, "points": sheet.n_points, "columns": list(sheet.names),
                    "unit": sheet.units})  # fmt: skip
        self.look(self._number)

    async def _save(self, sheet: Sheet, found: Subgoals, posterior: Posterior) -> None:
        folder = await self._workshop.do(Lane.WAITED_FOR, save_project, sheet, found, posterior, self._out)
        self._send({"type": "saved", "folder": str(folder)})

    async def _fly(self, sheet: Sheet, found: Subgoals, posterior: Posterior) -> None:
        left = threading.Event()
        try:
            wanted, most = lambda: not left.is_set(), self._limits.flight_seconds
            self._send(await self._workshop.do(Lane.FLIGHT, flown, posterior, most, wanted))
        finally:
            left.set()

    async def _export(self, kind: str, posterior: Posterior) -> None:
        text = await self._workshop.do(Lane.WAITED_FOR, waypoint_text, posterior, kind)
        self._send({"type": "file", "name": f"waypoints.{kind}", "text": text})


def _work(
    sheet: Sheet, tuning: Tuning, stage: str, number: int, limits: Limits, live: Live, wanted: Callable[[], bool]
) -> tuple[Answer | None, dict[str, Any] | None]:
    """In a thread: the answer and its picture, or why there is none; nothing where it is not wanted any more."""
    if not wanted():
        return None, None
    if sheet.n_points == 0:
        return None, nothing(number)
    try:
        answer = _learned(sheet, tuning, stage, limits, live)
    except SubgoalError as problem:
        return None, nothing(number, TOO_LITTLE if sheet.by_hand else str(problem))
    return answer, picture(answer, number)


def _learned(sheet: Sheet, tuning: Tuning, stage: str, limits: Limits, live: Live) -> Answer:
    """By the stream while the pen is down; of files, long rests and at pen-up from the whole drawing."""
    if stage == DRAWING and sheet.by_hand:
        with suppress(InputError):
            return live.answer(sheet, tuning)
    return learn(demonstrations_of(sheet.recording(), limits.pairs), tuning, stage)
