"""Real-time dynamic programming with bounds: planning for subgoals whose cost follows the demonstration, not the world.

The thesis (5.1.1) plans on an envelope of states around the demonstration, with nothing outside it, and grows it where
greedy behaviour leads: a lower bound, whose policy has no reason to leave; see ``rtdp_literal``. Here an upper bound is
kept beside it, with an admissible heuristic outside (as in LAO*, Hansen & Zilberstein 2001, and bounded RTDP, McMahan
et al. 2005). The envelope grows where greedy behaviour under the upper bound leaves it, weighed by how likely that is,
until the bounds meet at every state and action that was asked for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from subgoal.mdp.local_world import LocalWorld, local_world
from subgoal.mdp.planners.goals import goal_sets
from subgoal.mdp.planners.growing import Bounds, Settings, plan_group, rounding_of
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.precompute import over_groups
from subgoal.mdp.planners.subgoal_plan import Convention, SubgoalPlan
from subgoal.runtime.checks import Floats, Ints, positive, whole
from subgoal.runtime.errors import InputError, PlanningError
from subgoal.runtime.progress import Progress, Silent

LANES = 10
"""Subgoals that are planned for side by side, each with two bounds, in an envelope of their own."""
MOST_STATES = 2_000_000
TOLERANCE = 5e-6
"""Default error bound as a share of the largest value: 0.01 nats per observation at γ = 0.99 and α = 10."""


def rtdp_subgoals(
    world: Any,
    goals: Any,
    *,
    states: Any,
    convention: Convention = "continuing",
    tolerance: float | None = None,
    most_states: int = MOST_STATES,
    workers: int | None = None,
    backend: str = "threading",
    cache: str | Path | None = None,
    allow_unconverged: bool = True,
    progress: Progress | None = None,
) -> SubgoalPlan:
    """Values of G subgoals at U states, from an envelope around these (thesis 5.1.1), with bounds of their errors.

    Parameters
    ----------
    world:
        A ``GridWorld`` or ``ImplicitGrid``, which know an admissible heuristic, or another ``LocalWorld``; a
        ``TabularMDP`` is taken without one. The discount must be below 1.
    goals:
        (G,) states, or G sets of states.
    states:
        (U,) states whose values and action values are wanted: those that were observed.
    convention:
        As in ``plan_subgoals``.
    tolerance:
        Largest error of an action value in units of c; the envelopes grow until it is met. Default: 5e-6 of the
        largest value, 1/(1 − γ) or 1.
    most_states:
        How many states an envelope may hold, beyond the first: goals, states and what one action may lead to from
        them. Where that is not enough, the bounds reached so far are the result and its status is BUDGET.
    workers, backend:
        Groups of up to ten goals near each other are planned for apart: in threads, in processes ("loky") or on a
        connected Dask cluster ("dask"). The plan is the same, bit for bit, whatever these are.
    cache:
        A folder in which each group's bounds are kept by content, so that a run that was stopped goes on.
    allow_unconverged:
        False: raise where the tolerance was not met, instead of saying so in the status.
    progress:
        Told how many goals are done.

    Memory: 16·U·(A + 1)·G bytes, and about 2 kB for each state of the envelope that each worker has in hand.

    Raises
    ------
    InputError
        Goals or states that do not exist, an empty set, a discount of 1, a cache for a world that cannot be told from
        others, a heuristic that says less than can be reached.
    PlanningError
        The tolerance was not met, unless ``allow_unconverged``.
    """
    seen = local_world(world)
    if not seen.discount < 1:
        raise InputError("discount", found=seen.discount, wanted="below 1, to plan for subgoals that are held")
    if convention not in ("continuing", "absorbing"):
        raise InputError("convention", found=repr(convention), wanted="'continuing' or 'absorbing'")
    top = 1.0 / (1.0 - seen.discount) if convention == "continuing" else 1.0
    tolerance = TOLERANCE * top if tolerance is None else positive("tolerance", tolerance)
    settings = Settings(convention, tolerance, whole("most_states", most_states))
    sets = goal_sets(goals, seen.check)
    kept = np.atleast_1d(seen.check("states", states))
    if kept.ndim != 1 or not kept.size:
        raise InputError("states", found=f"shape {kept.shape}", wanted="(U,), one at least")
    groups = near_groups(seen, sets)
    jobs = [(seen, [sets[g] for g in group], kept, settings) for group in groups]
    solved = over_groups(
        plan_group, jobs, [len(group) for group in groups], workers=workers, backend=backend, cache=cache,
        progress=progress or Silent(),
    )  # fmt: skip
    plan = _collected(kept, groups, solved, settings, top, seen.discount)
    if plan.status is not PlanStatus.SOLVED and not allow_unconverged:
        bound = f"error bound {plan.error_bound:.3g}, tolerance {tolerance:.3g}, {plan.n_inside} states inside"
        raise PlanningError(f"planning for {len(sets)} subgoals: {plan.status.value} ({bound})")
    return plan


def near_groups(world: LocalWorld, sets: list[Ints]) -> list[Ints]:
    """Goals in groups of ``LANES``: the first that is left over and those that are nearest to it."""
    first = np.array([members[0] for members in sets])
    single = np.array([len(members) == 1 for members in sets])
    groups = []
    for kind in (True, False):
        left = np.flatnonzero(single == kind)
        while left.size:
            reach = world.reach_bound(first[left], first[left[:1]])[:, 0]
            reach[0] = np.inf
            nearest = np.argsort(-reach, kind="stable")[:LANES]
            groups.append(np.sort(left[nearest]))
            left = np.delete(left, nearest)
    return groups


def _collected(
    states: Ints, groups: list[Ints], solved: list[Bounds], settings: Settings, top: float, discount: float
) -> SubgoalPlan:
    """The middle of the bounds of all groups, and how far from it they are."""
    rounding = rounding_of(top, discount)
    n_goals = sum(len(group) for group in groups)
    n_actions = solved[0].rows.shape[2]
    value, gap = np.empty((states.size, n_goals)), np.empty((states.size, n_goals))
    rows = np.empty((states.size, n_actions, n_goals))
    for group, each in zip(groups, solved, strict=True):
        value[:, group] = each.value.mean(axis=0)
        rows[:, :, group] = each.rows.mean(axis=0)
        gap[:, group] = half_gap(each) + rounding
    by_severity = [PlanStatus.SOLVED, PlanStatus.ROUNDING, PlanStatus.BUDGET]
    status = max((each.status for each in solved), key=by_severity.index)
    return SubgoalPlan(
        states, value, rows, settings.convention, float(gap.max()), settings.tolerance, status,
        sum(each.sweeps for each in solved), sum(each.backups for each in solved), half_gap=gap,
        n_inside=max(each.n_inside for each in solved),
    )  # fmt: skip


def half_gap(bounds: Bounds) -> Floats:
    """(U, J) half of the largest gap between the bounds of a value and of the action values of its state."""
    legal = np.isfinite(bounds.rows[0])
    rows = np.subtract(bounds.rows[1], bounds.rows[0], where=legal, out=np.zeros_like(bounds.rows[0]))
    return np.asarray(np.maximum(rows.max(axis=1), bounds.value[1] - bounds.value[0]) / 2)
