"""What the methods that learn one reward share: the demonstrations and features they take, and what they give back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.pairs import checked_pairs
from subgoal.mdp.planners.flow import Flow
from subgoal.mdp.planners.policy import uniform_policy
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, Ints, real_array
from subgoal.runtime.errors import InputError

NULL = 1e-7
"""Share of the largest singular value below which one counts as zero, where it is the root of an eigenvalue."""


@dataclass(frozen=True, eq=False, repr=False)
class SingleReward:
    """One policy, and the reward it came from, learned from demonstrations.

    Attributes
    ----------
    method, reference:
        What learned it, and where that is from.
    policy:
        (S, A) probability of each action; zero in terminal states.
    reward:
        (S,) R(s), up to what the method identifies; None where there is none.
    weights:
        (F,) of the features, R = Φw; None where there are none.
    outcome:
        Whether the search converged, and if not, why.
    iterations, solutions:
        Steps of the search, and how many times a policy for a reward was solved for.
    trace:
        (T, S) the reward at each step.
    undetermined:
        (F, k) directions of the weights that leave every policy as it is (a constant reward, dependent features): in
        these the weights are arbitrary. k = 0 where there are none.
    notes:
        What else a user should know of this answer.
    """

    method: str
    reference: str
    policy: Floats
    reward: Floats | None
    weights: Floats | None
    outcome: Outcome
    iterations: int
    solutions: int
    trace: Floats = field(default_factory=lambda: np.empty((0, 0)))
    undetermined: Floats = field(default_factory=lambda: np.empty((0, 0)))
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"SingleReward({self.method}: {self.outcome.name}, {self.iterations} steps, {self.solutions} solutions)"


@dataclass(frozen=True, eq=False)
class Shown:
    """Demonstrations as the methods see them.

    Attributes
    ----------
    states, actions:
        (N,) the pairs.
    offset:
        (D+1,) first pair of each trajectory, and N.
    final:
        (D,) the state after the last pair of each trajectory, where it was recorded; else that of the last pair.
    """

    states: Ints
    actions: Ints
    offset: Ints
    final: Ints

    @property
    def n_trajectories(self) -> int:
        """D."""
        return len(self.offset) - 1

    @property
    def starts(self) -> Ints:
        """(D,) first state of each trajectory."""
        return self.states[self.offset[:-1]]

    @property
    def ordered(self) -> bool:
        """Whether any trajectory has more than one pair: methods that count visits over time need that."""
        return bool((np.diff(self.offset) > 1).any())


def shown(demonstrations: Demonstrations, mdp: TabularMDP) -> Shown:
    """Checked against the world.

    Raises ``InputError`` for no pairs, for states and actions that the world does not have, and for a step from one
    pair to the next that is impossible in it, naming the observation.
    """
    check_world(mdp)
    states, actions = checked_pairs(demonstrations, mdp)
    if not states.size:
        raise InputError("demonstrations", found="no observations", wanted="one at least")
    final = check_states("demonstrations.final_states", demonstrations.final_states, mdp.n_states)
    found = Shown(states, actions, demonstrations.offset, final)
    inner = np.setdiff1d(np.arange(states.size - 1), found.offset[1:-1] - 1)
    possible = chances(mdp, states[inner], actions[inner], states[inner + 1]) > 0
    if not possible.all():
        i = int(inner[np.argmin(possible)])
        wanted = f"a state that action {actions[i]} in state {states[i]} can lead to"
        raise InputError("demonstrations.states", where=f"observation {i + 1}", found=int(states[i + 1]), wanted=wanted)
    return found


def check_features(features: Any, mdp: TabularMDP) -> Floats:
    """(S, F) features Φ, the identity where none are given: a reward for each state.

    Raises ``InputError`` for NaN, infinity and another number of rows.
    """
    if features is None:
        return np.eye(mdp.n_states)
    table = real_array("features", features, ndim=2)
    if len(table) != mdp.n_states or not table.shape[1]:
        raise InputError("features", found=f"shape {table.shape}", wanted=f"({mdp.n_states}, F), a row for each state")
    return table


def undetermined_directions(features: Floats, mdp: TabularMDP | None = None) -> Floats:
    """(F, k) orthonormal directions w that no policy depends on, whatever the reward.

    Without a world: those for which Φw is the same in every state. With one: those for which Φw = x − γ P_a x for one x
    (S,) and all actions a alike (terminal states: Φw = x). Then values move by x, and the advantages of actions not at
    all. x = 1 is the constant reward; where a terminal state pays once, it must be worth 1/(1 − γ) of it. At γ = 0 all
    directions are such. Singular values below 1e-7 of the largest count as zero here, being roots of eigenvalues.
    """
    if mdp is not None:
        return _without_advantage(features, mdp)
    centred = features - features.mean(axis=0)
    _, sizes, right = np.linalg.svd(centred, full_matrices=True)
    tolerance = max(features.shape) * np.finfo(float).eps * max(np.abs(features).max(), sizes.max(initial=0.0))
    return np.ascontiguousarray(right[int((sizes > tolerance).sum()) :].T)


def _without_advantage(features: Floats, mdp: TabularMDP) -> Floats:
    """With x = (I − γP)⁻¹ Φw for the uniform policy: the null space of γ(P_a − P) x over states and actions."""
    flow = Flow(mdp, uniform_policy(mdp.available))
    potential = flow.backwards(features)
    mean = flow.transition @ potential
    square, size = np.zeros((features.shape[1],) * 2), float(np.square(mean).sum(axis=0).max(initial=0.0))
    for action in range(mdp.n_actions):
        legal = mdp.available[:, action]
        rows = np.flatnonzero(legal) * mdp.n_actions + action
        apart = mdp.discount * (mdp.matrix[rows] @ potential - mean[legal])
        square += apart.T @ apart
    sizes, directions = np.linalg.eigh(square)
    tolerance = NULL**2 * max(float(sizes.max(initial=0.0)), NULL**2 * size)
    return np.ascontiguousarray(directions[:, sizes <= tolerance])


def told(directions: Floats) -> tuple[str, ...]:
    """A note for each result whose features do not determine the reward."""
    if not directions.shape[1]:
        return ()
    ways = f"{directions.shape[1]} of {len(directions)}"
    return (f"the weights are not determined by any demonstrations in {ways} directions: no policy depends on them",)


def chances(mdp: TabularMDP, states: Ints, actions: Ints, after: Ints) -> Floats:
    """(N,) P(s' | s, a) of each step."""
    if not states.size:
        return np.empty(0)
    rows = mdp.matrix[states * mdp.n_actions + actions]
    at: Any = rows[np.arange(states.size), after]
    return np.asarray(at).ravel()


def observed(shape: tuple[int, int], pairs: Shown) -> Floats:
    """(S, A) how often each pair was shown."""
    counts = np.zeros(shape)
    np.add.at(counts, (pairs.states, pairs.actions), 1.0)
    return counts
