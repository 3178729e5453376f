"""Continuous worlds: all goals at once against a goal at a time, and from a drive of thirty seconds to its subgoals."""

from __future__ import annotations

import time
import warnings
from typing import Any

import numpy as np
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF

import subgoal
from benchmarks.common import Row, seconds
from subgoal.continuous import ContinuousWorld, GaussianSmoother, hold_actions, spread_metric
from subgoal.dynamics.car import REAR_DRIVE
from subgoal.dynamics.driver import drive
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import Ahead, plan_goals, rewards
from subgoal.mdp import PlanningWarning
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import Floats

FLOOR = np.array([0.5, 0.4, 1.0, 0.5])
SUPPORT, SWEEPS = 150, 100
PLAIN_GOALS, PLAIN_SWEEPS = 2, 3
"""Goals and sweeps of the recursion that is written a goal at a time; its time for all is a multiple."""
LEAST_GAIN, MOST_SWEEPING, MOST_ONE, MOST_TEN = 50.0, 2.0, 0.6, 5.0
NEVER = 1e-300


def problem() -> tuple[Floats, Ahead, ContinuousWorld]:
    """150 states of drives of a model car, and where 81 actions lead from each."""
    driven = drive(REAR_DRIVE, trajectories=3)
    states = np.asarray(driven.demonstrations.states)
    metric = spread_metric(states, floor=FLOOR)
    world = ContinuousWorld(REAR_DRIVE, *REAR_DRIVE.bounds, step=0.2)
    base = states[np.linspace(0, len(states) - 1, SUPPORT).astype(int)]
    return coordinates(metric, base), world.ahead_of_tests(base, metric), world


def planned(support: Floats, ahead: Ahead, discount: float, sweeps: int = SWEEPS) -> Any:
    """Weights, and so many sweeps for all goals."""
    return plan_goals(
        support, support, ahead, smoother=GaussianSmoother(), width=0.7, discount=discount, tolerance=NEVER,
        most_sweeps=sweeps,
    )  # fmt: skip


def one_goal(support: Floats, ahead: Ahead, discount: float, goal: int) -> Floats:
    """The same recursion as it is written down: in every sweep a Gaussian process is fitted to the values."""
    reward = (1 - discount) * rewards(ahead, support[goal : goal + 1], 0.7)[:, 0]
    values = np.zeros(len(support))
    for _ in range(PLAIN_SWEEPS):
        process = GaussianProcessRegressor(RBF(1.5), alpha=0.1, optimizer=None).fit(support, values)
        after = np.clip(process.predict(ahead.points[-1]), 0, 1)
        values = (reward + discount * after).reshape(len(support), -1).max(axis=1)
    return values


def sweeping() -> list[Row]:
    """150 support states, 81 actions, 150 goals, 100 sweeps."""
    support, ahead, world = problem()
    ours = seconds(lambda: planned(support, ahead, world.discount), repeats=2)
    begin = time.perf_counter()
    alone = [one_goal(support, ahead, world.discount, goal) for goal in range(PLAIN_GOALS)]
    plain = (time.perf_counter() - begin) / (PLAIN_GOALS * PLAIN_SWEEPS) * SUPPORT * SWEEPS
    same = planned(support, ahead, world.discount, PLAIN_SWEEPS).values[:, :PLAIN_GOALS]
    apart = float(np.abs(same - np.array(alone).T).max())
    what = f"{SUPPORT} support states x {ahead.points[0].shape[0] // SUPPORT} actions x {SUPPORT} goals, 100 sweeps"
    gain = plain / ours
    return [
        Row(what, f"{ours:.2f} s", "< 2 s", ours < MOST_SWEEPING, "a goal and a fit at a time", gain),
        Row("  times as fast as scikit-learn, a goal at a time", f"{gain:.0f}", "≥ 50", gain >= LEAST_GAIN),
        Row("  and the same values, to", f"{apart:.0e}", "1e-8", apart <= 1e-8),
    ]


def learned(drives: int) -> float:
    """Seconds from the pairs of so many drives to 100 sweeps of one chain, planning and table included."""
    driven = drive(REAR_DRIVE, trajectories=drives)
    pairs = hold_actions(driven.demonstrations, 20)
    metric = spread_metric(np.asarray(driven.demonstrations.states), floor=FLOOR)

    def learn() -> None:
        with warnings.catch_warnings():
            for kind in (ConvergenceWarning, PlanningWarning):
                warnings.simplefilter("ignore", kind)
            subgoal.gpsrl(pairs, REAR_DRIVE, metric=metric, chains=1, warmup=50, draws=50, thin=1, seed=0)

    return seconds(learn)


def learning() -> list[Row]:
    """One drive of thirty seconds, and ten."""
    one, ten = learned(1), learned(10)
    return [
        Row("a drive of 30 s: planning, table, 100 temporal sweeps", f"{one:.2f} s", "< 0.6 s", one < MOST_ONE),
        Row("  ten of them", f"{ten:.2f} s", "< 5 s", ten < MOST_TEN, "one drive", ten / one),
    ]


def drives() -> list[Row]:
    """All of it."""
    return [*sweeping(), *learning()]
