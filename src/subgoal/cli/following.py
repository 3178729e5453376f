"""From lines to a stream, with the subgoals shown as they appear."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence

from subgoal.cli.display import Display
from subgoal.plots.words import counted
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.streaming import Stream, warm
from subgoal.streaming.lines import lines_of, source_of
from subgoal.streaming.rows import Columns, Row, is_empty

TOLD = 5
"""So many lines that are left out are told one by one."""


class Following:
    """A stream that is told the rows of a table while it is written; it changes."""

    def __init__(self, stream: Stream, display: Display) -> None:
        self._stream, self._display = stream, display
        self._trajectory: str | None = None
        self._over: set[str] = set()
        self._left_out = 0

    def read(
        self, name: str, *, position: Sequence[str], time: str, trajectory: str | None, separator: str | None,
        patience: float,
    ) -> None:  # fmt: skip
        """All lines of a file, or of "-", until its end, ``patience`` seconds without any, or Ctrl-C.

        Raises ``ReadError`` for a header without a wanted column, and ``InputError`` where there is no header.
        """
        source = source_of(name)
        warm()
        with Interrupt() as interrupt, self._display as display:
            lines = lines_of(source, patience=patience, stopped=lambda: interrupt.requested)
            numbered = self._numbered(lines)
            header = next((line for _, line in numbered if line is not None), None)
            if header is None:
                raise InputError("file", where=name, found="no line", wanted="a header and samples")
            columns = Columns.of(header, position=position, time=time, trajectory=trajectory, separator=separator)
            for number, line in numbered:
                if line is None:
                    self._stream.rejuvenate()
                else:
                    self._take(columns, line, number)
                display.look(self._stream)
            self._stream.lift(name=self._trajectory)
            display.look(self._stream, last=True)
        if self._left_out > TOLD:
            print(f"subgoal: {counted(self._left_out, 'line')} left out in all", file=sys.stderr)

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
        try:
            row = columns.row(line)
            self._change(row)
            self._stream.add(row.time, row.place)
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
        self._trajectory = row.trajectory
