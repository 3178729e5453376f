"""What every transition function of this library looks like, and checks of what goes in and what comes out."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

import numpy as np

from subgoal.runtime.checks import Floats, positive, real_array
from subgoal.runtime.errors import InputError


@runtime_checkable
class Dynamics(Protocol):
    """``dynamics(states, actions, duration)``: (B, d) where (B, d) states are after actions (B, k), held so long.

    ``duration`` is in seconds, or in the time unit of the demonstrations the dynamics were learned from. Rows do not
    hang on each other, and nothing is random: where the true law is, this is its mean.
    """

    def __call__(self, states: Floats, actions: Floats, duration: float, /) -> Floats:
        """(B, d) the states after ``duration``."""
        ...


def paired(states: Any, actions: Any) -> tuple[Floats, Floats]:
    """``states`` (B, d) and ``actions`` (B, k), checked: finite, as many rows of the one as of the other."""
    pair = real_array("states", states, ndim=2), real_array("actions", actions, ndim=2)
    if len(pair[1]) != len(pair[0]):
        raise InputError("actions", found=f"{len(pair[1])} rows", wanted=f"{len(pair[0])}, one for each state")
    return pair


def checked_dynamics(dynamics: Dynamics, states: Any, actions: Any, duration: float) -> Floats:
    """(B, d) what ``dynamics`` says of ``states`` (B, d) and ``actions`` (B, k), held for ``duration``.

    Raises
    ------
    InputError
        Dynamics that are no function, an answer of another shape, NaN or infinity in it: naming the first state and
        action for which.
    """
    if not callable(dynamics):
        raise InputError("dynamics", found=type(dynamics).__name__, wanted="a function (states, actions, duration)")
    states, actions = paired(states, actions)
    duration = positive("duration", duration)
    answer = np.asarray(dynamics(states, actions, duration))
    if answer.shape != states.shape or answer.dtype.kind != "f":
        found = f"an answer of shape {answer.shape} and kind {answer.dtype}"
        hint = "return one row of floats for each state, its dimensions in the same order"
        raise InputError("dynamics", found=found, wanted=f"floats of shape {states.shape}, as the states", hint=hint)
    broken = ~np.isfinite(answer).all(axis=1)
    if broken.any():
        row = int(np.argmax(broken))
        raise InputError(
            "dynamics", where=f"state {_told(states[row])}, action {_told(actions[row])}, held for {duration:g}",
            found=f"{_told(answer[row])} in {int(broken.sum())} of {len(states)} rows", wanted="finite numbers",
            hint="shorter steps inside the dynamics, narrower bounds of the actions, or candidates where they hold",
        )  # fmt: skip
    return np.asarray(answer, float)


def check_bounds(low: Any, high: Any, actions: Any) -> Floats:
    """``actions`` (B, k), each within [low, high] of shape (k,).

    Raises ``InputError`` for bounds that are not in order and for the first action outside, naming its index.
    """
    low, high = real_array("low", low, ndim=1), real_array("high", high, ndim=1)
    given = real_array("actions", actions, ndim=2)
    if low.shape != high.shape or low.shape != given.shape[1:]:
        found = f"{low.size} and {high.size} bounds for {given.shape[1]} dimensions"
        raise InputError("low and high", found=found, wanted="one of each for each dimension of the actions")
    if not (low < high).all():
        k = int(np.argmin(low < high))
        raise InputError("low", where=f"dimension {k}", found=low[k], wanted=f"below high, which is {high[k]:g}")
    outside = ~((given >= low) & (given <= high))
    if outside.any():
        row, k = (int(index) for index in np.argwhere(outside)[0])
        raise InputError(
            "actions", where=f"index {(row, k)}", found=given[row, k], wanted=f"{low[k]:g} to {high[k]:g}",
            hint="wider bounds (--action-bounds), or in Python numpy.clip(actions, low, high)",
        )  # fmt: skip
    return given


def _told(values: Floats) -> str:
    return "(" + ", ".join(f"{value:.4g}" for value in values) + ")"
