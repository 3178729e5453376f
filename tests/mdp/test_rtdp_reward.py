"""Bounds of any reward's values in an envelope: they hold however small it is, and meet where it is large enough."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from subgoal.mdp.planners.iteration import policy_iteration
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rtdp_reward import rtdp_reward
from tests.mdp.large_worlds import random_grid, random_table

ROUNDING = 1e-9


@pytest.mark.parametrize("make", [random_grid, random_table])
@pytest.mark.parametrize("known", [False, True], ids=["anywhere", "on its support"])
def test_the_bounds_hold_however_small_the_envelope(make: Callable[[int], Any], known: bool) -> None:
    statuses = set()
    for seed in range(0, 60, 3):
        world, draw = make(seed), np.random.default_rng(seed)
        n = world.mdp.n_states
        reward = draw.uniform(-1, 1, n)
        support = draw.permutation(n)[: n // 4] if known else None
        if known:
            reward[np.setdiff1d(np.arange(n), support)] = 0.0
        exact = policy_iteration(world.mdp, reward)
        states = draw.integers(n, size=2)
        for most_states in (1, n // 4 + 1, 10_000):
            found = rtdp_reward(
                world, lambda s, told=reward: told[s], states=states, least=-1, most=1, support=support,
                most_states=most_states,
            )  # fmt: skip
            low, high = found.value
            slack = ROUNDING / (1 - world.discount)
            assert (low <= exact.value[states] + slack).all()
            assert (high >= exact.value[states] - slack).all()
            statuses.add(found.status)
            if found.status is PlanStatus.SOLVED:
                assert found.error_bound <= 2e-3 / (1 - world.discount)
    assert {PlanStatus.SOLVED, PlanStatus.BUDGET} <= statuses
