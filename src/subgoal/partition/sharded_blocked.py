"""Sampler ``blocked`` over observations in files: a sweep is one pass over them, and only sums come back.

Random numbers hang on chain, sweep and block of 65,536 observations, and sums of log densities are whole numbers of a
small unit, so that neither the division into files and parts nor the order in which they are done has a say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.shard_rows import draw_directions, draw_rows
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import leave_to_parent
from subgoal.runtime.seeds import stream
from subgoal.storage.shards import BLOCK, Columns, ShardFiles, read_groups

UNIT = 2.0**-30
"""Nats of which sums of log densities are whole numbers: adding them has no order."""
LOWEST = {"<f4": -87.0, "<f8": -700.0}
"""Logarithms of shares below this are held as such: the exponential is no normal number of the type."""
LOST = 2.0**60
"""A sum this many times above all that may be missing from it is right to the last digit."""
NEGLIGIBLE = 2.0**-100
NONE_LEFT = np.zeros((0, 0), np.bool_)


@dataclass(frozen=True, eq=False)
class Compass:
    """Density of unit directions in the plane: −α‖u − û_g‖ − log Z, or uniform within ``near`` of a candidate.

    ``goals`` (2, G) in weighted units; ``uniform`` is the share of the uniform density in the largest one.
    """

    goals: Floats
    near: float
    confidence: float
    uniform: float
    log_normaliser: float


@dataclass(frozen=True, eq=False)
class Part:
    """Some groups of rows of one file: the work of one worker in a sweep.

    ``first_block`` is the block, counted over all files, in which they begin.
    """

    path: Path
    columns: Columns
    groups: range
    group_rows: int
    first_block: int
    compass: Compass | None


@dataclass(frozen=True, eq=False)
class Sums:
    """What a sweep over some rows gives to C chains: counts of the ``cells`` c·G + g that have any, and Σ log shares in
    ``UNIT``."""

    cells: Ints
    counts: Ints
    fits: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Weights:
    """Weights of C chains for M candidates: which they are, log w, w (C, M), and ``least`` (C,), see ``draw_rows``."""

    places: Ints
    log: Floats
    plain: Floats
    least: Floats

    @property
    def room(self) -> tuple[Floats, Floats, Ints]:
        """Working arrays of the loops, and counts (C, M)."""
        size = self.places.size
        return np.empty(size), np.empty(size), np.zeros(self.log.shape, np.int64)


def parts_of(files: ShardFiles, compass: Compass | None, workers: int) -> list[Part]:
    """The files cut at blocks into about two parts for each worker, or one for each file where there are more."""
    blocks = [-(-each.rows // BLOCK) for each in files.files]
    first = np.cumsum([0, *blocks])
    largest = max(1, -(-int(first[-1]) // (2 * workers)))
    group, parts = files.group, []
    for k, each in enumerate(files.files):
        for a, b in pairwise([*range(0, blocks[k], largest), blocks[k]]):
            groups = range(a * BLOCK // group, min(b * BLOCK // group, -(-each.rows // group)))
            path = files.folder / each.name
            parts.append(Part(path, files.columns, groups, group, int(first[k]) + a, compass))
    return parts


def draw_part(part: Part, log_weights: Floats, seed: int, sweep: int) -> Sums:
    """Draw θ_i ∝ w_g L_ig for the rows of one part and C chains of log weights (C, G), the largest 0; keep sums only.

    Raises ``StorageError`` for a file that cannot be read and ``InputError`` where no weight allows an observation.
    """
    leave_to_parent()
    chains, g_count = log_weights.shape
    every = all_weights(log_weights, "<f4" if part.compass is None else "<f8")
    large = every if part.compass is None else large_weights(every)
    counts, totals = np.zeros((chains, g_count), np.int64), [0] * chains
    for start, arrays in _groups(part):
        if start % BLOCK == 0:
            streams = [stream(seed, c, sweep, part.first_block + start // BLOCK) for c in range(chains)]
        rows, fits = len(next(iter(arrays.values()))), np.zeros(chains)
        uniforms = np.stack([each.random(rows) for each in streams])
        if part.compass is None:
            partial, work, drawn = every.room
            draw_rows(arrays["shares"].reshape(rows, g_count), every.log, every.plain, uniforms, every.least, partial,
                      work, drawn, fits, NONE_LEFT)  # fmt: skip
            counts += drawn
        else:
            draw_compass(part.compass, arrays, uniforms, every, large, counts, fits)
        if not np.isfinite(fits).all():
            raise InputError("concentration", found="weights below the smallest number", where=str(part.path),
                             wanted="some weight for every observation", hint="a larger concentration")  # fmt: skip
        totals = [total + round(fit / UNIT) for total, fit in zip(totals, fits.tolist(), strict=True)]
    cells = np.flatnonzero(counts)
    return Sums(cells, counts.ravel()[cells], tuple(totals))


def all_weights(log_weights: Floats, kind: str) -> Weights:
    """All candidates, for shares of type ``kind``."""
    chains, g_count = log_weights.shape
    least = np.full(chains, g_count * LOST * math.exp(LOWEST[kind]))
    return Weights(np.arange(g_count), log_weights, np.exp(log_weights), least)


def large_weights(every: Weights) -> Weights:
    """The candidates whose weight can matter to most rows: the others sum to ``NEGLIGIBLE`` at most in every chain.

    A row whose sum over these is not ``LOST`` times above what the others could add is left to ``every``. The same
    record where that leaves out less than half: no share is above one, so that w_g bounds w_g times it.
    """
    order = np.argsort(-every.plain.max(axis=0), kind="stable")
    after = np.cumsum(every.plain[:, order[::-1]], axis=1)[:, ::-1]
    size = max(1, int((after.max(axis=0) > NEGLIGIBLE).sum()))
    if 2 * size > order.size:
        return every
    places = order[:size]
    least = np.maximum(every.least, LOST * after[:, size])
    return Weights(places, every.log[:, places].copy(), every.plain[:, places].copy(), least)


def draw_compass(
    law: Compass, arrays: dict[str, NDArray[Any]], uniforms: Floats, every: Weights, large: Weights, counts: Ints,
    fits: Floats,
) -> None:  # fmt: skip
    """Add to ``counts`` (C, G) and ``fits`` (C,): all rows over the large weights, those left over all of them."""
    units, states = (np.stack([arrays[a], arrays[b]], axis=1) for a, b in (("along", "across"), ("x", "y")))
    left = NONE_LEFT if large is every else np.zeros(uniforms.shape, bool)
    goals = np.ascontiguousarray(law.goals[:, large.places])
    partial, work, drawn = large.room
    draw_directions(
        units, states, goals, law.near, law.confidence, law.uniform, large.log, large.plain, uniforms, large.least,
        partial, work, drawn, fits, left,
    )  # fmt: skip
    counts[:, large.places] += drawn
    for c in np.flatnonzero(left.any(axis=1)).tolist():
        rows, one = np.flatnonzero(left[c]), slice(c, c + 1)
        partial, work, _ = every.room
        draw_directions(
            units[rows], states[rows], law.goals, law.near, law.confidence, law.uniform, every.log[one],
            every.plain[one], np.ascontiguousarray(uniforms[one, rows]), every.least[one], partial, work, counts[one],
            fits[one], NONE_LEFT,
        )  # fmt: skip


def _groups(part: Part) -> Any:
    """First row within the part, and arrays, of each group."""
    wanted = ("shares",) if part.compass is None else ("along", "across", "x", "y")
    found = read_groups(part.path, part.columns, wanted, part.groups)
    for k, arrays in enumerate(found):
        yield k * part.group_rows, arrays


def together(parts: list[Sums], shape: tuple[int, int]) -> tuple[Ints, tuple[int, ...]]:
    """Counts (C, G) and Σ log shares of all parts."""
    counts = np.zeros(shape, np.int64)
    for part in parts:
        counts.ravel()[part.cells] += part.counts
    return counts, tuple(sum(each) for each in zip(*(part.fits for part in parts), strict=True))
