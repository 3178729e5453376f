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
    """What a sweep over some rows gives: counts (C, G), and Σ log shares of each chain in ``UNIT``."""

    counts: Ints
    fits: tuple[int, ...]


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
    kind = "<f4" if part.compass is None else "<f8"
    least = g_count * LOST * math.exp(LOWEST[kind])
    room = np.empty(g_count), np.empty(g_count)
    counts, totals = np.zeros((chains, g_count), np.int64), [0] * chains
    given = log_weights, np.exp(log_weights)
    for start, arrays in _groups(part):
        if start % BLOCK == 0:
            streams = [stream(seed, c, sweep, part.first_block + start // BLOCK) for c in range(chains)]
        rows, fits = len(next(iter(arrays.values()))), np.zeros(chains)
        uniforms = np.stack([each.random(rows) for each in streams])
        rest = *given, uniforms, least, *room, counts, fits
        if part.compass is None:
            draw_rows(arrays["shares"].reshape(rows, g_count), *rest)
        else:
            law = part.compass
            units, states = (np.stack([arrays[a], arrays[b]], axis=1) for a, b in (("along", "across"), ("x", "y")))
            draw_directions(units, states, law.goals, law.near, law.confidence, law.uniform, *rest)
        if not np.isfinite(fits).all():
            raise InputError("concentration", found="weights below the smallest number", where=str(part.path),
                             wanted="some weight for every observation", hint="a larger concentration")  # fmt: skip
        totals = [total + round(fit / UNIT) for total, fit in zip(totals, fits.tolist(), strict=True)]
    return Sums(counts, tuple(totals))


def _groups(part: Part) -> Any:
    """First row within the part, and arrays, of each group."""
    wanted = ("shares",) if part.compass is None else ("along", "across", "x", "y")
    found = read_groups(part.path, part.columns, wanted, part.groups)
    for k, arrays in enumerate(found):
        yield k * part.group_rows, arrays


def together(parts: list[Sums]) -> Sums:
    """The sums of all parts."""
    fits = tuple(sum(each) for each in zip(*(part.fits for part in parts), strict=True))
    return Sums(np.sum([part.counts for part in parts], axis=0), fits)
