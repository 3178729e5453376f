"""One progress display: a bar on a terminal, a line now and then elsewhere, nothing when quiet."""

from __future__ import annotations

import sys
import time
from types import TracebackType
from typing import Any, Protocol

LINE_EVERY = 10.0
RATE_AFTER = 2.0
"""Seconds of work after which a rate is told."""


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


class Pace:
    """Steps in a second from the first that is done: what comes before it, compilation for one, is none of them."""

    def __init__(self) -> None:
        self._since: tuple[float, int] | None = None

    def at(self, done: int) -> float | None:
        """Told with every update; None until there has been work for two seconds after the first step."""
        now = time.monotonic()
        if self._since is None:
            self._since = (now, done) if done else None
            return None
        begin, first = self._since
        return (done - first) / (now - begin) if done > first and now - begin >= RATE_AFTER else None


class Lines:
    """A plain line every ten seconds, for logs; unless ``even``, steps take unlike times and foretell no time left."""

    def __init__(self, what: str, *, even: bool = True) -> None:
        self._what, self._last = what, time.monotonic()
        self._even, self._pace = even, Pace()

    def __enter__(self) -> Lines:
        self._pace = Pace()
        return self

    def __exit__(self, *failure: Any) -> None:
        return None

    def update(self, done: int, total: int, note: str = "") -> None:
        """Print a line when one is due, with rate and time left once they are known."""
        now, rate = time.monotonic(), self._pace.at(done)
        if now - self._last < LINE_EVERY or not done:
            return
        self._last = now
        pace = f", {rate:.3g}/s, {(total - done) / rate:.0f} s left" if self._even and rate else ""
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
        self._pace = Pace()

    def __enter__(self) -> Bar:
        self._pace = Pace()
        self._display.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._display.stop()

    def update(self, done: int, total: int, note: str = "") -> None:
        """Move the bar."""
        rate = self._pace.at(done)
        told = f"{rate:,.0f}/s" if rate else ""
        self._display.update(self._task, completed=done, total=total, rate=told, note=note)


def progress_display(what: str, *, quiet: bool = False, even: bool = True) -> Progress:
    """A bar on a terminal, lines elsewhere, nothing if ``quiet``; with the time left where steps are ``even``."""
    if quiet:
        return Silent()
    return Bar(what, even=even) if sys.stderr.isatty() else Lines(what, even=even)
