"""Lines of text as they are written: to a file that grows, or to standard input."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

STANDARD_INPUT = "-"
PIECE = 2**16
PAUSE = 0.05
"""Seconds between two looks at a file to which nothing was added."""


class Source(Protocol):
    """Bytes that come bit by bit; ``rewritten`` where they are no longer those of the file of that name."""

    rewritten: bool

    def read(self) -> bytes | None:
        """What is new, nothing if nothing is (after a short wait), None if no more will come."""


class GrowingFile:
    """A file read on to its end, and again when it has grown. Its end is nobody's business: it may grow again."""

    def __init__(self, path: Path) -> None:
        self._path, self._stream = path, path.open("rb")
        self.rewritten = False

    def read(self) -> bytes | None:
        """See ``Source``."""
        new = self._stream.read(PIECE)
        if not new:
            self.rewritten = self.rewritten or self._is_another()
            time.sleep(PAUSE)
        return new

    def _is_another(self) -> bool:
        """Whether the file is shorter than what was read of it, or another one has its name."""
        try:
            now = self._path.stat()
        except OSError:
            return True
        return now.st_size < self._stream.tell() or now.st_ino != os.fstat(self._stream.fileno()).st_ino


class Piped:
    """A file descriptor read by a thread of its own, so that whoever waits for it can still be stopped."""

    def __init__(self, descriptor: int) -> None:
        self.rewritten = False
        self._pieces: queue.Queue[bytes | None] = queue.Queue()
        threading.Thread(target=self._pump, args=(descriptor,), daemon=True).start()

    def _pump(self, descriptor: int) -> None:
        while piece := os.read(descriptor, PIECE):
            self._pieces.put(piece)
        self._pieces.put(None)

    def read(self) -> bytes | None:
        """See ``Source``."""
        try:
            return self._pieces.get(timeout=PAUSE)
        except queue.Empty:
            return b""


def source_of(name: str) -> Source:
    """Standard input for "-", else the file of that name; ``OSError`` where it cannot be opened."""
    return Piped(sys.stdin.fileno()) if name == STANDARD_INPUT else GrowingFile(Path(name))


def lines_of(
    source: Source, *, patience: float = float("inf"), stopped: Callable[[], bool] = lambda: False
) -> Iterator[str | None]:
    """Line after line without its end, and None each time that there is nothing new.

    Ends with the source, when nothing came for ``patience`` seconds, and when ``stopped`` says so. What stands after
    the last end of a line is a line too, unless it was stopped: then it may be half a line.
    """
    rest, last = b"", time.monotonic()
    while not stopped():
        new = source.read()
        if new is None or (not new and time.monotonic() - last > patience):
            if rest:
                yield _text(rest)
            return
        if not new:
            yield None
            continue
        last = time.monotonic()
        *whole, rest = (rest + new).split(b"\n")
        for line in whole:
            yield _text(line)


def _text(line: bytes) -> str:
    return line.decode("utf-8-sig", errors="replace").rstrip("\r")
