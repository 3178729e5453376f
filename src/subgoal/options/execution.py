"""Options of a continuous world, carried out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.dynamics.protocol import Dynamics, checked_dynamics
from subgoal.dynamics.world import ContinuousWorld
from subgoal.options.continuous import ContinuousOption
from subgoal.runtime.checks import Bools, Floats, positive, real_array
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream


def execute(
    option: ContinuousOption,
    world: ContinuousWorld | Dynamics,
    *,
    start: Any,
    duration: float,
    hold: bool = False,
    every: float | None = None,
    disturbance: Any = 0.0,
    seed: int = 0,
) -> Demonstrations:
    """Run an option in the world from all of ``start`` at once until it ends, or for ``duration``.

    Parameters
    ----------
    world:
        Where it runs, which need not be the model that it plans with.
    start:
        (d,) or (B, d), a trajectory from each.
    duration, every:
        How long at most, and the time between two decisions, in the unit of the world: by default half the step of the
        option's world. The last decision may run past ``duration``.
    hold:
        Go on at the goal, past the option's end, as a turn or a drift that lasts must.
    disturbance:
        (d,) or one number: normal pushes of the state after each decision, standard deviation per square root of time.
    seed:
        Of the pushes; those of trajectory k hang on the seed and on k alone.

    Returns
    -------
    States and actions at each decision, with times from 0; ``truncated`` where the option did not end.

    Raises
    ------
    InputError
        A start outside the initiation set or, unless it is held, where the option is over already, naming the row;
        dynamics that give NaN.
    """
    dynamics = world.dynamics if isinstance(world, ContinuousWorld) else world
    step = positive("every", option.world.step / 2 if every is None else every)
    steps = math.ceil(positive("duration", duration) / step * (1 - 1e-9))
    at = np.array(checked_starts(option, start, hold))
    pushes = _pushes(disturbance, at.shape, steps, seed) * math.sqrt(step)
    going: Bools = np.ones(len(at), bool)
    done: list[tuple[Any, ...]] = []
    for k in range(steps):
        rows = np.flatnonzero(going)
        if not rows.size:
            break
        actions = option.policy(at[rows])
        done.append((rows, at[rows], actions, np.full(rows.size, k * step)))
        at[rows] = checked_dynamics(dynamics, at[rows], actions, step) + pushes[rows, k]
        going[rows] = hold | ~option.over(at[rows])
    row, states, actions, times = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.argsort(row, kind="stable")
    return Demonstrations(
        states=states[order], actions=actions[order], times=times[order], final_states=at, truncated=going,
        offset=np.cumsum([0, *np.bincount(row, minlength=len(at))]),
        names=option.names, source=Source(f"execution of {option.name}"),
    )  # fmt: skip


def checked_starts(option: ContinuousOption, start: Any, hold: bool) -> Floats:
    """(B, d) states from which ``option`` may run. Raises ``InputError`` naming the first row from which not."""
    first = np.atleast_2d(real_array("start", start, ndim=(1, 2)))
    for bad, wanted in (
        (~option.may_begin(first), "a state of the initiation set"),
        (~np.bool_(hold) & option.over(first), "a state in which the option is not over, or hold=True"),
    ):
        if bad.any():
            row = int(np.argmax(bad))
            found = f"({', '.join(f'{value:.4g}' for value in first[row])})"
            raise InputError("start", where=f"row {row}", found=found, wanted=wanted)
    return first


def _pushes(disturbance: Any, shape: tuple[int, ...], steps: int, seed: int) -> Floats:
    """(B, steps, d) normal numbers of standard deviation ``disturbance``."""
    size = real_array("disturbance", disturbance, ndim=(0, 1))
    if size.shape not in ((), (1,), shape[1:]) or not (size >= 0).all():
        raise InputError("disturbance", found=disturbance, wanted=f"one or {shape[1]} numbers of at least 0")
    if not size.any():
        return np.zeros((shape[0], steps, 1))
    return np.stack([stream(seed, k).standard_normal((steps, shape[1])) for k in range(shape[0])]) * size
