"""Chains of assignments that grow with their data, and their latest draws."""

from __future__ import annotations

import numpy as np

from subgoal._kernels.directions import log_sum_tile, relative_tile
from subgoal._kernels.streaming import move_table, redraw_some
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.protocol import Chain, Int32s, Stretch
from subgoal.runtime.checks import Bools, Floats
from subgoal.runtime.seeds import stream
from subgoal.streaming.growing import with_room
from subgoal.streaming.table import GrowingTable

RECENT, OLDER = 16, 16
"""Pairs that are redrawn with a new one: the ones before it, and some of the others by lot."""
ROUNDS = 8
"""So often, each time followed by the move of one table; what comes of it is a draw."""
KEPT = 16
"""Latest draws of each chain that are kept."""
FIRST_ROOM = 256


class Chains:
    """``count`` chains over the assignments of the pairs so far; it changes.

    Chain k draws from the stream (seed, k); which old pairs are redrawn is the same for all chains.
    """

    def __init__(self, count: int, seed: int) -> None:
        self.generators = [stream(seed, k) for k in range(count)]
        self._lot = stream(seed, count)
        self._theta = np.zeros((count, FIRST_ROOM), np.int32)
        self._latest = np.zeros((KEPT, count, FIRST_ROOM), np.int32)
        self._size = self._pushed = 0

    @property
    def count(self) -> int:
        """How many chains."""
        return len(self.generators)

    @property
    def theta(self) -> Int32s:
        """(chains, N) candidate of each pair, where each chain is now."""
        return self._theta[:, : self._size]

    @property
    def latest(self) -> Int32s:
        """(chains, draws, N) draws of late; a pair newer than a draw is where its chain put it first."""
        held = min(self._pushed, KEPT)
        return np.ascontiguousarray(self._latest[:held, :, : self._size].swapaxes(0, 1))

    def seat(self, table: GrowingTable, concentration: float) -> None:
        """Draw the newest pair's candidate given all others, then redraw some old pairs and move some tables."""
        n, log_prior = table.n_pairs, table.candidates.log_prior
        self._theta = _longer(self._theta, n)
        self._latest = _longer(self._latest, n)
        self._theta[:, n - 1], self._size = 0, n
        rows = self._rows(n)
        relative = _relative(table.values[rows, : table.n_candidates], log_prior)
        prior = np.exp(log_prior)
        for k in range(ROUNDS):
            i = int(self._lot.integers(max(0, n - RECENT) if k % 2 else 0, n))
            for theta, generator in zip(self.theta, self.generators, strict=True):
                redraw_some(rows, relative, theta, prior, concentration, generator)
                move_table(i, table.values, theta, concentration * prior, log_prior, generator)
            if k == 0:
                self._latest[:, :, n - 1] = self._theta[:, n - 1]
            self._push(self.theta)

    def sweep(self, likelihood: LogLikelihood, concentration: float, sweeps: int) -> None:
        """Whole sweeps of ``collapsed_blocks``, the last ones kept."""
        keep = np.arange(sweeps) >= sweeps - KEPT
        stretches = self.advance(likelihood, concentration, keep)
        for draws in np.stack([each.assignments for each in stretches], axis=1):
            self._push(draws)

    def advance(self, likelihood: LogLikelihood, concentration: float, keep: Bools) -> list[Stretch]:
        """``len(keep)`` sweeps of every chain, from where it is."""
        made = []
        for theta, generator in zip(self.theta, self.generators, strict=True):
            made.append(collapsed_blocks(Chain(likelihood, concentration, generator, {"theta": theta}), keep))
            theta[:] = made[-1].state["theta"]
        return made

    def _rows(self, n: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        """The newest pair, those before it, and some older ones, all different."""
        older = max(0, n - 1 - RECENT)
        some = self._lot.choice(older, min(OLDER, older), replace=False)
        return np.concatenate([np.arange(n - 1, older - 1, -1), some])

    def _push(self, draws: Int32s) -> None:
        self._latest[self._pushed % KEPT, :, : self._size] = draws
        self._pushed += 1


def _longer(array: Int32s, size: int) -> Int32s:
    """With room for ``size`` in the last axis."""
    return with_room(array, *array.shape[:-1], size)


def _relative(tile: Floats, log_prior: Floats) -> Floats:
    """(B, G) L_ig / Σ_g p_g L_ig."""
    marginal, relative = np.empty(len(tile)), np.empty(tile.shape)
    log_sum_tile(tile, log_prior, marginal)
    relative_tile(tile, marginal, relative)
    return relative
