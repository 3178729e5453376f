"""The value of a policy by one sparse linear solve, and policy iteration on top of it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import breadth_first_order
from scipy.sparse.linalg import splu

from subgoal.mdp.planners.bellman import Bellman, Plan, delivered
from subgoal.mdp.planners.policy import check_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, Ints, frozen, whole
from subgoal.runtime.errors import InputError, PlanningError


def policy_evaluation(mdp: TabularMDP, policy: Any, reward: Any = None) -> Floats:
    """(S,) the value V of a policy, V = R + γ P_π V (thesis 2.2), by a direct sparse solve and one refinement.

    ``policy`` is one action per state, (S,), or probabilities, (S, A); ``reward`` is as in ``value_iteration``. Raises
    ``InputError`` for a policy that takes actions that are not available, and, at discount 1, for one that may go on
    for ever, naming the state.
    """
    bellman, table = Bellman.of(mdp, reward), check_policy(mdp, policy)
    if mdp.discount == 1:
        ending = ends(mdp, _chosen(mdp, table) @ mdp.matrix)
        if not ending.all():
            found = f"a policy that may go on for ever from state {int(np.argmin(ending))}"
            raise InputError("policy", found=found, wanted="one that ends, or a discount below 1")
    return np.asarray(frozen(_solve(bellman, table)))


def policy_iteration(
    mdp: TabularMDP,
    reward: Any = None,
    *,
    tolerance: float | None = None,
    initial: Any = None,
    most_sweeps: int = 1_000,
    allow_unconverged: bool = False,
) -> Plan:
    """Solve for the value of a policy, improve it wherever an action is better by more than rounding, repeat.

    ``initial`` is the policy to start with, (S,); not given: at discount 1 a way to a terminal state, otherwise the
    greedy one after a backup of zero. ``most_sweeps`` bounds the improvements. Other arguments, the result and the
    errors are those of ``value_iteration``; at discount 1 the plan is the best of the policies that end.
    """
    bellman, most = Bellman.of(mdp, reward), whole("most_sweeps", most_sweeps)
    tolerance, policy = bellman.tolerance(tolerance), _first_policy(bellman, initial)
    sweeps, stable = 0, False
    while not stable and sweeps < most:
        if mdp.discount == 1:
            _check_ends(mdp, policy)
        last = bellman.backup(_solve(bellman, policy), policy)
        stable, policy, sweeps = bool((last.policy == policy).all()), last.policy, sweeps + 1
    last, sweeps = bellman.backup(last.value), sweeps + 1
    plan = bellman.plan(last, tolerance, limited=not stable, sweeps=sweeps, backups=sweeps * bellman.rows)
    return delivered(plan, "policy iteration", tolerance, allow_unconverged)


def ends(mdp: TabularMDP, graph: Any) -> Bools:
    """(S,) whether a terminal state can be reached along the entries of ``graph`` (S, S), from state to successor."""
    return np.asarray(_towards_ends(mdp, graph) >= 0)


def _towards_ends(mdp: TabularMDP, graph: Any) -> Ints:
    """(S,) the next state on a shortest way to a terminal state; S in terminal states, −1 where there is no way."""
    states = mdp.n_states
    entries = sparse.coo_array(graph)
    ways = entries.data > 0
    final = np.flatnonzero(mdp.terminal)
    source = np.concatenate([entries.coords[1][ways], np.full(final.size, states)])
    target = np.concatenate([entries.coords[0][ways], final])
    back = sparse.csr_array((np.ones(source.size), (source, target)), shape=(states + 1, states + 1))
    _, before = breadth_first_order(back, states)
    return np.maximum(before[:states].astype(np.int64), -1)


def _first_policy(bellman: Bellman, initial: Any) -> Ints:
    mdp = bellman.mdp
    if initial is not None:
        table = check_policy(mdp, initial)
        if table.ndim != 1:
            raise InputError("initial", found=f"shape {table.shape}", wanted="one action per state")
        return table
    if mdp.discount < 1:
        return bellman.backup(bellman.start(None)).policy
    row = np.repeat(np.arange(mdp.available.size), np.diff(mdp.offset))
    state = row // mdp.n_actions
    ahead = _towards_ends(mdp, sparse.coo_array((mdp.probability, (state, mdp.successor)), shape=(mdp.n_states,) * 2))
    leads = (mdp.successor == ahead[state]) & (mdp.probability > 0)
    policy = np.full(mdp.n_states, -1)
    where, first = np.unique(state[leads], return_index=True)
    policy[where] = row[leads][first] % mdp.n_actions
    return policy


def _check_ends(mdp: TabularMDP, policy: Ints) -> None:
    ending = ends(mdp, _chosen(mdp, policy) @ mdp.matrix)
    if not ending.all():
        state = int(np.argmin(ending))
        raise PlanningError(
            f"policy iteration: at discount 1 a policy came up that may go on for ever from state {state}, as where "
            "rewards can be collected without end. Try: a discount below 1"
        )


def _chosen(mdp: TabularMDP, policy: NDArray[Any]) -> Any:
    """(S, S·A) picks the row of the policy, or mixes the rows, of every state that is not terminal."""
    states, actions = mdp.available.shape
    if policy.ndim == 1:
        state = np.flatnonzero(~mdp.terminal)
        entries = (np.ones(state.size), (state, state * actions + policy[state]))
    else:
        row = np.flatnonzero(policy)
        entries = (policy.ravel()[row], (row // actions, row))
    return sparse.csr_array(entries, shape=(states, states * actions))


def _solve(bellman: Bellman, policy: NDArray[Any]) -> Floats:
    """V of (I − γ P_π) V = R_π, terminal states being worth their own."""
    mdp = bellman.mdp
    chosen = _chosen(mdp, policy)
    known = chosen @ bellman.each + bellman.ending
    system = sparse.csc_array(sparse.eye_array(mdp.n_states) - mdp.discount * (chosen @ mdp.matrix))
    solve = splu(system).solve
    value = solve(known)
    return np.asarray(value + solve(known - system @ value))
