"""How near a flown path comes to the demonstrated one, whatever the time either took."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.flight.record import Flight
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

BLOCK = 2**20
"""Distances that are held at a time."""


@dataclass(frozen=True, eq=False)
class Tracking:
    """Errors without time: distances between the flown path and the demonstrated one, in the demonstration's units.

    Attributes
    ----------
    flown:
        (n,) from each flown sample to the nearest point of a demonstrated line.
    demonstrated:
        (N,) from each demonstrated sample to the nearest point of the flown line.
    rmse:
        Root of the mean square of ``flown`` and ``demonstrated``, each direction counting one half.
    largest:
        The largest of both (the Hausdorff distance of the samples).
    angle_rmse, angle_largest:
        Radians between the flown angle and the demonstrated one at the nearest point, over the flown samples; None
        where the demonstration has no angle.
    halves_flown, halves_demonstrated:
        (k,) half the range of each position: the radius, of a loop.
    units:
        Unit of the distances.
    """

    flown: Floats
    demonstrated: Floats
    rmse: float
    largest: float
    angle_rmse: float | None
    angle_largest: float | None
    halves_flown: Floats
    halves_demonstrated: Floats
    units: str

    @property
    def told(self) -> str:
        """A sentence."""
        unit = f" {self.units}" if self.units else ""
        angle = "" if self.angle_rmse is None else f"; {np.degrees(self.angle_rmse):.0f}° in angle (RMS)"
        rmse, most = (np.format_float_positional(x, 2, fractional=False, trim="-") for x in (self.rmse, self.largest))
        near = f"{rmse}{unit} from the demonstrated path (RMS), {most}{unit} at most"
        return near + angle

    def __repr__(self) -> str:
        angle = "" if self.angle_rmse is None else f", angle {self.angle_rmse:.2g} rad"
        return f"Tracking(rmse {self.rmse:.3g} {self.units}, largest {self.largest:.3g} {self.units}{angle})"


def tracking(flight: Flight, demonstrations: Demonstrations) -> Tracking:
    """Compare where the vehicle was with where the demonstrator was.

    A hand takes its own time, so time is left out: each flown sample is compared with the nearest point of the
    demonstrated lines, and each demonstrated sample with the nearest point of the flown line. Samples are
    even in time, so that rests count too.

    Raises ``InputError`` for demonstrations in other coordinates than the waypoints.
    """
    for given, kind in ((flight, Flight), (demonstrations, Demonstrations)):
        if not isinstance(given, kind):
            raise InputError("tracking", found=type(given).__name__, wanted="a Flight and Demonstrations")
    placement = flight.placement
    if demonstrations.is_discrete or demonstrations.names != flight.waypoints.dimensions:
        raise InputError("demonstrations", found=f"coordinates {', '.join(demonstrations.names)}",
                         wanted=f"{', '.join(flight.waypoints.dimensions)}, as the waypoints have")  # fmt: skip
    states = np.asarray(demonstrations.states)
    shown, path = states[:, placement.columns], flight.shown
    begin, end = _lines(shown, demonstrations.offset)
    flown, leg, share = _nearest(path, begin, end)
    back, _, _ = _nearest(shown, path[:-1], path[1:])
    off = None
    if placement.angle is not None:
        column = np.concatenate([np.unwrap(states[a:b, placement.angle]) for a, b in pairwise(demonstrations.offset)])
        first, last = _lines(column[:, None], demonstrations.offset)
        there = (first[leg] + share[:, None] * (last - first)[leg])[:, 0]
        off = np.arctan2(np.sin(flight.angles - there), np.cos(flight.angles - there))
    return Tracking(
        flown, back, float(np.sqrt(((flown**2).mean() + (back**2).mean()) / 2)), float(max(flown.max(), back.max())),
        None if off is None else float(np.sqrt((off**2).mean())), None if off is None else float(np.abs(off).max()),
        np.ptp(path, axis=0) / 2, np.ptp(shown, axis=0) / 2, demonstrations.units,
    )  # fmt: skip


def _lines(points: Floats, offset: Ints) -> tuple[Floats, Floats]:
    """(M, k) begins and ends of the lines between neighbouring samples of each trajectory; a lone sample is one."""
    rows = np.concatenate([np.arange(a, max(b - 1, a + 1)) for a, b in pairwise(offset.tolist())])
    alone = np.isin(rows, offset[1:] - 1)
    return points[rows], points[np.where(alone, rows, rows + 1)]


def _nearest(points: Floats, begin: Floats, end: Floats) -> tuple[Floats, Ints, Floats]:
    """(n,) distances of points (n, k) from the lines (M, k), the line of each, and the share of it gone there."""
    distance, line, share = np.empty(len(points)), np.empty(len(points), np.int64), np.empty(len(points))
    along = end - begin
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    size = max(1, BLOCK // len(begin))
    for a in range(0, len(points), size):
        block = points[a : a + size]
        gone = np.clip((block @ along.T - (begin * along).sum(axis=1)) / square, 0, 1)
        gaps = np.sqrt(sum(
            (block[:, j, None] - begin[:, j] - gone * along[:, j]) ** 2 for j in range(points.shape[1])
        ))  # fmt: skip
        best = np.argmin(gaps, axis=1)
        rows = np.arange(len(block))
        distance[a : a + size], line[a : a + size], share[a : a + size] = gaps[rows, best], best, gone[rows, best]
    return distance, line, share
