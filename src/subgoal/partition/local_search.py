"""Local search for the assignment θ of greatest log p(θ, O), weights integrated out.

With n the counts and φ_g(n) = log Γ(n + ηp_g) − log Γ(ηp_g), log p(θ, O) is Σ_i ℓ_iθ + Σ_g φ_g(n_g) and a constant.
Moves: one observation; all of one candidate to another, used (a merger) or not; a candidate drawing all that would
gain if it were larger, used or not (an opening). Where no single move gains, exchanging two observations loses
log[(n_g − 1 + ηp_g)(n_h − 1 + ηp_h) / ((n_g + ηp_g)(n_h + ηp_h))] at least, so that exchanges need not be tried.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import gammaln

from subgoal._kernels.local_search import gains_of_growing, log_joint_of_counts, move_rows, sums_of_clusters
from subgoal.partition.protocol import Int32s, Table
from subgoal.partition.row_blocks import over_rows
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.interrupt import Interrupt

LEAST_GAIN = 1e-9
SMALL = 2**22
"""Tables of fewer entries are tried with every doubling of how large a candidate might become, larger ones every 8×."""


@dataclass
class Search:
    """A state of the search, which its methods improve.

    Attributes
    ----------
    table, mass:
        ℓ, and (G,) ηp.
    theta:
        (N,) candidate of each observation.
    """

    table: Table
    mass: Floats
    theta: Int32s

    def __post_init__(self) -> None:
        self.counts: Ints = np.bincount(self.theta, minlength=self.mass.size).astype(np.int64)

    def log_likelihood(self) -> float:
        """Σ_i ℓ_iθ."""
        return float(np.concatenate(over_rows(self.table, self._own)).sum())

    def log_joint(self) -> float:
        """log p(θ, O)."""
        return self.log_likelihood() + float(log_joint_of_counts(self.counts, self.mass))

    def run(self, interrupt: Interrupt) -> bool:
        """Move until no move of any kind gains; False if interrupted before."""
        while True:
            self._settle(interrupt)
            if interrupt.requested:
                return False
            if not self._merge() and not self._grow():
                return True

    def _own(self, start: int, tile: Floats) -> Floats:
        return np.asarray(tile[np.arange(len(tile)), self.theta[start : start + len(tile)]])

    def _settle(self, interrupt: Interrupt) -> None:
        """Single moves, pass after pass."""
        level = np.log(self.counts + self.mass)
        moved = 1
        while moved and not interrupt.requested:
            moved = 0
            for start, tile in self.table.tiles():
                moved += move_rows(start, tile, self.theta, self.counts, self.mass, level, LEAST_GAIN)

    def _places(self) -> tuple[Ints, Ints]:
        used = np.flatnonzero(self.counts)
        place = np.full(self.mass.size, -1)
        place[used] = np.arange(used.size)
        return used, place

    def _rise(self, counts: Ints, more: Ints) -> Floats:
        """Σ over the first axis of φ(counts + more) − φ(counts); both (..., G) or broadcast to it."""
        return np.asarray(gammaln(counts + more + self.mass) - gammaln(counts + self.mass))

    def _merge(self) -> bool:
        """Whole candidates go elsewhere, the best first."""
        used, place = self._places()

        def block(start: int, tile: Floats) -> Floats:
            sums = np.zeros((used.size, self.mass.size))
            sums_of_clusters(start, tile, self.theta, place, sums)
            return sums

        sums: Floats = np.sum(over_rows(self.table, block), axis=0)
        merged = False
        while True:
            size = self.counts[used][:, None]
            left = gammaln(size[:, 0] + self.mass[used]) - gammaln(self.mass[used])
            here = sums[np.arange(used.size), used]
            gain = sums - here[:, None] + self._rise(self.counts[None], size) - left[:, None]
            gain[np.arange(used.size), used] = -np.inf
            k, to = (int(index) for index in np.unravel_index(np.argmax(gain), gain.shape))
            if not gain[k, to] > LEAST_GAIN * self.theta.size:
                return merged
            merged = True
            self.theta[self.theta == used[k]] = to
            self.counts[to] += self.counts[used[k]]
            self.counts[used[k]] = 0
            if to in used:
                sums[np.flatnonzero(used == to)[0]] += sums[k]
                sums, used = np.delete(sums, k, axis=0), np.delete(used, k)
            else:
                used[k] = to

    def _grow(self) -> bool:
        """The candidate and the supposed growth that gain most together, if any gain."""
        n, (used, place) = self.theta.size, self._places()
        own = np.log(np.maximum(self.counts - 1, 0) + self.mass)
        factor = 2 if n * self.mass.size < SMALL else 8
        best = (LEAST_GAIN * n, -1, 0)
        supposed = 1
        while supposed <= n:
            change = self._change_by_growth(used, place, own, np.log(self.counts + supposed + self.mass))
            h = int(np.argmax(change))
            if change[h] > best[0]:
                best = (float(change[h]), h, supposed)
            supposed *= factor
        _, h, supposed = best
        if h < 0:
            return False
        level = float(np.log(self.counts[h] + supposed + self.mass[h]))

        def block(start: int, tile: Floats) -> np.ndarray:
            theta = self.theta[start : start + len(tile)]
            return np.asarray((tile[:, h] + level > self._own(start, tile) + own[theta]) & (theta != h))

        self.theta[np.concatenate(over_rows(self.table, block))] = h
        self.counts = np.bincount(self.theta, minlength=self.mass.size).astype(np.int64)
        return True

    def _change_by_growth(self, used: Ints, place: Ints, own: Floats, level: Floats) -> Floats:
        """(G,) exact change of log p(θ, O) if all who would gain at ``level`` went to the candidate."""

        def block(start: int, tile: Floats) -> tuple[Floats, Ints]:
            gain, moved = np.zeros(self.mass.size), np.zeros((used.size, self.mass.size), np.int64)
            gains_of_growing(start, tile, self.theta, place, own, level, gain, moved)
            return gain, moved

        parts = over_rows(self.table, block)
        moved = np.sum([part[1] for part in parts], axis=0)
        left = self.counts[used][:, None] + self.mass[used][:, None]
        lost = gammaln(left - moved) - gammaln(left)
        coming = moved.sum(axis=0)
        change = np.sum([part[0] for part in parts], axis=0) + self._rise(self.counts, coming) + lost.sum(axis=0)
        return np.where(coming > 0, change, -np.inf)
