"""Rewards of a tabular world: now, R(s) or r(s, a), and how those paid on arrival become such.

This library follows the thesis (2.2): R(s) is paid for being in s *now*, V(s) = R(s) + γ max_a E V(s'). Books that pay
R(s') on arrival mean W(s) = max_a E[R(s') + γ W(s')]; the two are one problem, V = R + γ W.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.mdp.tabular import TabularMDP, check_world
from subgoal.runtime.checks import Floats, frozen, real_array
from subgoal.runtime.errors import InputError


def check_reward(mdp: TabularMDP, reward: Any) -> tuple[Floats, Floats]:
    """(S,) or (S·A,) rewards now, and (S,) the values of terminal states (zero elsewhere).

    ``reward`` is R(s) of shape (S,), a terminal state being worth its own; or r(s, a) of shape (S, A), terminal states
    being worth nothing; or None for ``mdp.reward``. Raises ``InputError`` for other shapes, NaN and infinity.
    """
    check_world(mdp)
    given = mdp.reward if reward is None else reward
    if given is None:
        raise InputError("reward", found="None, and the world has none either", wanted="R(s) or r(s, a)")
    array = real_array("reward", given, ndim=(1, 2))
    shape = (mdp.n_states, mdp.n_actions)
    if array.shape not in (shape[:1], shape):
        raise InputError("reward", found=f"shape {array.shape}", wanted=f"{shape[:1]} or {shape}")
    if array.ndim == 1:
        return array, np.where(mdp.terminal, array, 0.0)
    return array.ravel(), np.zeros(mdp.n_states)


def arrival_reward(mdp: TabularMDP, reward: Any) -> Floats:
    """(S, A) expected reward now of a reward that is paid on arrival: E[R(s')] or E[r(s, a, s')].

    ``reward`` is R(s') of shape (S,), also paid on entering a terminal state, or r(s, a, s') of shape (S, A, S). Rows
    of actions that are not available get 0. Raises ``InputError`` for other shapes, NaN and infinity.
    """
    array = real_array("reward", reward, ndim=(1, 3))
    states, actions = mdp.n_states, mdp.n_actions
    if array.shape not in ((states,), (states, actions, states)):
        raise InputError("reward", found=f"shape {array.shape}", wanted=f"{(states,)} or {(states, actions, states)}")
    if array.ndim == 1:
        return np.asarray(frozen((mdp.matrix @ array).reshape(states, actions)))
    row = np.repeat(np.arange(states * actions), np.diff(mdp.offset))
    paid = mdp.probability * array.reshape(-1, states)[row, mdp.successor]
    return np.asarray(frozen(np.bincount(row, paid, minlength=states * actions).reshape(states, actions)))
