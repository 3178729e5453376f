"""Draws of the law by which subgoals follow each other, given what a posterior has learned, and its forward filter.

The one place that knows how each model goes on: held-out demonstrations, live ones and those of the posterior itself
are all filtered here.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np

from subgoal._kernels.filters import filter_persistent, filter_transitions
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.priors import SMALLEST_LOG, log_weights
from subgoal.posterior.posterior import CountDraws, Posterior
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

ROWS = 1e-300
"""Shapes of rows of transitions are kept above this, so that their logarithms are numbers."""
BLOCK_ENTRIES = 2**20
"""Filtered probabilities that are held at a time: draws × observations × candidates."""
STREAM = 85


@dataclass(frozen=True, eq=False)
class Rows:
    """A block of observations as a filter takes them.

    Attributes
    ----------
    relative:
        (B, G) L_ig / Σ_g p_g L_ig.
    first:
        (B,) which are the first of a trajectory.
    there_from, there:
        Which observation is at which candidate: ``there[there_from[r]:there_from[r + 1]]``.
    """

    relative: Floats
    first: Bools
    there_from: Ints
    there: Ints


class Laws(Protocol):
    """S draws of a law."""

    @property
    def n_draws(self) -> int:
        """S."""

    @property
    def minds_arrival(self) -> bool:
        """Whether it matters which observation is at which candidate."""

    def filter(self, rows: Rows, entering: Floats, out: Floats, log_total: Floats) -> None:
        """Write the filtered laws (S, B, G) and totals (S, B) of a block; ``entering`` (S, G) is the law before it."""


@dataclass(frozen=True, eq=False)
class SharedWeights:
    """Weights (S, G) that all redraws share, and the probabilities (S,) of keeping the subgoal, elsewhere and at it.

    Without persistence both are 0, and this is the exchangeable mixture.
    """

    weights: Floats
    keep: Floats
    keep_there: Floats

    @property
    def n_draws(self) -> int:
        """S."""
        return len(self.weights)

    @property
    def minds_arrival(self) -> bool:
        """Whether it matters which observation is at which candidate."""
        return bool((self.keep_there != self.keep).any())

    def filter(self, rows: Rows, entering: Floats, out: Floats, log_total: Floats) -> None:
        """See ``Laws``."""
        filter_persistent(
            rows.relative, rows.first, rows.there_from, rows.there, self.weights, self.keep, self.keep_there, entering,
            out, log_total,
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Transitions:
    """Law (S, G) of the first subgoal, and of the next one after each as sparse rows, see ``filter_transitions``."""

    first: Floats
    row_from: Ints
    column: Ints
    above: Floats

    @property
    def n_draws(self) -> int:
        """S."""
        return len(self.first)

    @property
    def minds_arrival(self) -> bool:
        """Never."""
        return False

    def filter(self, rows: Rows, entering: Floats, out: Floats, log_total: Floats) -> None:
        """See ``Laws``."""
        filter_transitions(
            rows.relative, rows.first, self.first, self.row_from, self.column, self.above, entering, out, log_total
        )


def draw_laws(posterior: Posterior, rows: Ints, seed: int) -> Laws:
    """One law for each of some draws, ``rows`` of chains × draws: drawn given the counts of the draw.

    The law of row r hangs on ``seed`` and r alone. Raises ``InputError`` for groups, for a posterior without its
    likelihood, and for ``StickyHMM`` without assignments.
    """
    posterior.known_likelihood  # noqa: B018  (needed by all of them)
    streams = [stream(seed, STREAM, row) for row in rows.tolist()]
    if "stickiness" in posterior.parameters:
        return _transitions(posterior, rows, streams)
    if "persistence" in posterior.parameters or posterior.redraws is None or "Persistent(" in posterior.settings.model:
        return _shared_weights(posterior, rows, streams)
    raise InputError("posterior", found=posterior.settings.model, wanted="a model of one sequence, without groups")


def run(laws: Laws, table: LogLikelihood) -> Iterator[tuple[int, Floats, Floats]]:
    """Filter all rows of a table: (first row, filtered (S, B, G), log p(a_i | before) (S, B)) for block after block.

    The totals are complete: no constant is left out. What is given is written over by the next block.
    """
    first = np.zeros(table.n_observations, bool)
    first[table.offset[:-1]] = True
    g_count = table.n_candidates
    entering = np.zeros((laws.n_draws, g_count))
    most = max(1, BLOCK_ENTRIES // (laws.n_draws * g_count))
    for start, tile in table.tiles():
        edges = [*range(0, len(tile), most), len(tile)]
        relative = table.relative_tile(start, tile)
        for a, b in pairwise(edges):
            block = Rows(relative[a:b], first[start + a : start + b], *_there(laws, table, start + a, start + b))
            out, log_total = np.empty((laws.n_draws, b - a, g_count)), np.empty((laws.n_draws, b - a))
            laws.filter(block, entering, out, log_total)
            entering = out[:, -1].copy()
            yield start + a, out, log_total + table.log_marginal[start + a : start + b]


def _there(laws: Laws, table: LogLikelihood, start: int, stop: int) -> tuple[Ints, Ints]:
    if not laws.minds_arrival:
        return np.zeros(stop - start + 1, np.int64), np.empty(0, np.int64)
    pointer = table.arrived.indptr[start : stop + 1].astype(np.int64)
    return pointer - pointer[0], table.arrived.indices[pointer[0] : pointer[-1]].astype(np.int64)


def _shared_weights(posterior: Posterior, rows: Ints, streams: list[np.random.Generator]) -> SharedWeights:
    weights = np.empty((rows.size, _columns(posterior)))
    for k, (row, generator) in enumerate(zip(rows.tolist(), streams, strict=True)):
        counts = _counts(_redraws(posterior), row, weights.shape[1])
        if posterior.redraws is None and posterior.settings.background:
            counts[-1] = posterior.n_observations - counts.sum()
        weights[k] = np.exp(log_weights(_concentration(posterior, row) * _prior(posterior) + counts, generator))
    keep = np.array([_parameter(posterior, "persistence", row) or 0.0 for row in rows.tolist()])
    if "persistence at the subgoal" not in posterior.parameters:
        return SharedWeights(weights, keep, keep)
    there = [_parameter(posterior, "persistence at the subgoal", row) or 0.0 for row in rows.tolist()]
    return SharedWeights(weights, keep, np.array(there))


def _transitions(posterior: Posterior, rows: Ints, streams: list[np.random.Generator]) -> Transitions:
    if posterior.assignments is None:
        raise InputError("posterior.assignments", found="None: they were not kept", wanted="all draws")
    size, held = _columns(posterior), 0
    first, row_from = np.empty((rows.size, size)), np.empty((rows.size, size + 1), np.int64)
    columns, above = [], []
    for k, (row, generator) in enumerate(zip(rows.tolist(), streams, strict=True)):
        first[k], log_rows = _one_of_transitions(posterior, row, size, generator)
        inside, column = np.nonzero(log_rows > SMALLEST_LOG)
        row_from[k] = held + np.searchsorted(inside, np.arange(size + 1))
        columns.append(column)
        above.append(np.exp(log_rows[inside, column]))
        held += column.size
    return Transitions(first, row_from, np.concatenate(columns), np.concatenate(above))


def _one_of_transitions(
    posterior: Posterior, row: int, size: int, generator: np.random.Generator
) -> tuple[Floats, Floats]:
    """Law of the first subgoal (G,), and logarithms of the law of the next after each (G, G), drawn for one draw."""
    assignments = np.asarray(posterior.assignments)
    shared = _counts(_redraws(posterior), row, size)
    base = np.exp(log_weights(_concentration(posterior, row) * _prior(posterior) + shared, generator))
    mass, sticky = _parameter(posterior, "row mass", row) or 0.0, _parameter(posterior, "stickiness", row) or 0.0
    theta = assignments.reshape(-1, posterior.n_observations)[row]
    theta = np.where(theta < 0, size - 1, theta)
    begins = posterior.demonstrations.offset[:-1]
    inside = np.setdiff1d(np.arange(1, theta.size), begins)
    counts = np.zeros((size, size))
    np.add.at(counts, (theta[inside - 1], theta[inside]), 1)
    shape = np.maximum(mass * (1 - sticky) * base, ROWS)
    log_rows = np.stack([
        log_weights(shape + counts[j] + mass * sticky * (np.arange(size) == j), generator) for j in range(size)
    ])  # fmt: skip
    return np.exp(log_weights(shape + np.bincount(theta[begins], minlength=size), generator)), log_rows


def _columns(posterior: Posterior) -> int:
    return posterior.candidates.n_candidates + (posterior.settings.background > 0)


def _prior(posterior: Posterior) -> Floats:
    return np.exp(posterior.known_likelihood.log_prior)


def _redraws(posterior: Posterior) -> CountDraws:
    return posterior.counts if posterior.redraws is None else posterior.redraws


def _counts(draws: CountDraws, row: int, size: int) -> Floats:
    part = slice(int(draws.offset[row]), int(draws.offset[row + 1]))
    counts = np.zeros(size)
    counts[draws.candidate[part]] = draws.count[part]
    return counts


def _concentration(posterior: Posterior, row: int) -> float:
    learned = _parameter(posterior, "concentration", row)
    return posterior.concentration if learned is None else learned


def _parameter(posterior: Posterior, name: str, row: int) -> float | None:
    if name not in posterior.parameters:
        return None
    return float(posterior.parameters[name].ravel()[row])
