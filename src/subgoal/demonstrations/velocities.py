"""Velocities of one trajectory from its positions and times."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

EVEN = 1e-3
"""Steps that differ by less than this share of their median count as even."""

Velocity = Callable[[Floats, Floats, int], tuple[Ints, Floats]]
"""(positions (m, d), times (m,), window) to (rows (n,), velocities (n, d)): n rows of the m have a velocity."""


def central(places: Floats, times: Floats, window: int) -> tuple[Ints, Floats]:
    """From sample i − w//2 to i + (w − w//2), clipped at the ends, over the real time between the two."""
    rows = np.arange(len(times))
    before = np.maximum(rows - window // 2, 0)
    after = np.minimum(rows + window - window // 2, len(times) - 1)
    return rows, _between(places, times, before, after)


def forward(places: Floats, times: Floats, window: int) -> tuple[Ints, Floats]:
    """From sample i to i + w, clipped at the end; the last sample has none."""
    rows = np.arange(len(times) - 1)
    return rows, _between(places, times, rows, np.minimum(rows + window, len(times) - 1))


def savgol(places: Floats, times: Floats, window: int) -> tuple[Ints, Floats]:
    """Derivative of the parabola fitted to the ``window`` samples around each (Savitzky and Golay 1964).

    The steps must be even, except that a shorter last one leaves the last sample without a velocity. A trajectory
    with fewer even samples than the window has none at all.
    """
    from scipy.signal import savgol_filter

    steps = np.diff(times)
    step = float(np.median(steps))
    count = len(times) - (steps[-1] < (1 - EVEN) * step)
    uneven = np.abs(steps[: count - 1] - step) > EVEN * step
    if uneven.any():
        row = int(np.argmax(uneven))
        raise InputError(
            "velocity",
            where=f"sample {row + 1} of a trajectory",
            found=f"a step of {steps[row]:g} where the median is {step:g}",
            wanted="even steps for 'savgol'",
            hint="resample with rate=, split with max_gap=, or use 'central'",
        )
    if count < window:
        return np.empty(0, np.int64), np.empty((0, places.shape[1]))
    return np.arange(count), savgol_filter(places[:count], window, 2, deriv=1, delta=step, axis=0)


VELOCITIES: dict[str, Velocity] = {"central": central, "forward": forward, "savgol": savgol}


def _between(places: Floats, times: Floats, before: Ints, after: Ints) -> Floats:
    with np.errstate(over="ignore", invalid="ignore"):
        return np.asarray((places[after] - places[before]) / (times[after] - times[before])[:, None])
