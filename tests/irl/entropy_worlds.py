"""Small worlds and what a soft planner shows in them, for the tests of maximum entropy."""

from __future__ import annotations

import numpy as np

from subgoal.mdp.planners.soft import soft_value_iteration
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP

DISCOUNTS = (0.0, 0.5, 0.9, 0.99, 0.999)
OBJECTIVES = ("likelihood", "feature_matching")


def world(seed: int, discount: float, *, ends: bool = False, states: int = 6) -> TabularMDP:
    """Some states with three uncertain actions, one of which is missing somewhere; the last state may be an ending."""
    generator = np.random.default_rng(seed)
    table = generator.dirichlet(np.full(states, 0.4), (states, 3))
    table[1, 2] = 0
    table[table < 1e-3] = 0
    if ends:
        table[-1] = 0
        table[:-1, 0, -1] += 0.3
    sums = table.sum(axis=2, keepdims=True)
    table = np.divide(table, sums, out=np.zeros_like(table), where=sums > 0)
    start = np.full(states, 1 / states)
    if ends:
        start = np.append(np.full(states - 1, 1 / (states - 1)), 0.0)
    return TabularMDP.from_dense(table, discount, start=start)


def acted(mdp: TabularMDP, *, trajectories: int = 8, steps: int = 5, seed: int = 0, size: float = 1.0):
    """What a soft planner shows, and its reward."""
    reward = size * np.random.default_rng(seed + 100).normal(size=mdp.n_states)
    if mdp.discount == 1:
        reward -= 2 + size
    policy = soft_value_iteration(mdp, reward).policy
    return simulate(mdp, policy, steps=steps, trajectories=trajectories, seed=seed), reward


def features_of(mdp: TabularMDP, count: int = 4) -> np.ndarray:
    return np.random.default_rng(5).normal(size=(mdp.n_states, count))


def tiny() -> tuple[TabularMDP, np.ndarray]:
    """Four states, two actions, no state leads to itself; the last is an ending."""
    table = np.zeros((4, 2, 4))
    table[0] = [[0, 0.6, 0.4, 0], [0, 0, 1, 0]]
    table[1] = [[0.5, 0, 0.5, 0], [0.2, 0, 0, 0.8]]
    table[2] = [[0.7, 0.3, 0, 0], [0, 0.1, 0, 0.9]]
    return TabularMDP.from_dense(table, 0.9, start=np.array([0.5, 0.3, 0.2, 0])), table
