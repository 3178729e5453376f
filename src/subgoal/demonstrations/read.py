"""One call from a file to Demonstrations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.prepare import demonstrate
from subgoal.demonstrations.readers import PAIRS, RECORDINGS, format_of, known_options, read_recording
from subgoal.demonstrations.readers import accepted as options_of
from subgoal.demonstrations.recordings import starting_within
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.demonstrations.thinning import thin as thin_pairs
from subgoal.runtime.errors import InputError


def read(
    path: Any,
    *,
    format: str | None = None,
    rate: float | None = None,
    every: int = 1,
    velocity: str = "central",
    window: int | None = None,
    max_gap: float | None = None,
    thin: float | None = None,
    start_within: Sequence[tuple[float, float]] | None = None,
    period: Sequence[float] | None = None,
    **options: Any,
) -> Demonstrations:
    """Read a file and make state-action pairs of it: ``read_recording`` followed by ``demonstrate``.

    Parameters
    ----------
    path:
        The file.
    format:
        "csv", "npz", ...; found out if not given.
    rate, every, velocity, window, max_gap, thin, period:
        As in ``demonstrate``. ``rate`` and ``max_gap`` also go to readers that take them: for a file without a
        clock, ``rate`` is how many samples or frames there are in a second.
    start_within:
        (low, high) for each dimension, ±infinity where there is no bound: only trajectories that start there.
    options:
        Those of the reader, such as ``position=["x", "y"], time="t", trajectory="id", group="animal"`` for tables.

    Returns
    -------
    Demonstrations. A file of ready pairs is given back as it is, thinned if ``thin`` is given; the other options of
    ``demonstrate`` are refused for it.

    Raises
    ------
    ReadError
        The file is missing, torn, or not of its format; names file, place and what to try.
    InputError
        An option out of range, or nothing is left to learn from.
    """
    chosen = format_of(path, format)
    if chosen in PAIRS:
        unused = {"rate": rate, "window": window, "max_gap": max_gap, "start_within": start_within}
        _refuse_unused(chosen, unused | {"every": every != 1 or None, "velocity": velocity != "central" or None})
        demos = PAIRS[chosen](path, **known_options(chosen, options))
        metric = None if period is None else Metric.of(np.shape(demos.states)[-1], period=period)
        return demos if thin is None else thin_pairs(demos, thin, metric)
    recording = _recording(path, chosen, {"rate": rate, "max_gap": max_gap}, options)
    if start_within is not None:
        recording = starting_within(recording, start_within)
    return demonstrate(
        recording,
        rate=rate, every=every, velocity=velocity, window=window, max_gap=max_gap, thin=thin,
        period=period,
    )  # fmt: skip


def _refuse_unused(format: str, given: dict[str, Any]) -> None:
    """Raise ``InputError`` if one of the options that make pairs from a recording is set for ready pairs."""
    told = [name for name, value in given.items() if value is not None]
    if told:
        raise InputError("options", found=", ".join(told), wanted=f"none of them: {format!r} holds ready pairs")


def look(path: Any, *, format: str | None = None, **options: Any) -> Recording | Demonstrations:
    """A file as it is, for ``summarise`` and pictures: a Recording, or Demonstrations of ready pairs."""
    chosen = format_of(path, format)
    if chosen in PAIRS:
        return PAIRS[chosen](path, **known_options(chosen, options))
    shared = {name: options.pop(name, None) for name in ("rate", "max_gap")}
    return _recording(path, chosen, shared, options)


def _recording(path: Any, format: str, shared: dict[str, Any], options: dict[str, Any]) -> Recording:
    """A recording; of the options ``shared`` with ``demonstrate`` the reader gets those that it takes."""
    taken = options_of(RECORDINGS[format])
    known = {name: value for name, value in shared.items() if value is not None and name in taken}
    return read_recording(path, format=format, **options, **known)
