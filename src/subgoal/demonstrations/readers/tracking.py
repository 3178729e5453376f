"""What pose trackers have in common: a place and a likelihood per frame, with frames missing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.demonstrations.recordings import join, split_at_gaps
from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError, ReadError

GAP_SECONDS, GAP_FRAMES = 1.0, 30.0
"""Longest gap that stays inside a trajectory, where the frame rate is known and where it is not."""


@dataclass(frozen=True)
class Tracking:
    """Options of the readers of tracked animals; checked when made.

    Attributes
    ----------
    bodypart:
        Name of the body part that stands for the animal; None if the file has only one.
    min_likelihood:
        Frames in which the tracker is less sure than this are dropped and counted.
    max_gap:
        Where more than this much time is missing a trajectory is cut; default 1 s, or 30 frames without ``rate``.
        Shorter gaps stay and are bridged when resampling.
    rate:
        Frames per second; without it times are frames.
    scale, units:
        Multiplier of the positions and their unit then.
    """

    bodypart: str | None = None
    min_likelihood: float = 0.6
    max_gap: float | None = None
    rate: float | None = None
    scale: float = 1.0
    units: str = "px"

    def __post_init__(self) -> None:
        positive("min_likelihood", self.min_likelihood, zero=True)
        positive("scale", self.scale)
        if self.rate is not None:
            positive("rate", self.rate)
        if self.max_gap is not None:
            positive("max_gap", self.max_gap)

    def choose_bodypart(self, path: Path, found: Sequence[str]) -> str:
        """The body part to use. Raises ``InputError`` listing those there are."""
        parts = list(dict.fromkeys(found))
        if self.bodypart in parts or (self.bodypart is None and len(parts) == 1):
            return self.bodypart or parts[0]
        listed = ", ".join(map(repr, parts[:50]))
        raise InputError(
            "bodypart", where=path.name, found=repr(self.bodypart), wanted=f"one of {listed}",
            hint=f"bodypart={parts[0]!r}" if parts else None,
        )  # fmt: skip


def animals(path: Path, tracks: Sequence[tuple[str, Floats, Any, Floats]], how: Tracking, source: Source) -> Recording:
    """A Recording from (name, places (F, 2), likelihood (F,) or None, frames (F,)) of each animal.

    Raises ``ReadError`` if nothing is left or frame numbers do not increase.
    """
    pieces = []
    missing = unlikely = unseen = 0
    for name, places, likelihood, frames in tracks:
        there = np.isfinite(places).all(axis=1)
        sure = there if likelihood is None else there & (likelihood >= how.min_likelihood)
        missing += int((~there).sum())
        unlikely += int((there & ~sure).sum())
        unseen += not sure.any()
        if sure.any():
            pieces.append((name, places[sure] * how.scale, frames[sure] / (how.rate or 1.0)))
    source = source.noting(
        frames_without_a_place_dropped=missing,
        frames_of_low_likelihood_dropped=unlikely,
        animals_never_seen_dropped=unseen,
    )
    if not pieces:
        raise ReadError(str(path), found=source.told("no usable frame", "no frame"), wanted="at least one")
    unit, gap = ("frame", GAP_FRAMES) if how.rate is None else ("s", GAP_SECONDS)
    recording = join(pieces, names=("x", "y"), units=how.units, time_unit=unit, source=source)
    return split_at_gaps(recording, gap if how.max_gap is None else how.max_gap)
