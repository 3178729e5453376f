"""What figures 3-1 to 3-4 share: Room World and its variants, the imperfect expert, and the 0-1 policy loss.

Cells are counted from one in pictures, as in the thesis. The expert is optimal with probability 0.95 and else takes a
random action; 100 demonstrations of 50 steps make 5,000 pairs.
"""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.rooms import DRAWINGS, SHUT, RoomWorld, room_world
from subgoal.mdp.planners.iteration import action_values
from subgoal.mdp.planners.policy import greedy_actions, imperfect, uniform_policy
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.seeds import stream

TRAJECTORIES, STEPS, ERROR = 100, 50, 0.05
PAIRS = TRAJECTORIES * STEPS
FLOORS = {"random action may be the optimal one": 187.5, "may not": 250.0}
"""Pairs in which the expert does not do what its policy says, expected of 5,000: (1 − 1/4)·5 % of them, or 5 %."""
ROUNDING = 1e-9
"""Action values that differ by less, relative to the largest, are tied: values are exact up to rounding."""
FIRST, ONE_AT_RANDOM, ANEW = EXPERTS = ("the first of N, E, S, W", "one, drawn once", "drawn anew each time")
"""How an expert breaks the ties of its policy: most of the positive room is tied. The first is what a maximum over an
array gives."""


def all_worlds() -> list[RoomWorld]:
    """Both layouts, mirrored or not, with each of the three choices of doors."""
    return [
        room_world(layout, mirror=mirror, doors=doors)
        for doors, mirror, layout in itertools.product(SHUT, (False, True), DRAWINGS)
    ]


def optimal_of(world: RoomWorld) -> Bools:
    """(S, A) the actions that are optimal for the true reward."""
    mdp = world.grid.mdp
    plan = policy_iteration(mdp, world.reward)
    return greedy_actions(action_values(mdp, plan.value, world.reward), 2 * plan.error_bound)


def policy_of(world: RoomWorld, seed: int, ties: str = FIRST) -> Any:
    """The expert's policy, (S,) or (S, A): one of ``EXPERTS``."""
    optimal = optimal_of(world)
    if ties == ANEW:
        return uniform_policy(optimal)
    order = stream(seed, 31).random(optimal.shape) if ties == ONE_AT_RANDOM else -np.arange(4.0)
    return np.where(optimal, order, -np.inf).argmax(axis=1)


def demonstrate(
    world: RoomWorld, seed: int, *, ties: str = FIRST, may_be_optimal: bool = True
) -> Demonstrations:  # fmt: skip
    """100 demonstrations of 50 steps by the imperfect expert."""
    mdp = world.grid.mdp
    policy = imperfect(mdp, policy_of(world, seed, ties), error=ERROR, may_be_optimal=may_be_optimal)
    return simulate(mdp, policy, steps=STEPS, trajectories=TRAJECTORIES, start=world.start, seed=seed)


def taken_of(demos: Demonstrations, shape: tuple[int, int]) -> Floats:
    """(S, A) how often each action was taken in each state."""
    states: Ints = demos.states
    actions: Any = demos.actions
    taken = np.zeros(shape)
    np.add.at(taken, (states, actions), 1.0)
    return taken


class Losses(NamedTuple):
    """0-1 policy loss of a sequence of rewards, (T,) each.

    Attributes
    ----------
    even:
        Pairs that are not as the policy says, where it breaks ties at random.
    first:
        The same where it takes the first of the actions that are tied, in the order N, E, S, W.
    by_state:
        ``even`` with each visited state counting once, as a share between 0 and 1: states in which the expert lingers
        do not drown the others.
    """

    even: Floats
    first: Floats
    by_state: Floats


def losses(mdp: TabularMDP, values: Floats, demos: Demonstrations) -> Losses:
    """Loss of the greedy policies of optimal values (T, S). R(s) is the same for all actions, so γ P V orders them."""
    shape = mdp.available.shape
    taken = taken_of(demos, shape)
    ahead = np.moveaxis((mdp.matrix @ values.T).reshape(*shape, -1), -1, 0)
    best = ahead >= ahead.max(axis=2, keepdims=True) - ROUNDING * np.abs(ahead).max(axis=(1, 2), keepdims=True)
    visits = taken.sum(axis=1)
    right = (taken * best).sum(axis=2) / best.sum(axis=2)
    first = taken[np.arange(shape[0]), best.argmax(axis=2)]
    seen = visits > 0
    return Losses(
        visits.sum() - right.sum(axis=1),
        visits.sum() - first.sum(axis=1),
        1 - (right[:, seen] / visits[seen]).mean(axis=1),
    )


def true_losses(world: RoomWorld, demos: Demonstrations) -> Losses:
    """Loss of the true reward."""
    return losses(world.grid.mdp, policy_iteration(world.grid.mdp, world.reward).value[None], demos)
