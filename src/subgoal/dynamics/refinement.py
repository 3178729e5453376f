"""From the best of a grid of test actions to better ones between them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from subgoal.dynamics.world import ContinuousWorld
from subgoal.runtime.checks import Floats

FULL_PATTERN = 3
"""Dimensions of the actions up to which all 3^k neighbours are tried, not just the 2k along the axes."""


def climb(
    world: ContinuousWorld, begin: Floats, worth_of: Callable[[Floats], Floats], rounds: int
) -> tuple[Floats, Floats]:
    """(B, k) actions, and (B,) what they are worth, from S beginnings (B, S, k) each, within the bounds of the actions.

    ``worth_of`` takes actions (B, M, k) to values (B, M). ``rounds`` times each beginning moves to its best neighbour,
    or stays, at half the spacing of the round before; the first spacing is half that of the test actions. No action
    that is given back is worth less than a beginning.
    """
    b, starts, k = begin.shape
    best, worth, spacing, steps = begin, worth_of(begin), _spacing(world), pattern(k)
    for _ in range(rounds):
        spacing = spacing / 2
        tried = np.clip(best[:, :, None] + steps * spacing, world.low, world.high)
        values = worth_of(tried.reshape(b, -1, k)).reshape(b, starts, -1)
        chosen = values.argmax(axis=2)
        best = np.take_along_axis(tried, chosen[:, :, None, None], axis=2)[:, :, 0]
        worth = np.take_along_axis(values, chosen[:, :, None], axis=2)[:, :, 0]
    first = worth.argmax(axis=1)
    return best[np.arange(b), first], worth[np.arange(b), first]


def pattern(k: int) -> Floats:
    """(p, k) of −1, 0 and 1: staying first, then the neighbours."""
    if k > FULL_PATTERN:
        return np.concatenate([np.zeros((1, k)), np.eye(k), -np.eye(k)])
    return np.array(list(product((0.0, -1.0, 1.0), repeat=k)))


def _spacing(world: ContinuousWorld) -> Floats:
    """(k,) between neighbours, if the test actions were a regular grid over the bounds."""
    per_axis = max(2.0, len(world.test_actions) ** (1 / world.low.size))
    return np.asarray((world.high - world.low) / (per_axis - 1))
