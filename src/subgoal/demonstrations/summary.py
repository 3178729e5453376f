"""What a recording looks like, and what a reader should worry about, in plain language."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.runtime.checks import Floats, Ints

LEVELS = (0.0, 0.25, 0.5, 0.75, 0.95, 1.0)
"""Quantiles told of speeds."""
GAP = 5.0
"""A step this many times the median counts as a gap."""
SHORT = 5
"""Trajectories of fewer samples are worth a warning."""
UNEVEN = 1.5
"""So many times apart may the 10 % and 90 % quantiles of the rate be."""
STANDING = 0.2
"""Share of steps without motion that is worth a warning."""
OUTLIER = 20.0
"""So many times the 95 % quantile may the highest speed be."""
COARSE = 10.0
"""A median step of fewer than so many smallest differences is quantised."""
MOST_GROUPS = 20
"""Groups that are listed."""
THINNED = "pairs dropped by thinning"


@dataclass(frozen=True)
class Summary:
    """Numbers that describe a Recording or Demonstrations.

    Attributes
    ----------
    name, units, time_unit, notes:
        As in ``Source`` and the record; ``notes`` counts what was dropped, split or interpolated.
    trajectories, samples, dimension:
        Counts; dimension 0 for a discrete world, whose ``lower`` and ``upper`` are its least and greatest state.
    lengths:
        Least, median and greatest number of samples of a trajectory.
    durations:
        The same of the time from first to last sample, in ``time_unit``; None without times.
    rate, rate_spread:
        Samples per ``time_unit``: median, and 10 % and 90 % quantiles; None without times.
    gaps, longest_gap:
        Number of steps longer than five times the median, and the longest step of all in ``time_unit``.
    names, lower, upper, extent:
        The columns, their ranges, and the greatest range of them all, in ``units``.
    speeds:
        Quantiles 0, 25, 50, 75, 95 and 100 % of distance over time between samples; None without times.
    standing:
        Share of the steps that do not move at all.
    warnings:
        Sentences for people.
    groups:
        How many trajectories each group has; empty without groups.
    """

    name: str
    units: str
    time_unit: str
    notes: dict[str, int]
    trajectories: int
    samples: int
    dimension: int
    lengths: tuple[int, float, int]
    durations: tuple[float, float, float] | None
    rate: float | None
    rate_spread: tuple[float, float] | None
    gaps: int
    longest_gap: float | None
    names: tuple[str, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    extent: float
    speeds: tuple[float, ...] | None
    standing: float
    warnings: tuple[str, ...]
    groups: dict[str, int] = field(default_factory=dict)

    def lines(self) -> list[str]:
        """The summary as lines of text, warnings last."""
        unit, per = self.units or "units", f"{self.units or 'units'}/{self.time_unit}"
        told = [
            f"{self.name}: {self.trajectories} trajector{'y' if self.trajectories == 1 else 'ies'}, "
            f"{self.samples} samples",
            f"samples in a trajectory: {self.lengths[0]} to {self.lengths[2]}, median {self.lengths[1]:g}",
        ]
        if self.groups:
            listed = ", ".join(f"{name} {count}" for name, count in list(self.groups.items())[:MOST_GROUPS])
            more = f" and {len(self.groups) - MOST_GROUPS} more groups" if len(self.groups) > MOST_GROUPS else ""
            told.append(f"trajectories of groups: {listed}{more}")
        if self.durations is not None:
            low, middle, high = self.durations
            told.append(f"duration: {low:.4g} to {high:.4g} {self.time_unit}, median {middle:.4g}")
        if self.rate is not None and self.rate_spread is not None:
            low, high = self.rate_spread
            told.append(f"rate: {self.rate:.4g} per {self.time_unit} (10 % to 90 %: {low:.4g} to {high:.4g})")
        for name, low, high in zip(self.names, self.lower, self.upper, strict=True):
            told.append(f"{name}: {low:.6g} to {high:.6g} {unit if self.dimension else ''}".rstrip())
        if self.speeds is not None:
            told.append(f"speed: median {self.speeds[2]:.4g}, 95 % below {self.speeds[4]:.4g} {per}")
        told += [f"{what}: {count}" for what, count in self.notes.items()]
        return told + [f"warning: {warning}" for warning in self.warnings]


def _places(data: Recording | Demonstrations) -> Any:
    """(N, d) positions or coordinates; (N,) states that lie nowhere."""
    if isinstance(data, Recording):
        return data.positions
    return data.states if data.coordinates is None else data.places


def summarise(data: Recording | Demonstrations) -> Summary:
    """Counts, rates, ranges, speeds and warnings of a Recording or Demonstrations."""
    places = _places(data)
    table = np.asarray(places, dtype=np.float64).reshape(len(places), -1)
    later = np.ones(len(table), bool)
    later[data.offset[:-1]] = False
    rows = np.flatnonzero(later)
    with np.errstate(over="ignore"):
        moves = np.linalg.norm(table[rows] - table[rows - 1], axis=1)
        extent = float(np.ptp(table, axis=0).max())
    lengths = np.diff(data.offset)
    numbers: dict[str, Any] = {
        "trajectories": data.n_trajectories,
        "samples": len(table),
        "dimension": 0 if places.ndim == 1 else table.shape[1],
        "lengths": (int(lengths.min()), float(np.median(lengths)), int(lengths.max())),
        "lower": tuple(table.min(axis=0).tolist()),
        "upper": tuple(table.max(axis=0).tolist()),
        "extent": extent,
        "standing": float((moves == 0).mean()) if moves.size else 0.0,
        **_clock(data.times, data.offset, rows, moves),
    }
    if places.ndim == 1:
        numbers["speeds"] = None
    return Summary(
        name=data.source.name,
        units=data.units,
        time_unit=data.time_unit,
        notes=dict(data.source.notes),
        names=data.names,
        warnings=tuple(_warnings(data, numbers, table, moves)),
        groups=dict(sorted(Counter(data.groups).items())),
        **numbers,
    )


def _clock(times: Floats | None, offset: Ints, rows: Ints, moves: Floats) -> dict[str, Any]:
    """What needs times: durations, rates, gaps and speeds; None where there are none that increase."""
    nothing = {"durations": None, "rate": None, "rate_spread": None, "gaps": 0, "longest_gap": None, "speeds": None}
    if times is None or not rows.size:
        return nothing
    steps = times[rows] - times[rows - 1]
    if not (steps > 0).all():
        return nothing
    spans = times[offset[1:] - 1] - times[offset[:-1]]
    usual = float(np.median(steps))
    with np.errstate(over="ignore"):
        low, high = (float(value) for value in 1.0 / np.quantile(steps, [0.9, 0.1]))
        speeds = np.quantile(moves / steps, LEVELS)
    return {
        "durations": (float(spans.min()), float(np.median(spans)), float(spans.max())),
        "rate": 1.0 / usual,
        "rate_spread": (low, high),
        "gaps": int((steps > GAP * usual).sum()),
        "longest_gap": float(steps.max()),
        "speeds": tuple(speeds.tolist()),
    }


def _warnings(data: Recording | Demonstrations, numbers: dict[str, Any], table: Floats, moves: Floats) -> Iterator[str]:
    """Sentences on what may spoil what is learned."""
    unit = data.units or "units"
    if numbers["lengths"][0] < SHORT:
        count = int((np.diff(data.offset) < SHORT).sum())
        yield f"{count} of {data.n_trajectories} trajectories have fewer than {SHORT} samples"
    if numbers["dimension"] == 0:
        return
    thinned = THINNED in data.source.notes  # then its gaps are of our own making
    if numbers["gaps"] and not thinned:
        longest = f"the longest takes {numbers['longest_gap']:.4g} {data.time_unit}"
        yield f"clock jumps: {numbers['gaps']} steps take over {GAP:g} times the usual ({longest}); max_gap= cuts there"
    if numbers["rate_spread"] and not thinned and not numbers["rate_spread"][1] <= UNEVEN * numbers["rate_spread"][0]:
        yield "the sampling is uneven; rate= resamples it"
    if data.time_unit == "sample":
        yield "there is no clock: velocities are per sample"
    if not data.units:
        yield "the unit of the positions is unknown; units= names it"
    if numbers["standing"] > STANDING:
        yield f"{100 * numbers['standing']:.0f} % of the steps stand still"
    speeds = numbers["speeds"]
    if speeds and speeds[4] > 0 and speeds[5] > OUTLIER * speeds[4]:
        yield f"single steps are up to {speeds[5] / speeds[4]:.0f} times as fast as 95 % of them: a tracker that jumps?"
    for name, column in zip(data.names, table.T, strict=True):
        step = _quantum(column)
        if np.ptp(column) == 0:
            yield f"{name} never changes"
        elif step and moves.any() and np.median(moves[moves > 0]) < COARSE * step:
            yield f"positions look quantised: {name} comes in steps of {step:.4g} {unit}; a wider window= smooths them"


def _quantum(column: Floats) -> float:
    """The step of which all values are multiples (up to a shift), or 0 if there is none."""
    values = np.unique(column)
    if len(values) < 3:
        return 0.0
    step = float(np.diff(values).min())
    with np.errstate(over="ignore", invalid="ignore"):
        counts = (values - values[0]) / step
        whole = bool((np.abs(counts - np.round(counts)) < 0.01).all()) and counts[-1] < 1e7
    return step if whole else 0.0
