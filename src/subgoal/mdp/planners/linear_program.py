"""Optimal values as a linear program: the smallest values that no backup exceeds."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.optimize import linprog

from subgoal.mdp.planners.bellman import Bellman, Plan, delivered
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import PlanningError


def linear_program(
    mdp: TabularMDP, reward: Any = None, *, tolerance: float | None = None, allow_unconverged: bool = False
) -> Plan:
    """Minimise Σ V(s) such that V(s) ≥ r(s, a) + γ Σ P(s' | s, a) V(s') for every available action (HiGHS).

    Slow, and independent of all iteration: for checks. Its values pass through one backup, which gives the policy and
    the error bound; HiGHS leaves out probabilities below 1e-9, which that bound includes. Arguments, result and errors
    are those of ``value_iteration``.
    """
    bellman = Bellman.of(mdp, reward)
    tolerance = bellman.tolerance(tolerance)
    last = bellman.backup(_smallest(bellman))
    plan = bellman.plan(last, tolerance, limited=False, sweeps=1, backups=bellman.rows)
    return delivered(plan, "linear program", tolerance, allow_unconverged)


def _smallest(bellman: Bellman) -> Floats:
    mdp = bellman.mdp
    legal = np.flatnonzero(mdp.available)
    own = sparse.csr_array((np.ones(legal.size), (np.arange(legal.size), legal // mdp.n_actions)),
                           shape=(legal.size, mdp.n_states))  # fmt: skip
    scale = bellman.largest or 1.0
    lower = np.where(mdp.terminal, bellman.ending / scale, -np.inf)
    upper = np.where(mdp.terminal, bellman.ending / scale, np.inf)
    problem: dict[str, Any] = {
        "A_ub": sparse.csr_array(mdp.discount * mdp.matrix[legal] - own),
        "b_ub": -bellman.gains / scale,
        "bounds": np.column_stack([lower, upper]),
    }
    told: Any = linprog(np.ones(mdp.n_states), method="highs", **problem)
    if told.x is None:
        raise PlanningError(f"linear program: {told.message}")
    return np.asarray(told.x) * scale
