"""How a planner ended, shared by all of them."""

from __future__ import annotations

import enum


class PlanStatus(enum.Enum):
    """What a plan is worth; the value says it in words."""

    SOLVED = "solved: the error bound is within the tolerance"
    ROUNDING = "as exact as rounding allows; the error bound is above the tolerance. Try: a larger tolerance"
    LIMIT = "NOT CONVERGED: the limit of sweeps was reached. Try: more sweeps or a larger tolerance"
    BUDGET = "NOT CONVERGED: the budget of states was reached. Try: a larger most_states or tolerance, or a nearer goal"
    SETTLED = "settled: the values no longer change, but at discount 1 no bound on their error is known"


class PlanningWarning(UserWarning):
    """A plan is less exact than was asked for; its status and its error bound say how much."""
