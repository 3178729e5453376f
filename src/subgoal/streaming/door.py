"""What a stream is made with and given, checked at its door."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.likelihood.action_comparison import MOST_SPAN
from subgoal.likelihood.table import MOST_CONFIDENCE
from subgoal.runtime.checks import Floats, positive, real_array, whole
from subgoal.runtime.errors import InputError
from subgoal.streaming.track import Track

MOST_AT_ONCE = 1000
"""A gap in which more samples than this would be made up is taken for the end of a trajectory, or a wrong unit."""


class Sample(NamedTuple):
    """A time, a place (d,), and whether it lies beyond a gap and begins another piece."""

    time: float
    place: Floats
    is_cut: bool


def checked_sample(
    time: Any, place: Any, track: Track, metric: Metric, names: Sequence[str], max_gap: float
) -> Sample:  # fmt: skip
    """A time after the last of the track, and a place whose velocity is a number unless it begins another piece."""
    when = float(real_array("time", time, ndim=0))
    where = np.atleast_1d(real_array("place", place, ndim=(0, 1)))
    d = metric.dimension
    if where.size != d:
        raise InputError("place", found=f"{where.size} numbers", wanted=f"{d}, for {', '.join(names)}")
    scale = np.maximum(metric.weights, 1.0)
    far = np.abs(where * scale) < MOST_SPAN
    if not far.all():
        raise InputError("place", found=where[int(np.argmin(far))], wanted=f"numbers below {MOST_SPAN:g}",
                         hint="other units")  # fmt: skip
    if not track.tells_apart(when):
        raise InputError("time", found=f"{when:.10g}", wanted="a number that one step of resampling changes",
                         hint="times from the beginning of the recording")  # fmt: skip
    is_cut = len(track) > 0 and when - track.last[0] > max_gap
    if len(track) and not is_cut:
        _check_step(when, where, track, metric)
    return Sample(when, where, is_cut)


def _check_step(when: float, where: Floats, track: Track, metric: Metric) -> None:
    before, at = track.last
    if not when > before:
        raise InputError("time", found=f"{when:.10g} after {before:.10g}", wanted="a later one",
                         hint="leave the sample out, or lift() to begin another trajectory")  # fmt: skip
    with np.errstate(over="ignore"):
        speed = np.abs((where - at) * np.maximum(metric.weights, 1.0) / (when - before))
    if not (speed < MOST_SPAN).all():
        raise InputError("time", found=f"a step of {when - before:.3g}", wanted=f"speeds below {MOST_SPAN:g}")
    if not track.steps_at(when) <= MOST_AT_ONCE:
        raise InputError("time", found=f"a gap of {when - before:.6g}",
                         wanted=f"at most {MOST_AT_ONCE} resampling times between two samples",
                         hint="max_gap=, lift() before it, or check the unit of the times")  # fmt: skip


def columns(dimension: Any, names: Sequence[str]) -> tuple[tuple[str, ...], int]:
    """Names and number of the columns."""
    if isinstance(names, str):
        raise InputError("names", found=repr(names), wanted="a name for each column", hint=f"names=({names!r},)")
    if not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise InputError("names", found=repr(names), wanted="a text for each column")
    if len(set(names)) < len(names):
        raise InputError("names", found=", ".join(names), wanted="names that differ")
    if dimension is None and not names:
        raise InputError("dimension", found="none", wanted="a number of columns, or their names")
    d = len(names) if dimension is None else whole("dimension", dimension)
    if names and len(names) != d:
        raise InputError("names", found=f"{len(names)}", wanted=f"{d}, one per column")
    return tuple(names) or tuple(f"x{k}" for k in range(d)), d


def fitting(metric: Metric | None, dimension: int) -> Metric:
    """The metric, Euclidean if none is given."""
    metric = Metric.euclidean(dimension) if metric is None else metric
    if metric.dimension != dimension:
        raise InputError("metric", found=f"{metric.dimension} dimensions", wanted=f"{dimension}, as the places")
    return metric


def checked_confidence(given: Any) -> float:
    """A finite number above 0."""
    number = positive("confidence", given)
    if number > MOST_CONFIDENCE:
        raise InputError("confidence", found=number, wanted=f"at most {MOST_CONFIDENCE:g}")
    return number
