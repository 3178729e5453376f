"""One progress display: a bar on a terminal, a line now and then elsewhere, nothing when quiet."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Protocol

LINE_EVERY = 10.0


class Progress(Protocol):
    """Told how much of a piece of work is done."""

    def __enter__(self) -> Progress:
        """Begin to show."""

    def __exit__(self, *failure: Any) -> None:
        """Stop showing."""

    def update(self, done: int, total: int, note: str = "") -> None:
        """``done`` of ``total`` steps."""


class Silent:
    """Shows nothing."""

    def __enter__(self) -> Silent:
        return self

    def __exit__(self, *failure: Any) -> None:
        return None

    def update(self, done: int, total: int, note: str = "") -> None:
        """Nothing."""


class Noted:
    """Another display, with a note on every update: which part of a longer piece of work this is."""

    def __init__(self, display: Progress, note: str) -> None:
        self._display, self._note = display, note

    def __enter__(self) -> Noted:
        self._display.__enter__()
        return self

    def __exit__(self, *failure: Any) -> None:
        self._display.__exit__(*failure)

    def update(self, done: int, total: int, note: str = "") -> None:
        """With the note before any other."""
        self._display.update(done, total, f"{self._note} {note}".rstrip())


class Lines:
    """A plain line every ten seconds, for logs; unless ``even``, steps take unlike times and foretell no time left."""

    def __init__(self, what: str, *, even: bool = True) -> None:
        self._what, self._begin, self._last = what, time.monotonic(), time.monotonic()
        self._even = even
        self._first: int | None = None

    def __enter__(self) -> Lines:
        self._begin, self._first = time.monotonic(), None
        return self

    def __exit__(self, *failure: Any) -> None:
        return None

    def update(self, done: int, total: int, note: str = "") -> None:
        """Print rate and time left when a line is due."""
        now = time.monotonic()
        self._first = done if self._first is None else self._first
        if now - self._last < LINE_EVERY or not done:
            return
        self._last = now
        rate = max(done - self._first, 1) / (now - self._begin)
        pace = f", {rate:.3g}/s, {(total - done) / rate:.0f} s left" if self._even else ""
        print(f"{self._what}: {done}/{total}{pace} {note}", file=sys.stderr)


class Bar:
    """A bar with rate and time left, on a terminal; unless ``even``, with the time it has taken."""

    def __init__(self, what: str, *, even: bool = True) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
        from rich.progress import Progress as RichProgress

        clock = (TextColumn("{task.fields[rate]}"), TimeRemainingColumn()) if even else (TimeElapsedColumn(),)
        columns = (
            TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), *clock,
            TextColumn("{task.fields[note]}"),
        )  # fmt: skip
        self._display = RichProgress(*columns, console=Console(stderr=True), transient=True)
        self._task = self._display.add_task(what, total=None, rate="", note="")
        self._begin = time.monotonic()
        self._first: int | None = None

    def __enter__(self) -> Bar:
        self._begin, self._first = time.monotonic(), None
        self._display.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._display.stop()

    def update(self, done: int, total: int, note: str = "") -> None:
        """Move the bar."""
        self._first = done if self._first is None else self._first
        rate = f"{(done - self._first) / max(time.monotonic() - self._begin, 1e-9):,.0f}/s"
        self._display.update(self._task, completed=done, total=total, rate=rate, note=note)


def progress_display(what: str, *, quiet: bool = False, even: bool = True) -> Progress:
    """A bar on a terminal, lines elsewhere, nothing if ``quiet``; with the time left where steps are ``even``."""
    if quiet:
        return Silent()
    return Bar(what, even=even) if sys.stderr.isatty() else Lines(what, even=even)
