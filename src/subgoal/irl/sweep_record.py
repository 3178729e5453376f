"""What a sweep over the confidence gives: counts of subgoals at each level, kept in a file while it runs."""

from __future__ import annotations

import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.posterior.checkpoint import EVERY
from subgoal.runtime.checks import Floats, Ints, frozen, positive
from subgoal.runtime.errors import InputError, StorageError
from subgoal.storage.archive import previous, read_archive, write_archive

KIND = "confidence sweep"


@dataclass(frozen=True)
class Plateau:
    """Neighbouring levels at which the mean number of subgoals is nearly k: from ``low`` to ``high``; NaN if none."""

    low: float
    high: float

    @property
    def ratio(self) -> float:
        """How wide it is, high/low; 1 for a single level, 0 where there is none."""
        return self.high / self.low if self.low > 0 else 0.0


@dataclass(frozen=True, eq=False, repr=False)
class Sweep:
    """Numbers of subgoals at L confidences. Printed, it is a table.

    Attributes
    ----------
    confidences:
        (L,) the levels that are done.
    counts:
        (L, trials) distinct subgoals with at least ``settings["least_share"]`` of the observations in the last draw.
    left_out:
        Levels that Ctrl-C came before.
    settings:
        Sampler, sweeps, concentration, least share and seed.
    seconds:
        How long it took.
    """

    confidences: Floats
    counts: Ints
    left_out: Floats
    settings: Mapping[str, Any]
    seconds: float

    def __repr__(self) -> str:
        levels, trials = self.counts.shape
        return (
            f"Sweep({levels} confidences from {self.confidences[0]:.3g} to {self.confidences[-1]:.3g}, {trials} trials)"
        )

    def __str__(self) -> str:
        lines = ["confidence  subgoals    sd  least  most"]
        for level, row, mean, sd in zip(self.confidences, self.counts, self.mean, self.sd, strict=True):
            lines.append(f"{level:10.3g}  {mean:8.2f}  {sd:4.2f}  {row.min():5d}  {row.max():4d}")
        return "\n".join([*lines, *(f"{level:10.3g}  not run" for level in self.left_out)])

    @property
    def mean(self) -> Floats:
        """(L,) over trials."""
        return np.asarray(self.counts.mean(axis=1))

    @property
    def sd(self) -> Floats:
        """(L,) standard deviation over trials."""
        return np.asarray(self.counts.std(axis=1))

    def plateau(self, k: float, within: float = 0.5) -> Plateau:
        """The longest run of levels, in the ratio of its ends, at which the mean is within so much of k."""
        positive("k", k)
        positive("within", within, zero=True)
        near = np.abs(self.mean - k) <= within
        edges = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]])))
        runs = [(float(self.confidences[a]), float(self.confidences[b - 1])) for a, b in edges.reshape(-1, 2).tolist()]
        return Plateau(*max(runs, key=lambda run: run[1] / run[0], default=(float("nan"), float("nan"))))

    @property
    def last_with_one(self) -> float:
        """The highest level up to which, from the lowest on, every trial has at most one subgoal; NaN if none."""
        more = np.flatnonzero((self.counts > 1).any(axis=1))
        upto = int(more[0]) if more.size else self.confidences.size
        return float(self.confidences[upto - 1]) if upto else float("nan")


class LevelCounts:
    """Counts of the levels that are done so far, and the file that keeps them, if there is to be one."""

    def __init__(self, levels: Floats, trials: int, settings: dict[str, Any], path: str | Path | None) -> None:
        self.path = None if path is None else Path(path)
        if self.path is not None and not self.path.parent.is_dir():
            raise InputError("checkpoint", found=f"{path} in no folder", wanted="a path in a folder that exists")
        self.levels, self.settings = levels, settings
        self.counts = np.zeros((levels.size, trials), np.int64)
        self.done = 0
        self._data, self._written = "", time.monotonic()

    def settle(self, data: str, resume: bool) -> None:
        """Whose counts these are, by the checksum of the data; with ``resume`` those of the file are taken.

        Raises ``StorageError`` for a file of other settings or data.
        """
        self._data = data
        if not resume:
            return
        if self.path is None:
            raise InputError("resume", found="no checkpoint", wanted="the path of one")
        header, arrays = read_archive(self.path, KIND)
        for name, wanted in self._header().items():
            if header.get(name) != wanted:
                raise StorageError(f"checkpoint setting {name!r}", where=str(self.path), found=repr(header.get(name)),
                                   wanted=repr(wanted), hint="the settings and data of the first run")  # fmt: skip
        if arrays["levels"].tolist() != self.levels.tolist():
            raise StorageError("checkpoint setting 'confidences'", where=str(self.path), found=str(arrays["levels"]),
                               wanted=str(self.levels))  # fmt: skip
        self.done = len(arrays["counts"])
        self.counts[: self.done] = arrays["counts"]

    def add(self, found: list[int]) -> None:
        """One more level is done."""
        self.counts[self.done] = found
        self.done += 1
        if self.path is not None and time.monotonic() - self._written >= EVERY:
            self._write()

    def swept(self, seconds: float) -> Sweep:
        """The record; the file stays where levels are left, and goes where none is."""
        if self.path is not None:
            if self.done < self.levels.size:
                self._write()
            else:
                self.path.unlink(missing_ok=True)
                previous(self.path).unlink(missing_ok=True)
        levels = np.array(self.levels)
        return Sweep(frozen(levels[: self.done]), frozen(self.counts[: self.done]), frozen(levels[self.done :]),
                     dict(self.settings), seconds)  # fmt: skip

    def _header(self) -> dict[str, Any]:
        return {**self.settings, "trials": self.counts.shape[1], "data": self._data}

    def _write(self) -> None:
        if self.path is None:
            return
        arrays = {"levels": self.levels, "counts": self.counts[: self.done]}
        try:
            write_archive(self.path, KIND, self._header(), arrays, keep_previous=True)
        except StorageError as problem:
            warnings.warn(f"no checkpoint was written: {problem}", stacklevel=2)
        self._written = time.monotonic()
