"""Piecewise polynomials of degree 7 in time: of minimum snap, held still, stretched, joined."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.runtime.checks import Floats

DEGREE = 7
SAMPLES = 33
"""Points of a piece, its ends and its middle among them, at which speed and acceleration are looked at."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """``durations`` (P,) in seconds; ``coefficients`` (P, 8, 3) of powers of the time since each piece began."""

    durations: Floats
    coefficients: Floats

    @property
    def knots(self) -> Floats:
        """(P + 1,) where pieces begin and the last ends."""
        return np.append(0.0, np.cumsum(self.durations))

    @property
    def duration(self) -> float:
        """Seconds of all pieces."""
        return float(self.durations.sum())

    def at(self, times: Any, orders: int = 1) -> Floats:
        """(orders, n, 3) the path and its derivatives at ``times`` (n,), held at both ends."""
        from minsnap_trajectories import PiecewisePolynomialTrajectory, compute_trajectory_derivatives

        clock = np.atleast_1d(np.asarray(times, float))
        knots = self.knots
        within = np.clip(clock, 0.0, knots[-1])
        path = PiecewisePolynomialTrajectory(knots, self.durations, self.coefficients)
        made = np.asarray(compute_trajectory_derivatives(path, within, orders))
        made[1:, (clock > knots[-1]) | (clock < 0)] = 0.0
        return made

    def samples(self) -> Floats:
        """(P·33,) times spread over every piece."""
        share = np.linspace(0, 1, SAMPLES)
        return np.asarray((self.knots[:-1, None] + self.durations[:, None] * share).ravel())

    def peaks(self) -> tuple[float, float, float]:
        """Largest speed, acceleration and snap."""
        _, fast, hard, _, snap = np.linalg.norm(self.at(self.samples(), 5), axis=2)
        return float(fast.max()), float(hard.max()), float(snap.max())

    def stretched(self, factor: float) -> Pieces:
        """The same path, ``factor`` times as long."""
        return Pieces(self.durations * factor, self.coefficients / factor ** np.arange(DEGREE + 1)[:, None])


def minimum_snap(places: Floats, times: Floats, pinned: Mapping[int, Mapping[str, Any]] | None = None) -> Pieces:
    """Through ``places`` (K, 3) at ``times`` (K,), from rest to rest; ``pinned`` derivatives at some of them."""
    from minsnap_trajectories import Waypoint, generate_trajectory

    still = dict.fromkeys(("velocity", "acceleration", "jerk"), np.zeros(3))
    last = len(places) - 1
    through = [
        Waypoint(float(times[k]), places[k], **(still if k in (0, last) else dict((pinned or {}).get(k, {}))))
        for k in range(last + 1)
    ]
    made = generate_trajectory(through, DEGREE, num_continuous_orders=4)
    return Pieces(np.asarray(made.durations), np.asarray(made.coefficients))


def held(place: Floats, seconds: float) -> Pieces:
    """Still at ``place`` (3,)."""
    still = np.zeros((1, DEGREE + 1, 3))
    still[0, 0] = place
    return Pieces(np.array([seconds]), still)


def joined(parts: Sequence[Pieces]) -> Pieces:
    """One after another."""
    return Pieces(
        np.concatenate([part.durations for part in parts]), np.concatenate([part.coefficients for part in parts])
    )


@dataclass(frozen=True)
class Limits:
    """Largest ``speed`` in m/s, ``acceleration`` in m/s² and ``snap`` in m/s⁴: how fast thrust can swing round."""

    speed: float
    acceleration: float
    snap: float


def slack(pieces: Pieces, limits: Limits) -> float:
    """By how much a path from rest to rest must be stretched to keep to the limits, and no more."""
    fast, hard, snap = pieces.peaks()
    swung = float(np.sqrt(np.sqrt(snap / limits.snap)))
    return max(fast / limits.speed, float(np.sqrt(hard / limits.acceleration)), swung)
