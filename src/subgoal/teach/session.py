"""One tab: its drawing, what is done to it, and the answers it is sent."""

from __future__ import annotations

import logging
import time
from pathlib import Path
from typing import Any

from subgoal.teach.drawing import Drawing
from subgoal.teach.learner import Learner
from subgoal.teach.limits import Allowance, Limits
from subgoal.teach.messages import (
    Begin,
    Clear,
    Dropped,
    Export,
    Fly,
    Hello,
    Lift,
    Operation,
    Points,
    RefusedError,
    Save,
    Tune,
    Undo,
    parse,
)  # fmt: skip
from subgoal.teach.outbox import Outbox
from subgoal.teach.picture import shown
from subgoal.teach.workshop import Workshop

ELSEWHERE = "This session goes on elsewhere. Reload for another one."
LOG = logging.getLogger("subgoal.teach")


class Session:
    """Kept while its page is away, so that a page which comes back finds everything as it was.

    Operations are numbered by the page: each is done once, in order; what was done is said again, what is missing is
    asked for. Whatever is refused is answered with a code and a sentence, and logged once for each code.
    """

    def __init__(self, name: str, limits: Limits, workshop: Workshop, out: Path) -> None:
        self.name, self.page, self.left = name, "", time.monotonic()
        self._limits = limits
        self._drawing = Drawing(limits)
        self._learner = Learner(self._drawing, limits, workshop, out, self._send)
        self._last = 0
        self._logged: set[str] = set()
        self._outbox: Outbox | None = None
        self._points = Allowance(limits.points_per_second, limits.points_at_once)
        self._messages = Allowance(limits.messages_per_second, limits.messages_at_once)

    @property
    def present(self) -> bool:
        """Whether a page is connected."""
        return self._outbox is not None

    @property
    def used(self) -> bool:
        """Whether anything was ever done in it."""
        return self._last > 0

    def attach(self, page: str, outbox: Outbox) -> None:
        """A page has come (back): it is told everything; one that was here before is told that it is closed."""
        if self._outbox is not None:
            self._outbox.put({"type": "error", "code": "closed", "text": ELSEWHERE})
        self.page, self._outbox = page, outbox
        tuning = self._learner.tuning
        self._send({
            "type": "welcome", "session": self.name, "last": self._last, "drawing": shown(self._drawing.sheet()),
            "confidence": tuning.confidence, "concentration": tuning.concentration,
        })  # fmt: skip
        self._learner.say_again()

    def detach(self, outbox: Outbox) -> None:
        """The page has gone, unless another has taken its place."""
        if self._outbox is outbox:
            self._outbox, self.left = None, time.monotonic()

    def close(self) -> None:
        """The server forgets this session."""
        self._learner.close()
        if self._outbox is not None:
            self._outbox.close()
        self._outbox = None

    def receive(self, message: str | bytes, outbox: Outbox) -> None:
        """Do what a message asks, or answer why not; never raises for anything that a page can send."""
        try:
            if outbox is not self._outbox:
                raise RefusedError("closed", ELSEWHERE)
            self._in_time(self._messages, 1)
            operation = parse(message, self._limits)
            if isinstance(operation, Hello):
                raise RefusedError("out-of-order", "hello is said once")
            self._do(operation)
        except RefusedError as problem:
            self._refuse(problem, outbox)

    def _do(self, operation: Operation) -> None:
        if operation.number > self._last + 1:
            raise RefusedError("out-of-order", f"number {self._last + 1} is missing", expected=self._last + 1)
        try:
            if operation.number == self._last + 1:
                if isinstance(operation, Points):
                    self._in_time(self._points, len(operation.points))
                self._last = operation.number
                self._act(operation)
        except RefusedError as problem:
            problem.more["number"] = operation.number
            raise
        finally:
            self._send({"type": "done", "number": self._last, "points": self._drawing.n_points})

    def _act(self, operation: Operation) -> None:
        drawing, learner = self._drawing, self._learner
        match operation:
            case Begin():
                drawing.begin()
            case Points(points=points):
                drawing.add(points)
            case Lift():
                drawing.lift()
            case Undo():
                drawing.undo()
            case Clear():
                drawing.clear()
            case Tune(confidence=confidence, concentration=concentration):
                learner.tune(confidence, concentration)
            case Dropped(name=name, content=content):
                learner.read(name, content)
            case Fly():
                learner.fly()
            case Save():
                learner.save()
            case Export(format=kind):
                learner.export(kind)
        learner.look(self._last)

    def _in_time(self, allowance: Allowance, amount: int) -> None:
        wait = allowance.wait(amount, time.monotonic())
        if wait:
            raise RefusedError("too-fast", "more than this server takes in a second", wait=round(wait, 3))

    def _refuse(self, problem: RefusedError, outbox: Outbox) -> None:
        if problem.code not in self._logged:
            self._logged.add(problem.code)
            LOG.warning("session %s: %s: %s", self.name[:6], problem.code, problem.text)
        outbox.put({"type": "error", "code": problem.code, "text": problem.text, **problem.more})

    def _send(self, message: dict[str, Any]) -> None:
        if self._outbox is not None:
            self._outbox.put(message)
