"""From a Recording (positions over time) to Demonstrations (states and the actions taken there)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from subgoal.demonstrations.angles import unwrapped, wrapped
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.poses import on_poses
from subgoal.demonstrations.recordings import resample, select_trajectories, split_at_gaps
from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.demonstrations.thinning import thin as thin_pairs
from subgoal.demonstrations.velocities import VELOCITIES, Velocity
from subgoal.runtime.checks import Floats, Ints, whole
from subgoal.runtime.errors import InputError


def demonstrate(
    recording: Recording,
    *,
    rate: float | None = None,
    every: int = 1,
    velocity: str = "central",
    window: int | None = None,
    max_gap: float | None = None,
    thin: float | None = None,
    period: Sequence[float] | None = None,
) -> Demonstrations:
    """States and velocities of a recording.

    In this order: cut at gaps, resample, compute velocities, keep every k-th sample, thin. A recording that
    carries actions keeps those, and no velocity is computed.

    Parameters
    ----------
    rate:
        Resample to this many samples per ``time_unit`` (Hz for seconds); None leaves the samples as they are.
    every:
        Keep each ``every``-th sample of a trajectory, from its first.
    velocity:
        "central": difference from sample i − w//2 to i + (w − w//2), clipped at the ends of the trajectory, over
        the real time between them. "forward": from i to i + w, clipped; the last sample gives no pair. "savgol":
        slope of a parabola through w even samples.
    window:
        w, in samples before ``every`` is applied. Default max(2, every), for "savgol" the next odd number from 5.
    max_gap:
        Cut where samples lie farther apart than this many ``time_unit``.
    thin:
        Radius in ``units``: drop a pair whose state is this close to a kept one of the same trajectory.
    period:
        (d,) length after which a dimension wraps (2π for radians), infinity where it does not. Resampling and
        velocities then go the shorter way round. Default: that of the recording, if it has one.

    Returns
    -------
    Demonstrations with actions in ``units`` per ``time_unit``, the time of each pair, and as ``final_states`` the
    last recorded position of each trajectory, also where ``every`` skips it. Where states have a quaternion q, actions
    have its rate ½ ω q, from the angular velocity ω that is the mean over the window (``poses``). Trajectories of one
    sample, and those too short for the window, are dropped and counted in ``source.notes``.

    Raises
    ------
    InputError
        An option out of range, velocities that are not finite, or no trajectory left.
    """
    every = whole("every", every)
    period = period if period is not None else recording.period or None
    recording = recording if max_gap is None else split_at_gaps(recording, max_gap)
    lengths = np.diff(recording.offset)
    short = int((lengths < 2).sum())
    recording = select_trajectories(
        recording, lengths >= 2, recording.source.noting(trajectories_of_one_sample_dropped=short)
    )
    recorded = recording.positions
    recording = recording if period is None else unwrapped(recording, period)
    recording = recording if rate is None else resample(recording, rate)
    if recording.actions is not None:
        rows, actions = np.arange(len(recording.times)), recording.actions
    else:
        rows, actions = _all_velocities(recording, *_choice(velocity, window, every))
    within = rows - np.repeat(recording.offset[:-1], np.diff(recording.offset))[rows]
    kept = within % every == 0
    demos = _pairs(recording, rows[kept], actions[kept])
    if period is not None:
        demos = wrapped(demos, period, recorded)
    metric = Metric.of(recorded.shape[1], period=period)
    return demos if thin is None else thin_pairs(demos, thin, metric)


def _choice(velocity: str, window: Any, every: int) -> tuple[Velocity, int]:
    """The function that computes velocities and its window, checked."""
    if velocity not in VELOCITIES:
        raise InputError("velocity", found=repr(velocity), wanted=" or ".join(map(repr, VELOCITIES)))
    if window is None:
        return VELOCITIES[velocity], max(5, every) | 1 if velocity == "savgol" else max(2, every)
    window = whole("window", window, least={"central": 2, "forward": 1, "savgol": 3}[velocity])
    if velocity == "savgol" and window % 2 == 0:
        raise InputError("window", found=window, wanted="an odd number for 'savgol'")
    return VELOCITIES[velocity], window


def _all_velocities(recording: Recording, function: Velocity, window: int) -> tuple[Ints, Floats]:
    """Rows that have a velocity, and their velocities, over all trajectories."""
    if recording.quaternion is not None:
        function = on_poses(function, recording.quaternion)
    parts = [
        (start, *function(recording.positions[start:end], recording.times[start:end], window))
        for start, end in zip(recording.offset[:-1], recording.offset[1:], strict=True)
    ]
    return np.concatenate([start + rows for start, rows, _ in parts]), np.concatenate([v for _, _, v in parts])


def _pairs(recording: Recording, rows: Ints, actions: Floats) -> Demonstrations:
    """Demonstrations from the chosen rows; trajectories without any are dropped and counted."""
    owner = np.searchsorted(recording.offset, rows, side="right") - 1
    counts = np.bincount(owner, minlength=recording.n_trajectories)
    full = counts > 0
    source = recording.source.noting(trajectories_too_short_for_the_window_dropped=int((~full).sum()))
    left = select_trajectories(recording, full, source)
    return Demonstrations(
        states=recording.positions[rows],
        actions=actions,
        offset=np.concatenate([[0], np.cumsum(counts[full])]),
        times=recording.times[rows],
        final_states=left.positions[left.offset[1:] - 1],
        truncated=left.truncated,
        names=left.names,
        units=left.units,
        trajectory_names=left.trajectory_names,
        time_unit=left.time_unit,
        source=source,
        groups=left.groups,
    )
