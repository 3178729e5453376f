"""The likelihood table ℓ[i, g] = log p(a_i | s_i, g): dense when it fits, computed in tiles when it does not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, cast

import numpy as np
from scipy import sparse

from subgoal._kernels.directions import log_sum_tile, relative_tile
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.source import Confidence, Levels, Source
from subgoal.runtime.checks import Floats, Ints, frozen, positive, real_array
from subgoal.runtime.errors import InputError
from subgoal.runtime.executor import run_all

DENSE_ENTRIES = 2**25
"""Largest N·G that is held whole (256 MiB, and as much again while sampling); above it the table is tiled."""
TILE_ENTRIES = 2**17
SOON_MADE = 2**21
MOST_CONFIDENCE = 1e9


@dataclass(frozen=True, eq=False, repr=False)
class LogLikelihood:
    """The N × G table of complete log densities, with what it was made from.

    Attributes
    ----------
    source:
        Gives blocks of rows.
    confidence:
        α, nats per unit of the source's scale (docs/conventions); or one for each candidate (G,), or a law of it.
    candidates, demonstrations:
        The columns and the rows.
    dense_entries:
        Up to this many entries the table is held whole.
    background:
        Prior probability of no subgoal at all: if above zero, one more column, the last, in which every action is as
        likely as any other.
    weight:
        (N,) how many independent observations each one counts for: its row is multiplied by it. None: one.
    """

    source: Source
    confidence: Confidence | Levels
    candidates: Candidates
    demonstrations: Demonstrations
    dense_entries: int = DENSE_ENTRIES
    background: float = 0.0
    weight: Any = None

    def __post_init__(self) -> None:
        if not isinstance(self.confidence, Levels):
            object.__setattr__(self, "confidence", _confidence(self.confidence, self.candidates.n_candidates))
        share = positive("background", self.background, zero=True)
        if share >= 1:
            raise InputError("background", found=share, wanted="a probability below 1")
        if self.weight is not None:
            object.__setattr__(self, "weight", _weights(self.weight, self.n_observations))

    def __repr__(self) -> str:
        size = f"{self.n_observations} × {self.n_candidates} {'held' if self.is_dense else 'tiled'}"
        law = self.confidence
        return (
            f"LogLikelihood({self.source.kind}, {size}, confidence {f'{law:g}' if isinstance(law, float) else 'law'})"
        )

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
        """G, and one more if there is a background."""
        return self.candidates.n_candidates + (self.background > 0)

    @cached_property
    def log_prior(self) -> Floats:
        """(G,) log P(g), the background's last."""
        places: Floats = self.candidates.log_prior
        if not self.background:
            return places
        return np.append(places + np.log1p(-self.background), np.log(self.background))

    @property
    def offset(self) -> Ints:
        """(D+1,) first row of each trajectory, and N."""
        return self.demonstrations.offset

    @property
    def planner(self) -> str:
        """How actions were planned and how wrong that may be, in words; nothing where they were not."""
        told = getattr(self.source, "told", None)
        if told is None:
            return ""
        most = self.confidence.confidences if isinstance(self.confidence, Levels) else self.confidence
        return str(told(float(np.max(most))))

    @property
    def is_dense(self) -> bool:
        """Whether the whole table is held."""
        return self.n_observations * self.n_candidates <= self.dense_entries

    def at(self, confidence: Confidence | Levels) -> LogLikelihood:
        """The same table at another confidence, from the stored actions and candidates."""
        table = replace(self, confidence=confidence)
        table.rows(0, 1)
        return table

    def with_background(self, share: float) -> LogLikelihood:
        """The same table with one more column for behaviour that no subgoal explains, of prior probability ``share``.

        Exploration, standing about: every action is as likely as any other. Observations that most likely have none
        are assigned −1.
        """
        return replace(self, background=share)

    def weighted(self, weight: Any) -> LogLikelihood:
        """The same table with each observation counted as ``weight`` independent ones, a number or (N,).

        The likelihood is raised to that power: a fraction for observations in quick succession, whose errors are
        correlated. Raises ``InputError`` for numbers that are not above zero.
        """
        return replace(self, weight=weight)

    def rows(self, start: int, stop: int) -> Floats:
        """(stop − start, G) log densities."""
        return self._completed(start, self._densities(start, stop))

    def hold(self, densities: Floats) -> None:
        """Take (N, places) log densities that are known already, before anything else is asked of this table."""
        if self.is_dense:
            self.__dict__["dense"] = frozen(self._completed(0, densities))

    def _completed(self, start: int, densities: Floats) -> Floats:
        """With the background's column, and every row times its weight."""
        stop = start + len(densities)
        if self.background:
            densities = np.column_stack([densities, self.source.log_flat(start, stop)])
        return densities if self.weight is None else np.asarray(densities * self.weight[start:stop, None])

    def _densities(self, start: int, stop: int) -> Floats:
        law = self.confidence
        if not isinstance(law, Levels):
            return self.source.log_density(start, stop, law)
        parts = [
            self.source.log_density(start, stop, level) + np.log(share)
            for level, share in zip(law.confidences.tolist(), law.shares.tolist(), strict=True) if share > 0
        ]  # fmt: skip
        return np.asarray(np.logaddexp.reduce(parts, axis=0))

    @cached_property
    def dense(self) -> Floats | None:
        """(N, G) the whole table, read-only, or None when it is tiled."""
        if not self.is_dense:
            return None
        blocks = run_all(self.rows, self._blocks(), workers=self._workers)
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
        parts = run_all(self._log_marginal_rows, self._blocks(), workers=self._workers)
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
        """(N, G) sparse booleans: which observation is at which candidate; none is at the background."""
        blocks = [sparse.csr_array(self.source.arrived(a, b)) for a, b in self._blocks()]
        found = sparse.csr_array(sparse.vstack(blocks))
        shape = self.n_observations, self.n_candidates
        return sparse.csr_array((found.data, found.indices, found.indptr), shape=shape)

    @property
    def _workers(self) -> int | None:
        """One thread for a table that is made in a moment."""
        return 1 if self.n_observations * self.n_candidates <= SOON_MADE else None

    def _blocks(self) -> list[tuple[int, int]]:
        return list(pairwise(self.edges.tolist()))

    def _log_marginal_rows(self, start: int, stop: int) -> Floats:
        plain = self.weight is None and not self.background and isinstance(self.confidence, float)
        if not self.is_dense and plain:
            short = self.source.log_marginal(start, stop, cast(float, self.confidence), self.log_prior)
            if short is not None:
                return short
        tile = self.rows(start, stop) if self.dense is None else self.dense[start:stop]
        out = np.empty(stop - start)
        log_sum_tile(tile, self.log_prior, out)
        return out


def _confidence(given: Any, count: int) -> Confidence:
    """A number above zero, or (G,) of them."""
    if np.ndim(given) == 0:
        number = positive("confidence", given)
        if number > MOST_CONFIDENCE:
            raise InputError("confidence", found=number, wanted=f"at most {MOST_CONFIDENCE:g}")
        return number
    values = real_array("confidence", given, ndim=1)
    if values.shape != (count,) or not ((values > 0) & (values <= MOST_CONFIDENCE)).all():
        found = f"shape {values.shape}, from {values.min():g} to {values.max():g}" if values.size else "none"
        raise InputError("confidence", found=found, wanted=f"({count},) numbers above 0, at most {MOST_CONFIDENCE:g}")
    return np.asarray(frozen(values))


def _weights(given: Any, count: int) -> Floats:
    """(N,) numbers above zero."""
    values = real_array("weight", given, ndim=(0, 1))
    if values.ndim and values.shape != (count,):
        raise InputError("weight", found=f"shape {values.shape}", wanted=f"a number, or ({count},) of them")
    values = np.full(count, values)
    if not (values > 0).all():
        i = int(np.argmax(~(values > 0)))
        raise InputError("weight", where=f"observation {i}", found=values[i], wanted="a number above 0")
    return np.asarray(frozen(values))
