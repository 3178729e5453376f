"""What flows through a world under one policy: values backwards, expected visits forwards, by one factorisation."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from subgoal.mdp.planners.policy import check_policy
from subgoal.mdp.planners.policy_iteration import ends
from subgoal.mdp.tabular import TabularMDP, check_world
from subgoal.runtime.checks import Floats, frozen, real_array
from subgoal.runtime.errors import InputError


class Flow:
    """I − γP_π of one policy (S, A), factorised; P_π(s, s') = Σ_a π(a | s) P(s' | s, a), no row in terminal states.

    Raises ``RuntimeError``, as SuperLU does, where the matrix is singular: at discount 1, for a policy that never ends.
    """

    def __init__(self, mdp: TabularMDP, policy: Floats) -> None:
        row = np.flatnonzero(policy)
        shape = (mdp.n_states, policy.size)
        chosen = sparse.csr_array((policy.ravel()[row], (row // mdp.n_actions, row)), shape=shape)
        self.transition = chosen @ mdp.matrix
        self._system = sparse.csc_array(sparse.eye_array(mdp.n_states) - mdp.discount * self.transition)
        self._solve: Any = splu(self._system).solve

    def backwards(self, gain: Floats) -> Floats:
        """(S,) or (S, F) x = g + γ P_π x: what ``gain`` is worth over time; one refinement."""
        found = self._solve(gain)
        return np.asarray(found + self._solve(gain - self._system @ found))

    def forwards(self, start: Floats) -> Floats:
        """(S,) x = b + γ P_πᵀ x: discounted visits from ``start``, which may have any signs; one refinement."""
        found = self._solve(start, "T")
        return np.asarray(found + self._solve(start - self._system.T @ found, "T"))


def expected_visits(mdp: TabularMDP, policy: Any, start: Any = None) -> Floats:
    """(S,) ρ(s) = Σ_t γ^t P(s_t = s), the discounted visits of a policy; γ is the discount of the world.

    ρ = b + γ P_πᵀ ρ. Without terminal states Σ ρ = 1/(1 − γ); a terminal state is visited once, on arrival.

    Parameters
    ----------
    policy:
        (S,) actions or (S, A) probabilities.
    start:
        (S,) probabilities b of the first state; None: ``mdp.start``.

    Raises
    ------
    InputError
        A bad policy, no start, and, at discount 1, a policy that may go on for ever, naming the state.
    """
    check_world(mdp)
    table = check_policy(mdp, policy)
    if table.ndim == 1:
        table = (table[:, None] == np.arange(mdp.n_actions)).astype(float)
    given = mdp.start if start is None else start
    if given is None:
        raise InputError("start", found="None, and the world has none either", wanted="(S,) probabilities")
    first = real_array("start", given, ndim=1)
    if first.shape != (mdp.n_states,) or not ((first >= 0).all() and abs(first.sum() - 1) <= 1e-8):
        found = f"{first.size} numbers that sum to {first.sum():.12g}"
        raise InputError("start", found=found, wanted=f"{mdp.n_states} probabilities that sum to 1")
    if mdp.discount == 1:
        check_ends(mdp, table)
    return np.asarray(frozen(Flow(mdp, table).forwards(first)))


def check_ends(mdp: TabularMDP, policy: Floats) -> None:
    """Raise ``InputError`` for a policy (S, A) that may go on for ever, naming the state."""
    row = np.flatnonzero(policy)
    entries = (policy.ravel()[row], (row // mdp.n_actions, row))
    ending = ends(mdp, sparse.csr_array(entries, shape=(mdp.n_states, policy.size)) @ mdp.matrix)
    if not ending.all():
        found = f"a policy that may go on for ever from state {int(np.argmin(ending))}"
        raise InputError("policy", found=found, wanted="one that ends, or a discount below 1")
