"""Random dense worlds for the tests of planning, and the planners that are tested on them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from subgoal.mdp.planners.iteration import linear_program, modified_policy_iteration, policy_iteration, value_iteration
from subgoal.mdp.tabular import TabularMDP
from tests.oracles import exact_planning as oracle


class World(NamedTuple):
    """P (S, A, S) with zero rows for illegal actions and terminal states; R(s) (S,) or r(s, a) (S, A)."""

    table: np.ndarray
    reward: np.ndarray
    discount: float

    @property
    def mdp(self) -> TabularMDP:
        return TabularMDP.from_dense(self.table, self.discount)

    @property
    def gains(self) -> np.ndarray:
        """(S, A) what an action is paid at once."""
        return np.broadcast_to(self.reward.reshape(len(self.table), -1), self.table.shape[:2])

    @property
    def ending(self) -> np.ndarray:
        """(S,) what a terminal state is worth."""
        terminal = ~self.table.any(axis=(1, 2))
        return self.reward * terminal if self.reward.ndim == 1 else np.zeros(len(self.table))


def random_world(seed: int, *, discount: float | None = None, states: int | None = None, per_action=None) -> World:
    """1 to 12 states, 1 to 4 actions of which some are missing, few or many successors, some worlds with endings."""
    generator = np.random.default_rng(seed)
    states = states or int(generator.integers(1, 13))
    actions = int(generator.integers(1, 5))
    table = generator.dirichlet(np.full(states, generator.choice([0.05, 0.3, 3.0])), (states, actions))
    table[table < 1e-9] = 0
    missing = generator.random((states, actions)) < 0.25
    missing[np.arange(states), generator.integers(0, actions, states)] = False
    table[missing] = 0
    if generator.random() < 0.5 and states > 1:
        table[generator.choice(states, states // 4 + 1, replace=False)] = 0
    sums = table.sum(axis=2, keepdims=True)
    table = np.divide(table, sums, out=np.zeros_like(table), where=sums > 0)
    per_action = generator.random() < 0.5 if per_action is None else per_action
    reward = generator.normal(size=(states, actions) if per_action else states) * generator.choice([1e-3, 1, 1e4])
    discount = float(generator.choice([0, 0.5, 0.9, 0.99, 0.999])) if discount is None else discount
    return World(table, reward, discount)


def in_place(mdp, reward=None, **options):
    return value_iteration(mdp, reward, in_place=True, **options)


ITERATIVE = [value_iteration, in_place, modified_policy_iteration]
PLANNERS = [*ITERATIVE, policy_iteration, linear_program]


def optimum(world: World) -> np.ndarray:
    """(S,) optimal values, by the oracle."""
    return oracle.best_by_policy_iteration(world.table, world.gains, world.ending, world.discount)
