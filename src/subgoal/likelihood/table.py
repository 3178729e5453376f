"""The likelihood table ℓ[i, g] = log p(a_i | s_i, g): dense when it fits, computed in tiles when it does not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal._kernels.directions import log_sum_tile, relative_tile
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array
from subgoal.runtime.errors import InputError
from subgoal.runtime.executor import run_all

DENSE_ENTRIES = 2**25
"""Largest N·G that is held whole (256 MiB, and as much again while sampling); above it the table is tiled."""
TILE_ENTRIES = 2**17
MOST_CONFIDENCE = 1e9


@dataclass(frozen=True)
class DistanceLaw:
    """Law of the distance r = ‖a − a_CL‖ (in units of the scale) under log density −αr − log Z.

    ``upper`` is where a picture of it may end.
    """

    log_normaliser: float
    cdf: Callable[[Floats], Floats]
    upper: float


class Source(Protocol):
    """Where the numbers come from: anything that can give complete log densities for a block of observations."""

    @property
    def kind(self) -> str:
        """A word for provenance, e.g. "directions"."""

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) observations whose row is the same for every candidate."""

    def log_density(self, start: int, stop: int, confidence: float) -> Floats:
        """(stop − start, G) values of log p(a_i | s_i, g)."""

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> Floats | None:
        """(stop − start,) values of log Σ_g p_g L_ig without holding the rows; None if there is no shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """(stop − start, G) True where the observation is at the candidate."""

    def distance_law(self, confidence: float) -> DistanceLaw | None:
        """How ‖a − a_CL‖ is distributed if the model is right; None if there is no such distance."""


@dataclass(frozen=True, eq=False, repr=False)
class LogLikelihood:
    """The N × G table of complete log densities, with what it was made from.

    Attributes
    ----------
    source:
        Gives blocks of rows.
    confidence:
        α, nats per unit of the source's scale (docs/conventions).
    candidates, demonstrations:
        The columns and the rows.
    dense_entries:
        Up to this many entries the table is held whole.
    """

    source: Source
    confidence: float
    candidates: Candidates
    demonstrations: Demonstrations
    dense_entries: int = DENSE_ENTRIES

    def __post_init__(self) -> None:
        object.__setattr__(self, "confidence", positive("confidence", self.confidence))
        if self.confidence > MOST_CONFIDENCE:
            raise InputError("confidence", found=self.confidence, wanted=f"at most {MOST_CONFIDENCE:g}")

    def __repr__(self) -> str:
        size = f"{self.n_observations} × {self.n_candidates} {'held' if self.is_dense else 'tiled'}"
        return f"LogLikelihood({self.source.kind}, {size}, confidence {self.confidence:g})"

    @classmethod
    def from_table(
        cls,
        log_density: Any,
        *,
        candidates: Candidates | None = None,
        demonstrations: Demonstrations | None = None,
        **fields: Any,
    ) -> LogLikelihood:
        """A likelihood from (N, G) numbers of your own; −inf means impossible, NaN and +inf are refused."""
        values = real_array("log_density", log_density, ndim=2, finite=False)
        bad = np.isnan(values) | np.isposinf(values)
        if bad.any() or not values.size:
            where = tuple(int(k) for k in np.argwhere(bad)[0]) if values.size else ()
            found = values[where] if values.size else f"shape {values.shape}"
            raise InputError("log_density", where=f"index {where}", found=found, wanted="a number below +inf")
        n, g_count = values.shape
        candidates = candidates or Candidates(points=np.arange(g_count, dtype=float)[:, None])
        demonstrations = demonstrations or Demonstrations.from_arrays(np.arange(n, dtype=float), np.zeros(n))
        for what, size, wanted in (
            ("candidates", candidates.n_candidates, g_count),
            ("demonstrations", demonstrations.n_observations, n),
        ):
            if size != wanted:
                raise InputError(what, found=size, wanted=f"{wanted}, as the table of shape {values.shape}")
        return cls(FixedTable(values), 1.0, candidates, demonstrations, **fields)

    @property
    def n_observations(self) -> int:
        """N."""
        return self.demonstrations.n_observations

    @property
    def n_candidates(self) -> int:
        """G."""
        return self.candidates.n_candidates

    @property
    def log_prior(self) -> Floats:
        """(G,) log P(g)."""
        return self.candidates.log_prior  # type: ignore[no-any-return]

    @property
    def offset(self) -> Ints:
        """(D+1,) first row of each trajectory, and N."""
        return self.demonstrations.offset

    @property
    def is_dense(self) -> bool:
        """Whether the whole table is held."""
        return self.n_observations * self.n_candidates <= self.dense_entries

    def at(self, confidence: float) -> LogLikelihood:
        """The same table at another confidence, from the stored actions and candidates."""
        table = replace(self, confidence=confidence)
        table.rows(0, 1)
        return table

    def rows(self, start: int, stop: int) -> Floats:
        """(stop − start, G) log densities."""
        return self.source.log_density(start, stop, self.confidence)

    @cached_property
    def dense(self) -> Floats | None:
        """(N, G) the whole table, read-only, or None when it is tiled."""
        if not self.is_dense:
            return None
        blocks = run_all(self.rows, self._blocks(), workers=None)
        return np.asarray(frozen(np.concatenate(blocks)))

    def tiles(self) -> Iterator[tuple[int, Floats]]:
        """Consecutive blocks of rows, as (first row, (rows, G) values)."""
        for start, stop in self._blocks():
            yield start, self.rows(start, stop) if self.dense is None else self.dense[start:stop]

    @property
    def edges(self) -> Ints:
        """Boundaries of the blocks of rows, from 0 to N; the same whether the table is held or not."""
        blocks = max(1, -(-self.n_observations * self.n_candidates // TILE_ENTRIES))
        return np.linspace(0, self.n_observations, min(blocks, self.n_observations) + 1).astype(np.int64)

    @cached_property
    def log_marginal(self) -> Floats:
        """(N,) log Σ_g p_g L_ig: each observation on its own.

        Raises ``InputError`` for an observation that is impossible under every candidate, or not a number.
        """
        parts = run_all(self._log_marginal_rows, self._blocks(), workers=None)
        values = np.concatenate(parts)
        if not np.isfinite(values).all():
            i = int(np.argmax(~np.isfinite(values)))
            raise InputError(
                "likelihood", where=f"observation {i}", found=f"log density {values[i]} summed over all candidates",
                wanted="an observation that at least one candidate allows", hint="drop it or add candidates",
            )  # fmt: skip
        return np.asarray(frozen(values))

    @cached_property
    def relative(self) -> Floats | None:
        """(N, G) L_ig / Σ_g p_g L_ig, or None when the table is tiled."""
        return None if self.dense is None else np.asarray(frozen(self.relative_tile(0, self.dense)))

    def relative_tile(self, start: int, tile: Floats) -> Floats:
        """The ratio L_ig / Σ_g p_g L_ig for the rows of one tile."""
        ratio = np.empty(tile.shape)
        relative_tile(tile, self.log_marginal[start : start + len(tile)], ratio)
        return ratio

    @cached_property
    def arrived(self) -> sparse.csr_array:
        """(N, G) sparse booleans: which observation is at which candidate."""
        blocks = [sparse.csr_array(self.source.arrived(a, b)) for a, b in self._blocks()]
        return sparse.csr_array(sparse.vstack(blocks))

    def _blocks(self) -> list[tuple[int, int]]:
        return list(pairwise(self.edges.tolist()))

    def _log_marginal_rows(self, start: int, stop: int) -> Floats:
        if not self.is_dense:
            short = self.source.log_marginal(start, stop, self.confidence, self.log_prior)
            if short is not None:
                return short
        tile = self.rows(start, stop) if self.dense is None else self.dense[start:stop]
        out = np.empty(stop - start)
        log_sum_tile(tile, self.log_prior, out)
        return out


@dataclass(frozen=True, eq=False)
class FixedTable:
    """A source of numbers that are already there."""

    values: Floats
    kind: str = field(default="table", init=False)

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) rows in which every candidate is equally likely."""
        return np.asarray((self.values == self.values[:, :1]).all(axis=1))

    def log_density(self, start: int, stop: int, confidence: float) -> Floats:
        """Rows as given; only confidence 1 is known of such a table."""
        if confidence != 1.0:
            raise InputError("confidence", found=confidence, wanted="1, for a table of given numbers")
        return self.values[start:stop]

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> None:
        """No shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Nothing is known of places."""
        return np.zeros(self.values[start:stop].shape, bool)

    def distance_law(self, confidence: float) -> None:
        """Nothing is known of distances."""
