"""Optimal values and policies for any reward: value iteration (thesis 2.5), modified policy iteration, action values.

The planners stop on a bound of the error of the values, never on the change of a sweep as (2.6) does: at γ = 0.99 a
change of 1e-4 is a possible error of 1e-2. At discount 1 a world is solved as a shortest path problem; where a policy
may go on for ever without paying for it, no bound is known and the status says so.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal._kernels import backups as loops
from subgoal.mdp.planners.bellman import Bellman, Plan, delivered
from subgoal.mdp.planners.linear_program import linear_program
from subgoal.mdp.planners.policy_iteration import policy_evaluation, policy_iteration
from subgoal.mdp.planners.rewards import arrival_reward, check_reward
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, frozen, real_array, whole
from subgoal.runtime.errors import InputError

__all__ = [
    "Plan",
    "action_values",
    "arrival_reward",
    "linear_program",
    "modified_policy_iteration",
    "policy_evaluation",
    "policy_iteration",
    "value_iteration",
]

WORK = 2**24
"""Entries of the transition table that are read before Ctrl-C is listened to."""


def value_iteration(
    mdp: TabularMDP,
    reward: Any = None,
    *,
    tolerance: float | None = None,
    initial: Any = None,
    in_place: bool = False,
    most_sweeps: int = 1_000_000,
    allow_unconverged: bool = False,
) -> Plan:
    """V*(s) = R(s) + γ max_a Σ P(s' | s, a) V*(s') by repeated backups of all states (thesis 2.5).

    Parameters
    ----------
    reward:
        R(s), (S,), paid for being in s now, terminal states being worth their own; or r(s, a), (S, A), terminal states
        being worth nothing; None: ``mdp.reward``. For rewards paid on arrival see ``arrival_reward``.
    tolerance:
        Largest error of a value; not given: 1e-6 max |R| / (1 − γ), at discount 1 of max |R|.
    initial:
        (S,) values to start from.
    in_place:
        Let every state use the newest values of the others, from front to back and back in turn (Gauss-Seidel).
    most_sweeps:
        Passes over the states.
    allow_unconverged:
        Return what was reached, with its status, instead of raising.

    Raises
    ------
    InputError
        A reward of another shape, NaN.
    PlanningError
        The tolerance was not reached.
    """
    bellman, most = Bellman.of(mdp, reward), whole("most_sweeps", most_sweeps)
    tolerance = bellman.tolerance(tolerance)
    out, spare = np.empty(mdp.n_states), np.empty(mdp.n_states)
    last, sweeps = bellman.backup(bellman.start(initial)), 1
    while not bellman.settled(last, tolerance) and sweeps < most:
        room = min(most - sweeps - 1, 1 + WORK // (mdp.n_entries + mdp.n_states), 1 + sweeps)
        stop = bellman.stop(tolerance, last.value)
        if in_place:
            made, _ = loops.sweep_in_place(room, stop, *bellman.table, last.value, out)
        else:
            made, _ = loops.sweep_jacobi(room, stop, *bellman.table, last.value, out, spare)
        last, sweeps = bellman.backup(out), sweeps + made + 1
    limited = not bellman.settled(last, tolerance)
    plan = bellman.plan(last, tolerance, limited=limited, sweeps=sweeps, backups=sweeps * bellman.rows)
    return delivered(plan, "value iteration", tolerance, allow_unconverged)


def modified_policy_iteration(
    mdp: TabularMDP,
    reward: Any = None,
    *,
    tolerance: float | None = None,
    initial: Any = None,
    evaluation_sweeps: int = 20,
    most_sweeps: int = 1_000_000,
    allow_unconverged: bool = False,
) -> Plan:
    """As ``value_iteration``; after each backup the greedy policy alone is followed for up to ``evaluation_sweeps``.

    A sweep of one policy reads one action per state and not all of them (Puterman and Shin 1978). It stops on the
    bounds of MacQueen (1966), which close long before the values stand still where all of them grow alike. Arguments,
    result and errors are those of ``value_iteration``.
    """
    bellman, most = Bellman.of(mdp, reward), whole("most_sweeps", most_sweeps)
    tolerance, each = bellman.tolerance(tolerance), whole("evaluation_sweeps", evaluation_sweeps, least=0)
    out, spare = np.empty(mdp.n_states), np.empty(mdp.n_states)
    last, improvements, evaluations = bellman.backup(bellman.start(initial)), 1, 0
    while not bellman.settled(bellman.centred(last), tolerance) and improvements + evaluations < most:
        room = min(each, most - improvements - evaluations - 1)
        stop = bellman.stop(tolerance, last.value)
        first, to, weight, gain = loops.policy_rows(last.policy, *bellman.table)
        made, _ = loops.sweep_policy(room, stop, first, to, weight, gain, last.value, out, spare)
        evaluations += made
        last, improvements = bellman.backup(out), improvements + 1
    sweeps = improvements + evaluations
    backups = improvements * bellman.rows + evaluations * int((~mdp.terminal).sum())
    last = bellman.centred(last)
    limited = not bellman.settled(last, tolerance)
    plan = bellman.plan(last, tolerance, limited=limited, sweeps=sweeps, backups=backups)
    return delivered(plan, "modified policy iteration", tolerance, allow_unconverged)


def action_values(mdp: TabularMDP, value: Any, reward: Any = None) -> Floats:
    """(S, A) Q(s, a) = R(s) + γ Σ P(s' | s, a) V(s') (thesis 2.3); −inf for actions that are not available.

    ``value`` (S,) and ``reward`` are as in ``value_iteration``. Errors of the values are at most γ times as large here.
    """
    array = real_array("value", value, ndim=1)
    if array.size != mdp.n_states:
        raise InputError("value", found=f"{array.size} values", wanted=f"{mdp.n_states}")
    now, _ = check_reward(mdp, reward)
    ahead = mdp.discount * (mdp.matrix @ array).reshape(mdp.available.shape)
    return np.asarray(frozen(np.where(mdp.available, now.reshape(mdp.n_states, -1) + ahead, -np.inf)))
