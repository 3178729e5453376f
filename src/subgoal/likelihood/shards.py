"""``Shards``: the likelihood of more observations than fit in memory, as a folder of files; writing and opening them.

Two kinds. "stored" holds the table as float32 shares of each row's largest likelihood. "directions" holds positions
and directions of motion, from which rows are computed when they are needed and never held.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal._kernels.shard_rows import encode
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.likelihood import normalisers
from subgoal.likelihood.action_comparison import DEFAULT_CONFIDENCE
from subgoal.likelihood.sources import Directions
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.sharded_blocked import LOWEST, UNIT, Compass
from subgoal.runtime.checks import Floats, positive, real_array
from subgoal.runtime.errors import InputError, StorageError
from subgoal.storage.archive import digest_arrays
from subgoal.storage.shards import ROWS, ShardFiles, ShardWriter, open_files

STORED, DIRECTIONS = "stored", "directions"
DIRECTION_COLUMNS = dict.fromkeys(("x", "y", "along", "across"), ("<f8", 1))
PARTS = 2**16
"""Rows that are written at a time."""


@dataclass(frozen=True, eq=False, repr=False)
class Shards:
    """N observations in files, and what their likelihood is.

    Attributes
    ----------
    files:
        The folder, its files and their checksums.
    candidates:
        The columns; without the sets of states of a discrete world.
    background:
        Prior probability of no subgoal at all, the last column if above zero.
    confidence:
        α in nats, or in words where a stored table does not tell one number.
    """

    files: ShardFiles
    candidates: Candidates
    background: float
    confidence: float | str

    def __repr__(self) -> str:
        size = f"{self.n_observations:,} × {self.n_candidates}"
        return f"Shards({self.kind}, {size}, {len(self.files.files)} files in {self.files.folder})"

    @property
    def kind(self) -> str:
        """ "stored" or "directions"."""
        return str(self.files.head["kind"])

    @property
    def n_observations(self) -> int:
        """N."""
        return self.files.rows

    @property
    def n_candidates(self) -> int:
        """G, and one more if there is a background."""
        return self.candidates.n_candidates + (self.background > 0)

    @property
    def log_prior(self) -> Floats:
        """(G,) log P(g), the background's last."""
        return log_prior_of(self.candidates, self.background)

    @property
    def peaks(self) -> int:
        """Σ of each row's largest log density, in units of ``UNIT`` nats."""
        if self.kind == STORED:
            return int(self.files.head["peaks"])
        return round(-self.compass.log_normaliser * self.n_observations / UNIT)

    @property
    def compass(self) -> Compass:
        """From positions and directions to densities. Raises ``InputError`` for a stored table."""
        if self.kind != DIRECTIONS:
            raise InputError("shards", found=f"of kind {self.kind!r}", wanted=f"of kind {DIRECTIONS!r}")
        return compass_of(self.candidates, float(self.confidence))

    @property
    def checksum(self) -> str:
        """One number for the data and the candidates; how the rows are divided into files has no part in it."""
        seal = np.frombuffer(bytes.fromhex(self.files.content), np.uint8)
        metric = self.candidates.metric
        return digest_arrays(
            seal, self.candidates.points, self.log_prior, self.candidates.radius, metric.weights, metric.period
        )


def log_prior_of(candidates: Candidates, background: float) -> Floats:
    """(G,) log P(g), with the background's as the last if there is one."""
    places: Floats = candidates.log_prior
    return np.append(places + np.log1p(-background), np.log(background)) if background else places


def compass_of(candidates: Candidates, confidence: float) -> Compass:
    """The density of unit directions in the plane, equation (5.1) with (5.2), complete."""
    log_z = normalisers.log_direction_normaliser(confidence, 2)
    goals = np.ascontiguousarray((candidates.points * candidates.metric.weights).T)
    uniform = math.exp(log_z - normalisers.log_sphere_area(2))
    return Compass(goals, candidates.radius / 2, confidence, uniform, log_z)


class DirectionWriter:
    """Writes positions and actions in the plane as they come, so that no more than a few blocks are in memory.

    ``slow``: pairs of at most this speed say nothing of a goal (``action_comparison`` takes 1 % of the median).
    Use it in a ``with`` statement; then ``open_shards(folder)``.
    """

    def __init__(
        self, folder: str | Path, candidates: Candidates, *, confidence: float = DEFAULT_CONFIDENCE, slow: float = 0.0,
        rows: int = ROWS,
    ) -> None:  # fmt: skip
        metric = candidates.metric
        if candidates.points.shape[1] != 2 or not np.isinf(metric.period).all():
            raise InputError("candidates", found=f"{candidates.points.shape[1]} dimensions, period {metric.period}",
                             wanted="places in the plane, without angles",
                             hint="write_shards of a LogLikelihood, which stores its table")  # fmt: skip
        self._weights, self._slow = metric.weights, positive("slow", slow, zero=True)
        self._writer = ShardWriter(folder, DIRECTION_COLUMNS, rows)
        number = positive("confidence", confidence)
        self._writer.head |= _head(DIRECTIONS, candidates, 0.0, number)

    def __enter__(self) -> DirectionWriter:
        self._writer.__enter__()
        return self

    def __exit__(self, *failure: Any) -> None:
        self._writer.__exit__(*failure)

    def append(self, positions: Any, actions: Any) -> None:
        """Take (B, 2) positions and actions, in the units of the candidates. Raises ``InputError`` for NaN."""
        places, moves = real_array("positions", positions, ndim=2), real_array("actions", actions, ndim=2)
        for what, array in (("positions", places), ("actions", moves)):
            if array.shape != (len(places), 2):
                raise InputError(what, found=f"shape {array.shape}", wanted=f"({len(places)}, 2)")
        moves = moves * self._weights
        speed = np.hypot(moves[:, 0], moves[:, 1])
        moving = speed > self._slow
        self.append_units(places * self._weights, moves / np.where(moving, speed, 1.0)[:, None] * moving[:, None])

    def append_units(self, states: Floats, units: Floats) -> None:
        """Take (B, 2) weighted positions and unit directions, of length 0 where nothing is said of a goal."""
        self._writer.append(x=states[:, 0], y=states[:, 1], along=units[:, 0], across=units[:, 1])


def write_shards(likelihood: LogLikelihood, folder: str | Path, *, kind: str = STORED, rows: int = ROWS) -> Shards:
    """Write a likelihood table, tile by tile, as shards of at most ``rows`` rows.

    ``kind``: "stored", of any likelihood; or "directions", of action comparison by direction in the plane.
    Raises ``InputError`` for an observation that no candidate allows, a folder that holds shards already, ``rows``
    that is not a multiple of 65,536, and a likelihood that cannot be computed from directions in the plane.
    """
    if kind == STORED:
        return _write_stored(likelihood, folder, rows)
    if kind != DIRECTIONS:
        raise InputError("kind", found=repr(kind), wanted=f"{STORED!r} or {DIRECTIONS!r}")
    source, law = likelihood.source, likelihood.confidence
    plain = likelihood.weight is None and not likelihood.background and isinstance(law, float)
    if not isinstance(source, Directions) or not plain:
        raise InputError("likelihood", found=repr(likelihood), wanted="directions of one confidence, without weights "
                         "and background", hint=f"kind={STORED!r}")  # fmt: skip
    with DirectionWriter(folder, likelihood.candidates, confidence=float(str(law)), rows=rows) as writer:
        for start in range(0, likelihood.n_observations, PARTS):
            part = slice(start, start + PARTS)
            writer.append_units(source.states[part], source.units[part] * ~source.slow[part, None])
    return open_shards(folder)


def _write_stored(likelihood: LogLikelihood, folder: str | Path, rows: int) -> Shards:
    g_count = likelihood.n_candidates
    columns = {"shares": ("<f4", g_count), "peak": ("<f8", 1)}
    law = likelihood.confidence
    total = 0
    with ShardWriter(folder, columns, rows) as writer:
        for start, tile in likelihood.tiles():
            shares, peaks = np.empty(tile.shape, np.float32), np.empty(len(tile))
            encode(tile, LOWEST["<f4"], shares, peaks)
            if not np.isfinite(peaks).all():
                i = int(np.argmax(~np.isfinite(peaks)))
                raise InputError(
                    "likelihood", where=f"observation {start + i}", found=f"largest log density {peaks[i]}",
                    wanted="an observation that at least one candidate allows", hint="drop it or add candidates",
                )  # fmt: skip
            total += sum(round(peak / UNIT) for peak in peaks.tolist())
            writer.append(shares=shares, peak=peaks)
        said = law if isinstance(law, float) else type(law).__name__
        writer.head |= _head(STORED, likelihood.candidates, likelihood.background, said) | {"peaks": str(total)}
    return open_shards(folder)


def open_shards(folder: str | Path, *, verify: bool = True) -> Shards:
    """The shards in a folder. ``verify`` reads every file once to compare its checksum; sizes are compared always.

    Raises ``StorageError`` naming the file for a missing, torn or changed one and for another version.
    """
    files = open_files(folder, verify=verify)
    head = files.head
    try:
        return Shards(files, candidates_from(head), float(head["background"]), head["confidence"])
    except (KeyError, TypeError, ValueError) as problem:
        raise StorageError("shards", where=str(files.folder), found=f"a missing or wrong field ({problem})",
                           wanted="all fields of shards") from None  # fmt: skip


def _head(kind: str, candidates: Candidates, background: float, confidence: float | str) -> dict[str, Any]:
    return {"kind": kind, "background": background, "confidence": confidence, **candidates_head(candidates)}


def candidates_head(candidates: Candidates) -> dict[str, Any]:
    """Places, prior, names and metric in the types of JSON, without loss."""
    metric = candidates.metric
    return {
        "points": candidates.points.tolist(), "log_prior": candidates.log_prior.tolist(), "radius": candidates.radius,
        "names": list(candidates.names), "weights": metric.weights.tolist(), "period": metric.period.tolist(),
    }  # fmt: skip


def candidates_from(head: Mapping[str, Any]) -> Candidates:
    """The candidates of a ``candidates_head``."""
    return Candidates(
        points=np.array(head["points"], float), log_prior=np.array(head["log_prior"], float), radius=head["radius"],
        names=tuple(head["names"]), metric=Metric(np.array(head["weights"]), np.array(head["period"])),
    )  # fmt: skip
