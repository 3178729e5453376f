"""What planning for subgoals gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

Convention = Literal["continuing", "absorbing"]
TIE = 1e-9
"""Actions whose values differ by less than this share of them are equally good."""


@dataclass(frozen=True, eq=False, repr=False)
class SubgoalPlan:
    """Optimal values for G subgoals, in units of the reward c (only α·c matters, so c is 1).

    Attributes
    ----------
    states:
        (U,) the states whose rows are kept.
    value:
        (U, G) V*(s) with subgoal g.
    action_values:
        (U, A, G) Q*(s, a) with subgoal g, −inf for illegal actions; None unless ``states`` were asked for.
    convention:
        "continuing" or "absorbing".
    error_bound, tolerance:
        No value and no action value is further than the first from the exact one; the second was asked for.
    status:
        Whether that is within the tolerance.
    relative:
        Whether small values are exact to rounding as well.
    half_gap:
        (U, G) how far values and action values can be from the exact ones, state by state, where bounds of them are
        known; they lie in the middle of these then.
    n_inside:
        States in the largest envelope, where planning looked at a part of the world only.
    sweeps, backups:
        Work done: passes over the states (all groups of goals together) and backups of a state in all lanes of a group.
    """

    states: Ints
    value: Floats
    action_values: Any
    convention: Convention
    error_bound: float
    tolerance: float
    status: PlanStatus
    sweeps: int
    backups: int
    relative: bool = False
    half_gap: Any = None
    n_inside: int = 0

    def __repr__(self) -> str:
        n_states, n_goals = self.value.shape
        return f"SubgoalPlan({n_goals} subgoals from {n_states} states, {self.status.name}, ±{self.error_bound:.1g})"

    @property
    def unreachable(self) -> Bools:
        """(U, G) True where the subgoal is worth nothing: out of reach whatever is done, or beyond all discount."""
        return np.asarray(self.value == 0)

    @property
    def optimal(self) -> Bools:
        """(U, A, G) the best actions, of a plan made with ``relative`` or with bounds.

        Values within 1e-9 of the largest are tied, or those that may be the largest for all that the bounds say.
        """
        if self.action_values is None or not (self.relative or self.half_gap is not None):
            raise InputError("plan", found="no values to rounding", wanted="plan_subgoals(..., states=, relative=True)")
        top = self.action_values.max(axis=1, keepdims=True)
        slack = TIE * np.abs(top) if self.half_gap is None else 2 * self.half_gap[:, None]
        return np.asarray(self.action_values >= np.where(np.isfinite(top), top - slack, np.inf))
