"""Slow, obvious planning: dense arrays, policy iteration by linear solves, one goal at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def random_world(
    seed: int, n_states: int = 7, n_actions: int = 3, *, terminal: int = 0, illegal: bool = False, one_way: bool = False
) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_]]:
    """P (S, A, S), legal (S, A), terminal (S,): one to three successors a row, self-transitions among them."""
    generator = np.random.default_rng(seed)
    table = np.zeros((n_states, n_actions, n_states))
    legal = np.ones((n_states, n_actions), bool)
    ends = np.zeros(n_states, bool)
    ends[n_states - terminal :] = True
    if illegal:
        legal = generator.random((n_states, n_actions)) < 0.7
        legal[np.arange(n_states), generator.integers(n_actions, size=n_states)] = True
    legal[ends] = False
    for s in range(n_states):
        for a in np.flatnonzero(legal[s]):
            low = s if one_way else 0
            reached = generator.integers(low, n_states, size=generator.integers(1, 4))
            for t, p in zip(reached, generator.dirichlet(np.ones(len(reached))), strict=True):
                table[s, a, t] += p
    return table, legal, ends


def optimal_values(
    table: Array, legal: NDArray[np.bool_], ends: NDArray[np.bool_], reward: Array, discount: float
) -> tuple[Array, Array]:
    """V* (S,) and Q* (S, A), −inf where illegal, for a reward R(s) collected in every state, terminal ones once."""
    n_states = len(reward)
    everyone = np.arange(n_states)
    policy = legal.argmax(axis=1)
    while True:
        matrix = table[everyone, policy] * ~ends[:, None]
        value = np.linalg.solve(np.eye(n_states) - discount * matrix, reward)
        q = np.where(legal, reward[:, None] + discount * (table @ value), -np.inf)
        better = q.argmax(axis=1)
        gain = np.where(ends, 0.0, q[everyone, better]) - np.where(ends, 0.0, q[everyone, policy])
        change = ~ends & (gain > 1e-12 * max(1.0, np.abs(value).max()))
        if not change.any():
            return value, q
        policy = np.where(change, better, policy)


def subgoal_values(
    table: Array, legal: NDArray[np.bool_], ends: NDArray[np.bool_], goal: list[int], discount: float, convention: str
) -> tuple[Array, Array]:
    """V* and Q* for reward one in the states of ``goal``: at every visit, or once and the episode is over."""
    reward = np.zeros(len(ends))
    reward[goal] = 1.0
    if convention == "continuing":
        return optimal_values(table, legal, ends, reward, discount)
    over = ends.copy()
    over[goal] = True
    value, q = optimal_values(table * ~over[:, None, None], legal & ~over[:, None], over, reward, discount)
    q[goal] = np.where(legal[goal], 1.0, -np.inf)
    return value, q
