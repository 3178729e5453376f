"""Which pairs of a stream are of which trajectory, and how each one ended."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.records import Source
from subgoal.runtime.checks import Bools, Floats, Ints


class Trajectories:
    """Trajectories that are over, the pieces so far of one that was cut, and the one that is going on; it changes.

    Attributes
    ----------
    source:
        Counts of what was cut and dropped.
    """

    def __init__(self, source: str) -> None:
        self.source = Source(source)
        self._starts = [0]
        self._ends: list[Floats] = []
        self._truncated: list[bool] = []
        self._names: list[str] = []
        self._pieces: list[int] = []
        self._begun = self._cuts = 0

    @property
    def first(self) -> int:
        """First row of the one that is going on."""
        return self._starts[-1]

    def count(self, **notes: int) -> None:
        """Note that something happened so many times."""
        self.source = self.source.noting(**notes)

    def cut(self, stop: int, end: Floats | None) -> None:
        """A piece goes up to row ``stop`` and place ``end`` (d,), which is None where it is dropped."""
        self._close(stop, end, truncated=True)
        self.count(gaps_split=1)
        self._cuts += 1

    def end(self, stop: int, end: Floats | None, name: str | None) -> None:
        """The last piece, or the only one; ``name`` is that of the trajectory, else "T" and its number."""
        self._close(stop, end, truncated=False)
        self._names += self._named(name or f"T{self._begun}", self._pieces)
        self._begun, self._cuts, self._pieces = self._begun + 1, 0, []

    def _close(self, stop: int, end: Floats | None, *, truncated: bool) -> None:
        if end is not None:
            self._starts.append(stop)
            self._ends.append(end)
            self._truncated.append(truncated)
            self._pieces.append(self._cuts)

    def _named(self, name: str, pieces: list[int]) -> list[str]:
        return [f"{name}/{k}" if self._cuts else name for k in pieces]

    def offset(self, stop: int) -> Ints:
        """(D + 1,) where there are ``stop`` pairs."""
        return np.array([*self._starts, stop] if stop > self.first else self._starts)

    def ends(self, stop: int, last: Floats) -> Floats:
        """(D, d) ends; the one that is going on ends in ``last`` (d,)."""
        return np.stack([*self._ends, last] if stop > self.first else self._ends)

    def truncated(self, stop: int) -> Bools:
        """(D,) which were cut, or are going on."""
        return np.array([*self._truncated, True] if stop > self.first else self._truncated)

    def names(self, stop: int) -> tuple[str, ...]:
        """(D,) names."""
        going_on = [self._cuts] if stop > self.first else []
        return (*self._names, *self._named(f"T{self._begun}", [*self._pieces, *going_on]))
