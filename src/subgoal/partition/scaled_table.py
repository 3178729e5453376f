"""A likelihood table with every row divided by its largest entry, gone through as the convex solvers need it."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from subgoal._kernels.convex import row_peaks, scaled_columns, spread_of_rows
from subgoal.partition.protocol import Table
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError
from subgoal.runtime.executor import run_all, worker_count

HELD_ENTRIES = 2**27
"""Up to this many entries the scaled table is held whole (1 GiB); above it every pass computes it anew."""
GROUP = 2**20
"""Entries that one job goes through."""


class ScaledTable:
    """M_ig = exp(ℓ_ig − max_h ℓ_ih), so that rows of any scale can be added up.

    Raises ``InputError`` for an observation that no candidate allows, and for NaN and +inf.

    Attributes
    ----------
    peak:
        (N,) max_h ℓ_ih.
    columns:
        (G, N) the scaled table turned, or None where it is not held.
    """

    def __init__(self, table: Table, held_entries: int = HELD_ENTRIES) -> None:
        self._table = table
        self.shape = (table.n_observations, table.n_candidates)
        if not all(self.shape):
            raise InputError("table", found=f"shape {self.shape}", wanted="at least one observation and one candidate")
        n, g_count = self.shape
        blocks = max(1, min(n, n * g_count // GROUP))
        self._blocks = list(pairwise(np.linspace(0, n, blocks + 1).astype(int).tolist()))
        self._workers = None if blocks > 1 else 1
        self.peak = np.empty(n)
        self.columns = np.empty((g_count, n)) if n * g_count <= held_entries else None
        run_all(self._scale, self._blocks, workers=self._workers)
        bad = ~np.isfinite(self.peak)
        if bad.any():
            i = int(np.argmax(bad))
            raise InputError(
                "table", where=f"observation {i}", found=f"{self.peak[i]} as the largest log density",
                wanted="a finite one: an observation that at least one candidate allows, and no NaN",
                hint="drop it or add candidates",
            )  # fmt: skip

    def _rows(self, start: int, stop: int) -> Floats:
        dense = self._table.dense
        return self._table.rows(start, stop) if dense is None else dense[start:stop]

    def _scale(self, start: int, stop: int) -> None:
        tile = self._rows(start, stop)
        row_peaks(tile, self.peak[start:stop])
        if self.columns is not None:
            scaled_columns(tile, self.peak[start:stop], start, self.columns)

    def _turned(self, start: int, stop: int) -> Floats:
        """(G, B) of a table that is not held."""
        out = np.empty((self.shape[1], stop - start))
        scaled_columns(self._rows(start, stop), self.peak[start:stop], 0, out)
        return out

    def fitted(self, weights: Floats) -> Floats:
        """(N,) r = M w."""
        if self.columns is not None:
            return np.asarray(weights @ self.columns)
        parts = run_all(lambda a, b: weights @ self._turned(a, b), self._blocks, workers=self._workers)
        return np.concatenate(parts)

    def gradient(self, fitted: Floats) -> Floats:
        """(G,) D_g = Σ_i M_ig / r_i."""
        inverse = 1.0 / fitted
        if self.columns is not None:
            return np.asarray(self.columns @ inverse)
        parts = run_all(lambda a, b: self._turned(a, b) @ inverse[a:b], self._blocks, workers=self._workers)
        return np.asarray(np.sum(parts, axis=0))

    def take(self, candidates: Ints) -> Floats:
        """(s, N) columns of some candidates, one after another."""
        if self.columns is not None:
            return self.columns[candidates]
        parts = run_all(lambda a, b: self._turned(a, b)[candidates], self._blocks, workers=self._workers)
        return np.concatenate(parts, axis=1)

    def spread(self, fitted: Floats) -> tuple[Floats, Floats]:
        """(G,) Σ_i A_ig² and (G,) max_i A_ig of A_ig = M_ig / r_i."""
        inverse, g_count = 1.0 / fitted, self.shape[1]
        squares, largest = np.empty(g_count), np.empty(g_count)
        if self.columns is not None:
            edges = np.linspace(0, g_count, min(g_count, 4 * worker_count(None)) + 1).astype(int).tolist()
            jobs = [(self.columns, inverse, squares, largest, a, b) for a, b in pairwise(edges)]
            run_all(spread_of_rows, jobs, workers=self._workers)
            return squares, largest
        parts = run_all(lambda a, b: self._spread_of_block(inverse[a:b], a, b), self._blocks, workers=self._workers)
        return np.sum([p[0] for p in parts], axis=0), np.max([p[1] for p in parts], axis=0)

    def _spread_of_block(self, inverse: Floats, start: int, stop: int) -> tuple[Floats, Floats]:
        squares, largest = np.empty(self.shape[1]), np.empty(self.shape[1])
        spread_of_rows(self._turned(start, stop), inverse, squares, largest, 0, self.shape[1])
        return squares, largest
