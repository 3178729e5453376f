"""Ctrl-C as a request: the work in hand is finished, then what is there is given back."""

from __future__ import annotations

import multiprocessing
import signal
import threading
from types import FrameType
from typing import Any


class Interrupt:
    """While entered, the first Ctrl-C sets ``requested``; the second one interrupts at once, as usual.

    One within another passes the request on: whoever called learns of it too.
    """

    def __init__(self) -> None:
        self.requested = False
        self._usual: Any = None

    def __enter__(self) -> Interrupt:
        if threading.current_thread() is threading.main_thread():
            self._usual = signal.signal(signal.SIGINT, self._handle)
        return self

    def __exit__(self, *failure: Any) -> None:
        if self._usual is not None:
            signal.signal(signal.SIGINT, self._usual)

    def _handle(self, number: int, frame: FrameType | None) -> None:
        if self.requested:
            raise KeyboardInterrupt
        self.requested = True
        outer = getattr(self._usual, "__self__", None)
        if isinstance(outer, Interrupt) and not outer.requested:
            outer._handle(number, frame)


def leave_to_parent() -> None:
    """In a worker process: Ctrl-C is the affair of the process that gave it the work."""
    if multiprocessing.parent_process() is not None and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
