"""From a fast recording to slower decisions: states now and then, and the mean action until the next."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.runtime.checks import Ints, whole
from subgoal.runtime.errors import InputError

UNEVEN = 0.01
"""Steps of time that differ by more than this share of their median are uneven."""


def hold_actions(demonstrations: Demonstrations, every: int) -> Demonstrations:
    """One pair for each ``every`` of a trajectory: the first state of them, and the mean of their actions.

    What is left over at the end of a trajectory, fewer than ``every`` pairs, is where it ended. Trajectories that are
    shorter are dropped, and counted in ``source.notes``. Raises ``InputError`` for states of a discrete world and where
    no trajectory is long enough.
    """
    counts = _counts(demonstrations, every)
    full = counts > 0
    begin = demonstrations.offset[:-1]
    rows = np.concatenate([first + every * np.arange(n) for first, n in zip(begin, counts, strict=True)])
    states, after = np.asarray(demonstrations.states), begin + counts * every
    inside = after < demonstrations.offset[1:]
    final = np.where(inside[:, None], states[np.minimum(after, len(states) - 1)], demonstrations.final_states)
    notes = {"trajectories_too_short_dropped": int((~full).sum()), "samples_averaged_into_each_action": every}
    return replace(
        demonstrations,
        states=states[rows],
        actions=np.asarray(demonstrations.actions)[rows[:, None] + np.arange(every)].mean(axis=1),
        offset=np.concatenate([[0], np.cumsum(counts[full])]),
        times=None if demonstrations.times is None else demonstrations.times[rows],
        final_states=final[full],
        truncated=demonstrations.truncated[full],
        trajectory_names=tuple(np.array(demonstrations.trajectory_names, object)[full]),
        groups=tuple(np.array(demonstrations.groups, object)[full]) if demonstrations.groups else (),
        source=demonstrations.source.noting(**notes),
    )


def held_rows(demonstrations: Demonstrations, every: int) -> Ints:
    """(N,) for each pair of ``demonstrations``, the pair of ``hold_actions(demonstrations, every)`` that it is in.

    Those left over at the end of a trajectory go with the last one of it; −1 where the trajectory was dropped.
    """
    counts = _counts(demonstrations, every)
    within = np.concatenate([np.arange(n) for n in np.diff(demonstrations.offset)]) // every
    first = np.cumsum(counts) - counts
    owner = demonstrations.trajectory
    rows = first[owner] + np.minimum(within, counts[owner] - 1)
    return np.asarray(np.where(counts[owner] > 0, rows, -1))


def time_step(demonstrations: Demonstrations) -> float:
    """The time between two pairs of a trajectory. Raises ``InputError`` where it is not known or not the same."""
    if demonstrations.times is None:
        raise InputError(
            "demonstrations",
            found="no times",
            wanted="the time of each pair",
            hint="times of the demonstrations, or a ContinuousWorld with its step",
        )
    together = np.diff(demonstrations.trajectory) == 0
    steps = np.diff(demonstrations.times)[together]
    if not steps.size:
        raise InputError("demonstrations", found="one pair in each trajectory", wanted="some trajectory with two",
                         hint="a smaller every= or a higher rate= (a pair is as long as every= samples), or a longer "
                              "recording; in Python also a ContinuousWorld, which has a step")  # fmt: skip
    typical = float(np.median(steps))
    worst = float(np.abs(steps - typical).max())
    if not worst <= UNEVEN * typical:
        raise InputError(
            "demonstrations.times", found=f"steps from {steps.min():g} to {steps.max():g}", wanted="even steps",
            hint="resample with rate= when reading, and cut at gaps with max_gap=",
        )  # fmt: skip
    return typical


def _counts(demonstrations: Demonstrations, every: int) -> Ints:
    """(D,) how many whole stretches of ``every`` pairs each trajectory has."""
    every = whole("every", every)
    if demonstrations.is_discrete:
        raise InputError("demonstrations", found="states of a discrete world", wanted="positions (N, d)")
    lengths = np.diff(demonstrations.offset)
    if lengths.max() < every:
        raise InputError("every", found=every, wanted=f"at most {lengths.max()}, the longest trajectory")
    return np.asarray(lengths // every)
