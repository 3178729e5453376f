"""Options of a continuous world inside Gymnasium environments."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.options.continuous import ContinuousOption
from subgoal.options.execution import checked_starts
from subgoal.runtime.checks import Floats, positive, whole
from subgoal.runtime.errors import InputError, MissingExtraError
from subgoal.runtime.seeds import stream


def run_in_env(
    option: ContinuousOption,
    env: Any,
    *,
    steps: int,
    hold: bool = False,
    episodes: int = 1,
    every: float | None = None,
    state: Callable[[Any], Any] | None = None,
    seed: int = 0,
) -> Demonstrations:
    """Run an option in ``env`` until it ends, the episode is over, or for ``steps`` steps; what was seen and done.

    Parameters
    ----------
    env:
        Observations and actions are ``Box``. One step of it is one decision; as a rule it lasts half a step of the
        option's world, and no longer than one.
    hold:
        Go on at the goal, past the option's end.
    episodes:
        How many, one after the other.
    every:
        How long a step of the environment is, in the unit of the option's world: the result then has times.
    state:
        Function that makes the state (d,) of an observation; without it they are the same.
    seed:
        Episode k is reset with a seed that hangs on this and on k alone.

    Returns
    -------
    Demonstrations: ``truncated`` where neither the option nor the episode came to its own end.

    Raises
    ------
    InputError
        Spaces that do not fit: of another kind, another number of dimensions, actions of the option that are out of
        bounds; a first state outside the initiation set or, unless it is held, where the option is over already.
    MissingExtraError
        Gymnasium is not installed.
    """
    check_spaces(option, env, looks=state is None)
    steps, read = whole("steps", steps), state or (lambda observation: observation)
    runs = [
        _episode(option, env, steps, hold, read, int(stream(seed, k).integers(2**31)))
        for k in range(whole("episodes", episodes))
    ]
    lengths = [len(states) - 1 for states, _, _ in runs]
    step = None if every is None else positive("every", every)
    return Demonstrations(
        states=np.concatenate([states[:-1] for states, _, _ in runs]),
        actions=np.concatenate([actions for _, actions, _ in runs]),
        offset=np.cumsum([0, *lengths]), final_states=np.array([states[-1] for states, _, _ in runs]),
        times=None if step is None else np.concatenate([step * np.arange(length) for length in lengths]),
        truncated=np.array([cut for _, _, cut in runs]), names=option.names,
        time_unit="step" if step is None else "s", source=Source(f"{option.name} in {_name(env)}"),
    )  # fmt: skip


def check_spaces(option: ContinuousOption, env: Any, *, looks: bool = True) -> None:
    """Raises ``InputError`` where the spaces of ``env`` are not those of the option; ``looks``: observations too."""
    try:
        from gymnasium import spaces
    except ImportError:
        raise MissingExtraError("gymnasium", "gym") from None
    for what, size in (("action", option.world.low.size), ("observation", option.metric.dimension)):
        space = getattr(env, f"{what}_space", None)
        if what == "observation" and not looks:
            continue
        if not isinstance(space, spaces.Box) or space.shape != (size,):
            hint = "state=, a function that makes the state of an observation" if what == "observation" else None
            raise InputError(f"{what} space", found=str(space), wanted=f"a Box of shape ({size},)", hint=hint)
    box = env.action_space
    low, high = (np.asarray(each, box.dtype) for each in (option.world.low, option.world.high))
    if not ((box.low <= low) & (high <= box.high)).all():
        raise InputError(
            "action space", found=f"{box.low} to {box.high}", wanted=f"all from {low} to {high}, as the option acts",
            hint="learn with bounds= those of the environment, or gymnasium.wrappers.RescaleAction",
        )  # fmt: skip


def _episode(
    option: ContinuousOption, env: Any, steps: int, hold: bool, read: Callable[[Any], Any], seed: int
) -> tuple[Floats, Floats, bool]:
    """States (T + 1, d), actions (T, k), and whether it was cut off."""
    at = np.asarray(read(env.reset(seed=seed)[0]), float)
    states, actions, box = [checked_starts(option, at, hold)[0]], [], env.action_space
    for _ in range(steps):
        act = np.clip(np.asarray(option.policy(states[-1][None])[0], box.dtype), box.low, box.high)
        observation, _, terminated, truncated, _ = env.step(act)
        states.append(np.asarray(read(observation), float))
        actions.append(np.asarray(act, float))
        if terminated or (not hold and option.over(states[-1][None])[0]):
            return np.array(states), np.array(actions), False
        if truncated:
            break
    return np.array(states), np.array(actions), True


def _name(env: Any) -> str:
    spec = getattr(env, "spec", None)
    return type(getattr(env, "unwrapped", env)).__name__ if spec is None else str(spec.id)
