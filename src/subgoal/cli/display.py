"""Subgoals shown while they are learned: a table that stays in its place on a terminal, lines elsewhere."""

from __future__ import annotations

import time
from types import TracebackType

import numpy as np
from rich.console import Console
from rich.live import Live
from rich.table import Table

from subgoal.answers.subgoals import Subgoals
from subgoal.plots.words import compact, counted
from subgoal.streaming import Stream

LOOK_EVERY = 0.2
"""Seconds between two looks."""


class Display:
    """Shows the subgoals of a stream; nothing but errors if ``quiet``. On a terminal it is a table, elsewhere lines.

    A line is printed when the number of subgoals has changed, or one has moved by more than ``merge_radius``.
    """

    def __init__(self, *, quiet: bool, merge_radius: float | None = None, console: Console | None = None) -> None:
        self._quiet, self._merge_radius = quiet, merge_radius
        self._console = console or Console(highlight=False)
        self._live: Live | None = None
        self._looked = -np.inf
        self._shown: Subgoals | None = None

    def __enter__(self) -> Display:
        if self._console.is_terminal and not self._quiet:
            self._live = Live(console=self._console, auto_refresh=False)
            self._live.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def look(self, stream: Stream, *, last: bool = False) -> None:
        """Show what the stream says now, unless that was only just done."""
        now = time.monotonic()
        if self._quiet or (not last and now - self._looked < LOOK_EVERY):
            return
        self._looked = now
        found = stream.subgoals(merge_radius=self._merge_radius)
        if self._live is not None:
            self._live.update(table_of(stream, found), refresh=True)
        elif last or self._differs(found):
            self._shown = found
            self._console.print(line_of(stream, found), markup=False, soft_wrap=True)

    def say(self, told: str) -> None:
        """A line, above the table if there is one."""
        if not self._quiet:
            self._console.print(told, markup=False, soft_wrap=True)

    def _differs(self, found: Subgoals) -> bool:
        before = self._shown
        if before is None or found.n_subgoals != before.n_subgoals:
            return found.n_subgoals > 0 or before is not None
        known = [item.position for item in before]
        return any(
            min(np.linalg.norm(item.position - place) for place in known) > found.merge_radius
            for item in list(found)[: found.n_subgoals]
        )


def line_of(stream: Stream, found: Subgoals) -> str:
    """ "120 pairs: 2 subgoals, (0.75, 0.53) 55 %, (0.75, 2.00) 44 %"."""
    extent = _extent(stream)
    counting = list(found)[: found.n_subgoals]
    told = [f"{compact(item.position, extent)} {item.share:.0%}" for item in counting]
    return ", ".join([f"{counted(stream.n_pairs, 'pair')}: {counted(len(counting), 'subgoal')}", *told])


def table_of(stream: Stream, found: Subgoals) -> Table:
    """One row for each subgoal with 1 % or more."""
    title = f"{counted(stream.n_pairs, 'pair')}, {counted(found.n_subgoals, 'subgoal')}; Ctrl-C ends and writes"
    table = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for heading in ("", "place", "share", "90 % interval"):
        table.add_column(heading, justify="right")
    extent = _extent(stream)
    for item in found:
        low, high = item.share_interval
        place = compact(item.position, extent)
        table.add_row(str(item.label), place, f"{item.share:.1%}", f"{low:.1%} to {high:.1%}")
    return table


def _extent(stream: Stream) -> float:
    return stream.demonstrations().extent if stream.n_pairs else 0.0
