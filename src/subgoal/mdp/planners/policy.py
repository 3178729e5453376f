"""Policies: one action per state, (S,) integers, or a probability for each, (S, A)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.mdp.tabular import ROW_TOLERANCE, TabularMDP
from subgoal.runtime.checks import Bools, Floats, copied, frozen, positive, real_array
from subgoal.runtime.errors import InputError


def check_policy(mdp: TabularMDP, policy: Any) -> NDArray[Any]:
    """``policy`` as (S,) integers, −1 in terminal states, or as (S, A) probabilities, zero in terminal states.

    What a policy says of terminal states is not looked at. Raises ``InputError`` naming the first state whose action
    is not available or whose probabilities are not those of available actions, summing to one within 1e-8.
    """
    array = copied("policy", policy)
    if array.dtype.kind in "iu" and array.shape == (mdp.n_states,):
        return _actions(mdp, array.astype(np.int64))
    if array.shape == (mdp.n_states, mdp.n_actions) and array.dtype.kind in "iuf":
        return _chances(mdp, real_array("policy", array, ndim=2))
    found = f"{array.dtype} of shape {array.shape}"
    shape = (mdp.n_states, mdp.n_actions)
    raise InputError("policy", found=found, wanted=f"integers of shape {shape[:1]} or probabilities of shape {shape}")


def greedy_actions(action_values: Any, tolerance: float = 0.0) -> Bools:
    """(S, A) which actions come within ``tolerance`` of the best of their state; none where no action is available.

    ``action_values`` (S, A) holds −inf for actions that are not available. To call ties what exact values would, let
    the tolerance be twice their error bound. Raises ``InputError`` for NaN and +inf.
    """
    table = real_array("action_values", action_values, ndim=2, finite=False)
    slack = positive("tolerance", tolerance, zero=True)
    wrong = ~(table < np.inf)
    if wrong.any():
        index = tuple(int(k) for k in np.argwhere(wrong)[0])
        raise InputError("action_values", where=f"index {index}", found=table[index], wanted="a finite number or -inf")
    return np.asarray((table >= table.max(axis=1, keepdims=True) - slack) & np.isfinite(table))


def uniform_policy(mask: Any) -> Floats:
    """(S, A) probabilities: each action of ``mask`` (S, A) with the same chance; zero in states that have none."""
    chosen = np.asarray(mask)
    if chosen.dtype != bool or chosen.ndim != 2:
        raise InputError("mask", found=f"{chosen.dtype} of shape {chosen.shape}", wanted="booleans of shape (S, A)")
    return np.asarray(frozen(chosen / np.maximum(chosen.sum(axis=1, keepdims=True), 1)))


def imperfect(mdp: TabularMDP, policy: Any, *, error: float = 0.05, may_be_optimal: bool = True) -> Floats:
    """(S, A) what a demonstrator does who follows ``policy`` but takes a random action with probability ``error``.

    Parameters
    ----------
    policy:
        (S,) one action per state, or (S, A) probabilities. Ties are broken as it breaks them: one action per state is a
        demonstrator who always does the same, ``uniform_policy(greedy_actions(...))`` one who chooses anew each time.
    error:
        0.05 in thesis 3.2.1.
    may_be_optimal:
        Whether the random action is any available one, so that it may be the policy's after all; or else one that the
        policy never takes in this state. Where there is none such, no error is made.

    Raises ``InputError`` for actions that are not available, as ``simulate`` does, and for an error above 1.
    """
    chance = positive("error", error, zero=True)
    if chance > 1:
        raise InputError("error", found=chance, wanted="a probability")
    table = check_policy(mdp, policy)
    intended = table if table.ndim == 2 else (table[:, None] == np.arange(mdp.n_actions)).astype(float)
    others = mdp.available if may_be_optimal else mdp.available & (intended == 0)
    errs = np.where(others.any(axis=1, keepdims=True), chance, 0.0)
    return np.asarray(frozen((1 - errs) * intended + errs * uniform_policy(others)))


def _actions(mdp: TabularMDP, actions: NDArray[Any]) -> NDArray[Any]:
    inside = (actions >= 0) & (actions < mdp.n_actions)
    legal = mdp.available[np.arange(mdp.n_states), np.where(inside, actions, 0)] & inside
    _check(mdp, ~legal, lambda state: f"action {actions[state]}")
    return frozen(np.where(mdp.terminal, -1, actions))


def _chances(mdp: TabularMDP, chances: NDArray[Any]) -> NDArray[Any]:
    _check(mdp, (chances < 0).any(axis=1), lambda state: f"a probability of {chances[state].min()}")
    stray = ((chances > 0) & ~mdp.available).any(axis=1)
    _check(mdp, stray, lambda state: f"a chance of action {np.argmax((chances[state] > 0) & ~mdp.available[state])}")
    sums = chances.sum(axis=1)
    _check(
        mdp,
        np.abs(sums - 1) > ROW_TOLERANCE,
        lambda state: f"probabilities that sum to {sums[state]:.12g}",
        wanted="1 within 1e-8",
    )
    return frozen(np.where(mdp.terminal[:, None], 0.0, chances))


def _check(mdp: TabularMDP, bad: Any, found: Any, wanted: str = "") -> None:
    bad = bad & ~mdp.terminal
    if bad.any():
        state = int(np.argmax(bad))
        legal = ", ".join(str(action) for action in np.flatnonzero(mdp.available[state]))
        wanted = wanted or f"chances of 0 to 1 of available actions only ({legal})"
        raise InputError("policy", where=f"state {state}", found=found(state), wanted=wanted)
