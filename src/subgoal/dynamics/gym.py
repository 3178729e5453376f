"""A continuous world as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from subgoal.dynamics.protocol import checked_dynamics
from subgoal.dynamics.world import ContinuousWorld
from subgoal.runtime.checks import Floats, positive, real_array
from subgoal.runtime.errors import InputError, MissingExtraError


def continuous_env(
    world: ContinuousWorld,
    start: Any,
    *,
    every: float | None = None,
    low: Any = None,
    high: Any = None,
    disturbance: Any = 0.0,
    reward: Callable[[Floats, Floats], float] | None = None,
) -> Any:
    """``world`` as a Gymnasium environment that never ends by itself; set a time limit with ``TimeLimit``.

    Observations are the states, ``Box`` (d,) of float64; actions ``Box`` (k,) between the bounds of the world.

    Parameters
    ----------
    start:
        (d,) the first state, or (n, d), one of which is drawn at each reset; ``reset(options={"start": state})`` begins
        elsewhere.
    every:
        How long a step is, in the unit of the world; by default half a step of the world, as options decide.
    low, high:
        (d,) between which states are; by default they may be anything. A step that leads outside ends the episode,
        at the nearest state inside.
    disturbance:
        (d,) or one number: normal pushes of the state after each step, standard deviation per square root of time.
    reward:
        Function of the state (d,) in which an action (k,) is taken, and that action; zero without it.

    Raises ``InputError`` for shapes that do not fit and starts outside, ``MissingExtraError`` without Gymnasium.
    """
    if not isinstance(world, ContinuousWorld):
        raise InputError("world", found=type(world).__name__, wanted="a ContinuousWorld")
    first = np.atleast_2d(real_array("start", start, ndim=(1, 2)))
    d = first.shape[1]
    sides = [np.full(d, side) if given is None else real_array(name, given, ndim=1, finite=False)
             for name, given, side in (("low", low, -np.inf), ("high", high, np.inf))]  # fmt: skip
    if any(side.shape != (d,) for side in sides) or not (sides[0] < sides[1]).all():
        raise InputError("low and high", found=f"{sides[0]} to {sides[1]}", wanted=f"{d} numbers each, in order")
    if not ((sides[0] <= first) & (first <= sides[1])).all():
        raise InputError("start", found=first, wanted="states between low and high")
    push = real_array("disturbance", disturbance, ndim=(0, 1))
    if push.shape not in ((), (d,)) or not (push >= 0).all():
        raise InputError("disturbance", found=disturbance, wanted=f"one or {d} numbers of at least 0")
    step = positive("every", world.step / 2 if every is None else every)
    return _env_class()(world, first, step, sides[0], sides[1], push * np.sqrt(step), reward)


@cache
def _env_class() -> Any:
    """The environment, made when it is first wanted, so that Gymnasium is not loaded before."""
    try:
        import gymnasium
    except ImportError:
        raise MissingExtraError("gymnasium", "gym") from None

    class ContinuousEnv(gymnasium.Env[Any, Any]):
        """See ``continuous_env``."""

        metadata = {"render_modes": []}  # noqa: RUF012

        def __init__(
            self, world: ContinuousWorld, start: Floats, step: float, low: Floats, high: Floats, push: Floats,
            reward: Any,
        ) -> None:  # fmt: skip
            self._world, self._start, self._step, self._push, self._reward = world, start, step, push, reward
            self._low, self._high = low, high
            self._at = start[0]
            self.observation_space = gymnasium.spaces.Box(low, high, dtype=np.float64)
            self.action_space = gymnasium.spaces.Box(world.low, world.high, dtype=np.float64)

        def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> Any:
            """Begin in one of the first states, or in ``options["start"]`` (d,)."""
            super().reset(seed=seed)
            given = (options or {}).get("start")
            drawn = self._start[self.np_random.integers(len(self._start))]
            self._at = np.array(drawn if given is None else given, float)
            if not self.observation_space.contains(self._at):
                raise InputError("start", found=given, wanted=f"a state of {self.observation_space}")
            return self._at.copy(), {}

        def step(self, action: Any) -> Any:
            """Hold the action (k,) for one step. Raises ``InputError`` for one that is not in the action space."""
            act = np.asarray(action, float)
            if not self.action_space.contains(act):
                raise InputError("action", found=action, wanted=f"one of {self.action_space}")
            paid = 0.0 if self._reward is None else float(self._reward(self._at, act))
            after = checked_dynamics(self._world.dynamics, self._at[None], act[None], self._step)[0]
            if self._push.any():
                after = after + self._push * self.np_random.standard_normal(after.shape)
            self._at = np.clip(after, self._low, self._high)
            return self._at.copy(), paid, bool((self._at != after).any()), False, {}

    return ContinuousEnv
