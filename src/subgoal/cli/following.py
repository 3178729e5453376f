"""From lines to a stream, with the subgoals shown as they appear."""

from __future__ import annotations

import signal
import sys
import threading
import time as clock
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from subgoal.cli.display import Display
from subgoal.plots.words import counted
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.streaming import Stream, warm
from subgoal.streaming.lines import STANDARD_INPUT, Source, lines_of, source_of
from subgoal.streaming.rows import Columns, Row, is_empty

TOLD = 5
"""So many lines that are left out are told one by one."""
SILENCE = 1.0
"""Seconds without a line after which it is told that more are waited for."""
LONG = 10
"""A step of so many times the one before, and so many resampling times, is told as a gap."""


class Following:
    """A stream that is told the rows of a table while it is written; it changes."""

    def __init__(
        self, stream: Stream, display: Display, *, out: Path, rate: float | None = None, max_gap: float | None = None
    ) -> None:
        self._stream, self._display, self._out, self._rate = stream, display, out, rate
        self._max_gap = float("inf") if max_gap is None else max_gap
        self._heard, self._has_waited, self._has_changed = clock.monotonic(), False, False
        self._times: list[float] = []
        self._lines, self._back = 0, 0
        self._trajectory: str | None = None
        self._over: set[str] = set()
        self._left_out = 0

    def read(
        self, name: str, *, position: Sequence[str], time: str, trajectory: str | None, separator: str | None,
        decimal: str | None, patience: float,
    ) -> None:  # fmt: skip
        """All lines of a file, or of "-", until its end, ``patience`` seconds without any, or Ctrl-C.

        Raises ``ReadError`` for a header without a wanted column, and ``InputError`` where there is no header.
        """
        source = _opened(name)
        warm()
        with Interrupt() as interrupt, _terminated() as terminated, self._display as display:
            lines = lines_of(source, patience=patience, stopped=lambda: interrupt.requested or terminated.is_set())
            self._heard = clock.monotonic()
            numbered = self._numbered(lines)
            header = next((line for _, line in numbered if line is not None), None)
            if header is None:
                raise InputError("file", where=name, found="no line", wanted="a header and samples")
            columns = Columns.of(header, position=position, time=time, trajectory=trajectory, separator=separator,
                                 decimal=decimal)  # fmt: skip
            for number, line in numbered:
                if line is None:
                    self._stream.rejuvenate()
                    self._wait(source, patience)
                else:
                    self._heard = clock.monotonic()
                    self._take(columns, line, number)
                display.look(self._stream)
            self._stream.lift(name=self._trajectory)
            display.look(self._stream, last=True)
        if self._left_out > TOLD:
            told = f"{counted(self._left_out, 'line')} left out in all, of {self._lines}"
            print(f"subgoal: {told}", file=sys.stderr)
        if self._back > TOLD and trajectory is None:
            told = f"in {counted(self._back, 'line')} the time goes back"
            print(f"subgoal: warning: {told}. If there is more than one trajectory, --trajectory names their column.",
                  file=sys.stderr)  # fmt: skip

    def _wait(self, source: Source, patience: float) -> None:
        """Tell once that more lines are waited for, and once that the file is no longer the one that is read."""
        if source.rewritten and not self._has_changed:
            self._has_changed = True
            print("subgoal: warning: the file was made shorter, replaced or removed; what is written to it now is not "
                  "read. Ctrl-C ends, then begin again.", file=sys.stderr)  # fmt: skip
        if not self._has_waited and clock.monotonic() - self._heard > SILENCE:
            self._has_waited = True
            ends = "Ctrl-C ends" if patience == float("inf") else f"Ctrl-C, or {patience:g} s without any, ends"
            self._display.say(f"waiting for more lines; {ends} and writes {self._out}/")

    @staticmethod
    def _numbered(lines: Iterator[str | None]) -> Iterator[tuple[int, str | None]]:
        """Lines with their number in the file, from 1, blank ones and comments left out."""
        number = 0
        for line in lines:
            number += line is not None
            if line is None or not is_empty(line):
                yield number, line

    def _take(self, columns: Columns, line: str, number: int) -> None:
        """One line into the stream, or told and left out."""
        self._lines += 1
        try:
            row = columns.row(line)
            self._change(row)
            self._back += bool(self._times) and row.time <= self._times[-1]
            self._stream.add(row.time, row.place)
            self._mind_gap(row.time, number)
        except InputError as problem:
            self._left_out += 1
            if self._left_out <= TOLD:
                print(f"subgoal: line {number} is left out: {problem}", file=sys.stderr)

    def _change(self, row: Row) -> None:
        """Lift where another trajectory begins; ``InputError`` where it is one that is over."""
        if row.trajectory == self._trajectory:
            return
        if row.trajectory in self._over:
            raise InputError("trajectory", found=f"{row.trajectory!r} again", wanted="one trajectory after the other",
                             hint="subgoal learn, when the recording is over")  # fmt: skip
        if self._trajectory is not None:
            self._over.add(self._trajectory)
            self._stream.lift(name=self._trajectory)
        self._trajectory, self._times = row.trajectory, []

    def _mind_gap(self, time: float, number: int) -> None:
        """Tell a step that is long beside the one before and in which samples are made up."""
        self._times = [*self._times[-2:], time]
        if len(self._times) < 3 or self._rate is None:
            return
        before, step = self._times[1] - self._times[0], self._times[2] - self._times[1]
        if step <= self._max_gap and step > LONG * before and step * self._rate > LONG:
            told = f"line {number} comes {step:.3g} after the one before: {step * self._rate:.0f} samples"
            print(f"subgoal: warning: {told} are made up between them, on a straight line. "
                  "--max-gap cuts there, and so does another value in the column of --trajectory.",
                  file=sys.stderr)  # fmt: skip


def source_told(name: str) -> str:
    """The name of a file without its folders, as ``learn`` has it."""
    return "standard input" if name == STANDARD_INPUT else Path(name).name


def _opened(name: str) -> Source:
    """The source of that name; ``InputError`` where it cannot be read."""
    if name != STANDARD_INPUT and Path(name).is_dir():
        raise InputError("file", where=name, found="a folder", wanted="a CSV file, or - for standard input")
    try:
        return source_of(name)
    except OSError as problem:
        told = "no such file" if isinstance(problem, FileNotFoundError) else problem.strerror
        raise InputError("file", where=name, found=told,
                         wanted="a CSV file that can be read, or - for standard input") from None  # fmt: skip


@contextmanager
def _terminated() -> Iterator[threading.Event]:
    """An event that SIGTERM sets, the first time; the second one ends the process, as usual."""
    asked = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield asked
        return
    usual = signal.getsignal(signal.SIGTERM)

    def handle(number: int, frame: object) -> None:
        asked.set()
        signal.signal(signal.SIGTERM, usual)

    signal.signal(signal.SIGTERM, handle)
    try:
        yield asked
    finally:
        signal.signal(signal.SIGTERM, usual)
