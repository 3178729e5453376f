"""Verbs on a Recording: choose, split and resample trajectories. Each returns a new one and counts what it did."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.demonstrations.poses import slerped
from subgoal.demonstrations.records import Recording, Source
from subgoal.runtime.checks import Floats, Ints, positive, real_array
from subgoal.runtime.errors import InputError

ON_GRID = 1e-6
"""A sample this close to a resampling time, in steps, counts as lying on it."""
MOST_MADE = 1e6
"""Resampling that makes more samples than this, and 100 for each one there is, is taken for a wrong unit."""


def select_trajectories(recording: Recording, wanted: NDArray[np.bool_], source: Source) -> Recording:
    """The trajectories marked in ``wanted`` (D,), with ``source`` in place of the old one.

    Raises ``InputError`` if none is left.
    """
    if not wanted.any():
        raise InputError("recording", found="no trajectory left", wanted="at least one", hint=_what_happened(source))
    lengths = np.diff(recording.offset)
    rows = np.repeat(wanted, lengths)
    return replace(
        recording,
        positions=recording.positions[rows],
        times=recording.times[rows],
        offset=np.concatenate([[0], np.cumsum(lengths[wanted])]),
        trajectory_names=tuple(n for n, w in zip(recording.trajectory_names, wanted, strict=True) if w),
        actions=None if recording.actions is None else recording.actions[rows],
        truncated=recording.truncated[wanted],
        groups=tuple(g for g, w in zip(recording.groups, wanted, strict=True) if w) if recording.groups else (),
        source=source,
    )


def starting_in(recording: Recording, lower: Sequence[float], upper: Sequence[float]) -> Recording:
    """The trajectories whose first sample lies strictly inside the box; bounds (d,) may be ±infinity.

    Raises ``InputError`` if the bounds do not fit the positions or no trajectory starts there.
    """
    bounds = [real_array(what, b, ndim=1, finite=False) for what, b in (("lower", lower), ("upper", upper))]
    for what, bound in zip(("lower", "upper"), bounds, strict=True):
        if bound.size != recording.positions.shape[1] or np.isnan(bound).any():
            wanted = f"{recording.positions.shape[1]} bounds, infinite where there is none"
            raise InputError(what, found=list(bound), wanted=wanted)
    start = recording.positions[recording.offset[:-1]]
    inside = np.asarray(((start > bounds[0]) & (start < bounds[1])).all(axis=1))
    return select_trajectories(
        recording, inside, recording.source.noting(trajectories_starting_elsewhere_dropped=int((~inside).sum()))
    )


def starting_within(recording: Recording, ranges: Any) -> Recording:
    """``starting_in`` with (low, high) for each of the d position columns. Raises ``InputError`` for anything else."""
    names, wanted = recording.names, "low and high"
    wanted = f"{len(names)} of low and high, for {', '.join(names)}, infinite where there is no bound"
    try:
        pairs = [(float(low), float(high)) for low, high in ranges]
    except (TypeError, ValueError):
        raise InputError("start_within", found=repr(ranges), wanted=wanted) from None
    if len(pairs) != len(names):
        raise InputError("start_within", found=f"{len(pairs)}", wanted=wanted)
    lower, upper = zip(*pairs, strict=True)
    return starting_in(recording, lower, upper)


def split_at_gaps(recording: Recording, max_gap: float) -> Recording:
    """Cut trajectories where two samples lie more than ``max_gap`` (in ``time_unit``) apart.

    Pieces are named "name/0", "name/1"; all but the last piece of a trajectory are marked ``truncated``.
    Raises ``InputError`` unless ``max_gap`` is above 0.
    """
    max_gap = positive("max_gap", max_gap)
    steps = np.diff(recording.times)
    steps[recording.offset[1:-1] - 1] = 0.0
    cuts = np.flatnonzero(steps > max_gap) + 1
    if not len(cuts):
        return recording
    offset = np.union1d(recording.offset, cuts)
    parent = np.searchsorted(recording.offset, offset[:-1], side="right") - 1
    names, last = piece_names(recording.trajectory_names, parent)
    return replace(
        recording,
        offset=offset,
        trajectory_names=names,
        truncated=recording.truncated[parent] | ~last,
        groups=tuple(recording.groups[p] for p in parent) if recording.groups else (),
        source=recording.source.noting(gaps_split=len(cuts)),
    )


def piece_names(names: Sequence[str], parent: Ints) -> tuple[tuple[str, ...], NDArray[np.bool_]]:
    """Names of pieces, "name/0", "name/1" where a trajectory was cut, and (P,) which piece is the last of its own.

    ``parent`` (P,) is the trajectory of each piece, in ascending order, every one present.
    """
    pieces = np.bincount(parent)
    piece = np.arange(len(parent)) - (np.cumsum(pieces) - pieces)[parent]
    labels = (names[p] if pieces[p] == 1 else f"{names[p]}/{k}" for p, k in zip(parent, piece, strict=True))
    return tuple(labels), piece == pieces[parent] - 1


def resample(recording: Recording, rate: float) -> Recording:
    """Every trajectory at a fixed rate, by linear interpolation between its samples; of quaternions, by slerp.

    A recorded action lasts until the next: what is given is its mean over the time until the next sample.

    Parameters
    ----------
    rate:
        Samples per ``time_unit`` (Hz for seconds). The times are first + k/rate; the last sample of the trajectory
        stays as its end point, so the last step may be shorter than the others. Angles: ``unwrapped`` first.

    Raises
    ------
    InputError
        The rate is not above 0, or the request makes more than 100 samples for each one there is and more than a
        million in all.
    """
    rate = positive("rate", rate)
    _check_size(recording, rate)
    parts = [
        _resample_one(recording.positions[a:b], recording.times[a:b], rate, recording.quaternion)
        for a, b in zip(recording.offset[:-1], recording.offset[1:], strict=True)
    ]
    made = sum(p[2] for p in parts)
    held = None
    if recording.actions is not None:
        spans = zip(recording.offset[:-1], recording.offset[1:], parts, strict=True)
        held = np.concatenate([_held(recording.actions[a:b], recording.times[a:b], part[1]) for a, b, part in spans])
    return replace(
        recording,
        positions=np.concatenate([p[0] for p in parts]),
        times=np.concatenate([p[1] for p in parts]),
        actions=held,
        offset=np.concatenate([[0], np.cumsum([len(p[1]) for p in parts])]),
        source=recording.source.noting(samples_interpolated=made),
    )


def _resample_one(places: Floats, times: Floats, rate: float, four: int | None) -> tuple[Floats, Floats, int]:
    """Positions, times and the number of interpolated samples of one trajectory."""
    steps = (times[-1] - times[0]) * rate
    last = int(np.floor(steps + ON_GRID))
    grid = times[0] + np.arange(last + 1) / rate
    if len(grid) == len(times) and np.abs(grid - times).max() * rate <= ON_GRID:
        return places, times, 0
    if steps - last <= ON_GRID or not grid[-1] < times[-1]:
        grid[-1] = times[-1]
    else:
        grid = np.append(grid, times[-1])
    made = np.stack([np.interp(grid, times, column) for column in places.T], axis=1)
    if four is not None:
        made[:, four : four + 4] = slerped(places[:, four : four + 4], times, grid)
    near = np.clip(np.searchsorted(times, grid), 1, len(times) - 1)
    off = np.minimum(np.abs(grid - times[near - 1]), np.abs(grid - times[near]))
    return made, grid, int((off * rate > ON_GRID).sum())


def _held(actions: Floats, times: Floats, grid: Floats) -> Floats:
    """(grid, k) mean of actions (M, k), each held from its time until the next one's, from each grid time to the next.

    The last one is what is held there.
    """
    if len(grid) == len(times) and (grid == times).all():
        return actions
    passed = np.vstack([np.zeros(actions.shape[1]), np.cumsum(actions[:-1] * np.diff(times)[:, None], axis=0)])
    at = np.stack([np.interp(grid, times, column) for column in passed.T], axis=1)
    last = np.searchsorted(times, grid[-1], side="right") - 1
    return np.vstack([np.diff(at, axis=0) / np.diff(grid)[:, None], actions[last]])


def _check_size(recording: Recording, rate: float) -> None:
    spans = recording.times[recording.offset[1:] - 1] - recording.times[recording.offset[:-1]]
    with np.errstate(over="ignore"):
        count = float((spans * rate).sum())
    if not count <= max(MOST_MADE, 100.0 * len(recording.times)):
        raise InputError("rate", found=f"{rate:g}, giving {count:.3g} samples", wanted="fewer samples",
                         hint="check the unit of the times, or split_at_gaps first")  # fmt: skip


def _what_happened(source: Source) -> str | None:
    told = ", ".join(f"{count} {what}" for what, count in source.notes.items())
    return f"another selection; so far: {told}" if told else None


def join(pieces: Sequence[tuple[str, Any, Any]], **fields: Any) -> Recording:
    """One Recording from (name, positions (m, d), times (m,)) of each trajectory; ``fields`` as in the class."""
    return Recording(
        positions=np.concatenate([p[1] for p in pieces]),
        times=np.concatenate([p[2] for p in pieces]),
        offset=np.concatenate([[0], np.cumsum([len(p[2]) for p in pieces])]),
        trajectory_names=tuple(p[0] for p in pieces),
        **fields,
    )
