"""What dynamics are learned from: states, mean actions and what became of the states one step later."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.held import time_step
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.gaussian.coordinates import coordinates
from subgoal.runtime.checks import Bools, Floats, Ints, positive
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

BLOCKS = 25
"""About as many stretches of time is a recording cut into, of which some are held out."""
WHOLE = 1e-6
"""A duration that is nearer to a multiple of a step than this share of one is that multiple."""


@dataclass(frozen=True, eq=False)
class Transitions:
    """M transitions of one ``step``, each within a trajectory.

    Attributes
    ----------
    states, actions, increments:
        (M, d), (M, k) mean over the step, (M, d) by how much the state changed, the short way round for angles.
    row, every:
        (M,) the first of the ``every`` pairs that a transition spans. Neighbouring transitions overlap.
    trajectory:
        (M,) to which each belongs.
    """

    states: Floats
    actions: Floats
    increments: Floats
    row: Ints
    every: int
    trajectory: Ints
    step: float


def transitions(demonstrations: Demonstrations, step: Any, metric: Metric) -> Transitions:
    """The transitions of ``step`` (None: the time between two pairs) of continuous demonstrations.

    Raises
    ------
    InputError
        States of a discrete world, times that are missing or uneven, a step that is no multiple of the time between
        pairs, a dimension that never changes, fewer than 2 (d + k + 1) transitions.
    """
    if demonstrations.is_discrete:
        raise InputError("demonstrations", found="states of a discrete world", wanted="positions (N, d)")
    if demonstrations.times is None:
        hint = "dataclasses.replace(demonstrations, times=step * numpy.arange(N))"
        raise InputError("demonstrations", found="no times", wanted="the time of each pair", hint=hint)
    own = time_step(demonstrations)
    every = 1 if step is None else _multiple(positive("step", step), own)
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions, float)
    actions = actions.reshape(len(states), -1)
    for what, values in (("states", states), ("actions", actions)):
        _check_changes(what, values)
    trajectory = demonstrations.trajectory
    row = np.flatnonzero(trajectory[every:] == trajectory[:-every])
    least = 2 * (states.shape[1] + actions.shape[1] + 1)
    if len(row) < least:
        hint = "more demonstrations, or a shorter step"
        found = f"{len(row)} transitions of {every * own:g}"
        raise InputError("demonstrations", found=found, wanted=f"at least {least}", hint=hint)
    total = np.concatenate([np.zeros((1, actions.shape[1])), np.cumsum(actions, axis=0)])
    mean = actions[row] if every == 1 else (total[row + every] - total[row]) / every
    _check_changes("actions", mean)
    change = np.array(metric.difference(states[row], states[row + every])) / metric.weights
    return Transitions(states[row], mean, change, row, every, trajectory[row], every * own)


def held_out(moves: Transitions, share: Any, seed: int) -> list[tuple[Bools, Bools]]:
    """(M,) transitions to learn from and (M,) those to test on: whole stretches of time, about ``share`` of all.

    One pair after another, so that every transition is tested on once: what changes seldom is not missed. Transitions
    that overlap with one to test on are in neither. Raises ``InputError`` for a share that is not above 0 and at most
    a half, and where one of the two would be too small.
    """
    share = positive("holdout", share)
    if not share <= 0.5:
        raise InputError("holdout", found=share, wanted="a number above 0, at most a half")
    length = max(2 * moves.every, len(moves.row) // BLOCKS)
    begins = np.flatnonzero(np.diff(moves.trajectory, prepend=-1))
    within = np.arange(len(moves.row)) - np.repeat(begins, np.diff(begins, append=len(moves.row)))
    block = np.cumsum(within % length == 0) - 1
    count = int(block[-1]) + 1
    folds = np.array_split(stream(seed).permutation(count), min(count, round(1 / share)))
    return [_fold(moves, np.isin(block, fold)) for fold in folds if fold.size]


def _fold(moves: Transitions, test: Bools) -> tuple[Bools, Bools]:
    """What to learn from beside what is tested on, and that."""
    tested = moves.row[test]
    place = np.searchsorted(tested, moves.row)
    before, after = tested[np.maximum(place - 1, 0)], tested[np.minimum(place, len(tested) - 1)]
    train = np.minimum(np.abs(moves.row - before), np.abs(moves.row - after)) >= moves.every
    least = moves.states.shape[1] + moves.actions.shape[1] + 2
    if not train.sum() >= least:
        found = f"{int(train.sum())} transitions beside what is held out"
        hint = "a smaller holdout, a shorter step, or more demonstrations"
        raise InputError("holdout", found=found, wanted=f"at least {least}", hint=hint)
    return train, test


def inputs(metric: Metric, states: Floats, actions: Floats) -> Floats:
    """(B, e + k) what an increment is a function of: states, angles by cosine and sine, and actions."""
    return np.concatenate([coordinates(metric, states), actions], axis=1)


def _multiple(step: float, own: float) -> int:
    every = round(step / own)
    if every < 1 or not abs(step / own - every) <= WHOLE * max(1, every):
        hint = f"{max(1, every) * own:g}, or resample with rate= when reading"
        raise InputError("step", found=step, wanted=f"a multiple of the time between two pairs, {own:g}", hint=hint)
    return every


def _check_changes(what: str, values: Floats) -> None:
    still = ~(np.ptp(values, axis=0) > 1e-12 * (1 + np.abs(values).max(axis=0)))
    if still.any():
        k = int(np.argmax(still))
        raise InputError(
            f"demonstrations.{what}", where=f"dimension {k}", found=f"{values[0, k]:g} throughout",
            wanted="a dimension that changes", hint="leave it out, or record demonstrations in which it varies",
        )  # fmt: skip
