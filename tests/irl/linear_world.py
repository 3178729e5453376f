"""A small world with slips, two features and an optimal demonstrator, for the methods of one reward."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.planners.iteration import action_values, policy_iteration
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP

DISCOUNT = 0.8


def dense(*, ending: bool = False) -> np.ndarray:
    """P(s' | s, a) (9, 3, 9) of a ring: back, stay, on, of which steps fail in one case of five; 4 may be an end."""
    table = np.zeros((9, 3, 9))
    for s in range(9):
        for a, move in enumerate((-1, 0, 1)):
            table[s, a, (s + move) % 9] += 0.8
            table[s, a, s] += 0.2
    if ending:
        table[4] = 0.0
    return table


def world(*, ending: bool = False, discount: float = DISCOUNT) -> TabularMDP:
    return TabularMDP.from_dense(dense(ending=ending), discount)


FEATURES = np.array([[0, 2, 4, 6, 8, 6, 4, 2, 0], [1, 0, 0, 0, 0, 0, 0, 3, 0]], float).T
"""(9, 2) closeness to state 4 and something bad in state 7."""
TRUE = FEATURES @ np.array([1.0, -2.0])


def optimal(mdp: TabularMDP, reward: np.ndarray) -> np.ndarray:
    plan = policy_iteration(mdp, reward)
    return uniform_policy(greedy_actions(action_values(mdp, plan.value, reward), 1e-9))


def demonstrations(mdp: TabularMDP, *, steps: int = 40, each: int = 3, reward: np.ndarray = TRUE) -> Demonstrations:
    """Walks of the optimal policy, ``each`` of them from every state that is not an end."""
    start = np.repeat(np.flatnonzero(~mdp.terminal), each)
    return simulate(mdp, optimal(mdp, reward), steps=steps, trajectories=start.size, start=start, seed=0)


def visits_by_series(
    transition: np.ndarray, policy: np.ndarray, start: np.ndarray, discount: float = DISCOUNT
) -> np.ndarray:
    """(S,) (1 − γ) Σ_t γ^t P(s_t = s), a thousand terms of it."""
    chain = np.einsum("sa,sat->st", policy, transition)
    now, total = start.copy(), np.zeros(len(start))
    for t in range(1000):
        total += (1 - discount) * discount**t * now
        now = now @ chain
    return total
