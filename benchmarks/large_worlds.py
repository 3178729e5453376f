"""Planning in envelopes: a million cells, a billion, and against the same goals planned one by one over all cells."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.common import Row, seconds
from subgoal.mdp import THESIS_SLIP, GridWorld, ImplicitGrid, plan_subgoals, rtdp_subgoals, value_iteration
from subgoal.runtime.checks import Ints

DISCOUNT, CONFIDENCE = 0.99, 10.0
NATS = 0.01
CANDIDATES, WALK = 200, (300, 500)
"""Candidates, and steps between the ends of the walk."""
MILLION, BILLION = 1_000, 31_623
LONGEST, MOST_GROWTH, LEAST_GAIN = 120.0, 1.5, 10.0
DENSITY = 0.1
PLAIN = 3
"""Goals that plain value iteration plans for; its time for all is a multiple."""


def walls(x: Ints, y: Ints) -> Any:
    """Free in nine cells of ten, by a hash of x and y modulo a million, so that walls are the same in any size."""
    mixed = (x % MILLION).astype(np.uint64) * np.uint64(0x9E3779B1) ^ (y % MILLION).astype(np.uint64) * np.uint64(
        0x85EBCA77
    )
    mixed = (mixed ^ (mixed >> np.uint64(15))) * np.uint64(0x2C1B3C6D)
    return ((mixed >> np.uint64(12)) % np.uint64(1000)) >= np.uint64(1000 * DENSITY)


def grid(side: int) -> ImplicitGrid:
    """Cells of a square, a tenth of them walls."""
    return ImplicitGrid(side, side, DISCOUNT, free=walls, slip=THESIS_SLIP, name="one in ten")


def walk(world: ImplicitGrid, seed: int) -> Ints:
    """States of a way between two free cells drawn at random, 300 to 500 steps apart, one free cell after another."""
    draw = np.random.default_rng(seed)
    while True:
        ends = draw.integers(0, MILLION, size=(2, 2))
        apart = np.abs(ends[1] - ends[0]).max()
        if WALK[0] <= apart <= WALK[1] and world.is_free(*ends.T).all():
            break
    cells = [ends[0]]
    while (cells[-1] != ends[1]).any():
        around = cells[-1] + world.directions
        free = np.flatnonzero(world.is_free(*around.T))
        left = np.abs(ends[1] - around[free])
        cells.append(around[free[np.lexsort((left.min(axis=1), left.max(axis=1)))[0]]])
        if len(cells) > 2 * WALK[1]:
            return walk(world, seed + 1)
    return world.states(np.array(cells))


def planned(world: ImplicitGrid, states: Ints, count: int = CANDIDATES) -> tuple[float, Any]:
    """Seconds from start to bounds for so many of the states as candidates, and the plan."""
    goals = states[np.linspace(0, states.size - 1, count).astype(int)]
    begin = time.perf_counter()
    plan = rtdp_subgoals(world, goals, states=states, tolerance=NATS / (2 * CONFIDENCE))
    return time.perf_counter() - begin, plan


def large() -> list[Row]:
    """200 candidates along a walk of some 400 steps, in 10⁶ cells and in 10⁹."""
    small, huge = grid(MILLION), grid(BILLION)
    states = walk(small, 0)
    moved = huge.states(small.cells(states))
    planned(small, states[:20], 10)
    (short, plan), (long, same) = planned(small, states), planned(huge, moved)
    gap = 2 * CONFIDENCE * max(plan.error_bound, same.error_bound)
    what = f"200 candidates, {states.size} states, 10⁶ cells, γ = .99"
    return [
        Row(what, f"{short:.1f} s", "< 120 s", short < LONGEST),
        Row(
            "  the same in 10⁹ cells", f"{long:.1f} s", "< 1.5 x", long / short < MOST_GROWTH, "10⁶ cells", long / short
        ),
        Row("  largest error of a log probability", f"{gap:.4f}", "≤ 0.01 nats", gap <= NATS),
    ]


def against(side: int) -> list[Row]:
    """20 candidates along a walk in side² cells, against a value iteration for each, and against all at once."""
    world = GridWorld(np.ones((side, side), bool), DISCOUNT, slip=THESIS_SLIP)
    cells = side // 2 + np.array([[k, k // 3] for k in range(-20, 20)])
    states = world.states(cells)
    goals, mdp = states[::2], world.mdp
    tolerance = NATS / (2 * CONFIDENCE)
    ours = seconds(lambda: rtdp_subgoals(world, goals, states=states, tolerance=tolerance), repeats=2)
    exact = seconds(lambda: plan_subgoals(mdp, goals, states=states, tolerance=tolerance), repeats=2)

    def plain() -> None:
        for goal in goals[:PLAIN]:
            value_iteration(mdp, np.arange(mdp.n_states) == goal, tolerance=tolerance)

    one_by_one = seconds(plain, repeats=1, warm=False) * goals.size / PLAIN
    gain = one_by_one / ours
    what = f"20 candidates, a walk of 40, {side**2:,} cells"
    return [
        Row(what, f"{ours:.2f} s", "≥ 10 x", gain >= LEAST_GAIN, "value iteration, a goal at a time", gain),
        Row("  against first passage over all cells", f"{exact:.2f} s", "", True, "first passage", exact / ours),
    ]


def envelopes() -> list[Row]:
    """All of it."""
    return [*against(100), *against(316), *against(1_000), *large()]
