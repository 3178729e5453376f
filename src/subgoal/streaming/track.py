"""One trajectory while it is recorded: samples in, pairs out as soon as no later sample can change them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.recordings import ON_GRID
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.demonstrations.velocities import central
from subgoal.runtime.checks import Floats
from subgoal.streaming.growing import Growing


class Pairs(NamedTuple):
    """Times (m,), states (m, d) and velocities (m, d)."""

    times: Floats
    states: Floats
    actions: Floats


class Track:
    """Samples of one trajectory, resampled and made into pairs as ``demonstrate`` makes them; it changes.

    A sample at a resampling time is settled when one has come that is later, a velocity when its window is settled.

    ``rate`` is in samples per unit of time or None, ``window`` in samples after resampling. Dimensions of finite
    ``period`` (d,) are unwound: states may lie whole periods from the samples.

    Attributes
    ----------
    lowest:
        (d,) least coordinates of the samples as they came.
    """

    def __init__(self, period: Floats, rate: float | None, window: int) -> None:
        dimension = period.size
        self._period, self._rate, self._window = period, rate, window
        self._times, self._places = Growing(), Growing(dimension)
        self.lowest, self._came, self._turned = np.full(dimension, np.inf), np.zeros(dimension), np.zeros(dimension)
        self._even = (self._times, self._places) if rate is None else (Growing(), Growing(dimension))
        self._given = 0

    def __len__(self) -> int:
        return len(self._times)

    @property
    def last(self) -> tuple[float, Floats]:
        """Time and place (d,) of the last sample."""
        return float(self._times.rows[-1]), self._places.rows[-1]

    def tells_apart(self, time: float) -> bool:
        """Whether times a step of resampling apart are different numbers there."""
        return self._rate is None or 4 * np.spacing(abs(time)) <= 1 / self._rate

    def steps_at(self, time: float) -> float:
        """Resampling times that would lie between what is settled and ``time``."""
        return 0.0 if self._rate is None else (time - float(self._times.rows[0])) * self._rate - len(self._even[0])

    def add(self, time: float, place: Floats) -> Pairs:
        """Take one sample (time, (d,) place); the pairs that are final now."""
        self._times.extend([time])
        self._places.extend(self._unwound(place)[None])
        if self._rate is not None:
            self._resample(self._rate)
        return self._ready()

    def _unwound(self, place: Floats) -> Floats:
        """The place with every jump of more than half a period undone, in the arithmetic of ``numpy.unwrap``."""
        wraps = np.isfinite(self._period)
        if len(self._times) > 1 and wraps.any():
            half, jump = self._period[wraps] / 2, (place - self._came)[wraps]
            short = np.mod(jump + half, 2 * half) - half
            short[(short == -half) & (jump > 0)] = half[(short == -half) & (jump > 0)]
            self._turned[wraps] += np.where(np.abs(jump) < half, 0.0, short - jump)
        self._came = place
        self.lowest = np.minimum(self.lowest, place)
        return place + self._turned if wraps.any() else place

    def _resample(self, rate: float) -> None:
        times, places = self._times.rows, self._places.rows
        settled = int(np.ceil((times[-1] - times[0]) * rate - ON_GRID))
        grid = times[0] + np.arange(len(self._even[0]), settled) / rate
        if not grid.size:
            return
        first = max(int(np.searchsorted(times, grid[0], side="right")) - 1, 0)
        made = [np.interp(grid, times[first:], column) for column in places[first:].T]
        self._even[0].extend(grid)
        self._even[1].extend(np.stack(made, axis=1))

    def _ready(self) -> Pairs:
        times, places = (each.rows for each in self._even)
        start, stop = self._given, max(self._given, len(times) - (self._window - self._window // 2))
        first = max(start - self._window // 2, 0)
        _, velocities = central(places[first:], times[first:], self._window)
        self._given = stop
        return Pairs(times[start:stop], places[start:stop], velocities[start - first : stop - first])

    @property
    def flaw(self) -> str:
        """Why nothing can be made of the samples, as notes of a ``Source`` have it; empty where something can."""
        if len(self) < 2:
            return "trajectories_of_one_sample_dropped"
        times = self._times.rows
        short = self._rate is not None and (times[-1] - times[0]) * self._rate <= ON_GRID
        return "trajectories_too_short_to_resample_dropped" if short else ""

    def whole(self) -> Demonstrations | None:
        """What ``demonstrate`` says of all unwound samples, the last ones included; None where there is a flaw."""
        if self.flaw:
            return None
        names = tuple(f"x{k}" for k in range(self._places.rows.shape[1]))
        recording = Recording(self._places.rows, self._times.rows, np.array([0, len(self)]), names)
        return demonstrate(recording, rate=self._rate, window=self._window)
