"""What the methods that learn one reward share: the demonstrations and features they take, and what they give back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.planned_actions import checked_pairs
from subgoal.mdp.tabular import TabularMDP, check_states
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, Ints, real_array
from subgoal.runtime.errors import InputError


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
    states, actions = checked_pairs(demonstrations, mdp)
    if not states.size:
        raise InputError("demonstrations", found="no observations", wanted="one at least")
    final = check_states("demonstrations.final_states", demonstrations.final_states, mdp.n_states)
    found = Shown(states, actions, demonstrations.offset, final)
    inner = np.setdiff1d(np.arange(states.size - 1), found.offset[1:-1] - 1)
    possible = _chances(mdp, states[inner], actions[inner], states[inner + 1]) > 0
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


def undetermined_directions(features: Floats) -> Floats:
    """(F, k) orthonormal directions w for which Φw is the same in every state, so that no policy depends on them."""
    centred = features - features.mean(axis=0)
    _, sizes, right = np.linalg.svd(centred, full_matrices=True)
    tolerance = max(features.shape) * np.finfo(float).eps * max(np.abs(features).max(), sizes.max(initial=0.0))
    return np.ascontiguousarray(right[int((sizes > tolerance).sum()) :].T)


def told(directions: Floats) -> tuple[str, ...]:
    """A note for each result whose features do not determine the reward."""
    if not directions.shape[1]:
        return ()
    ways = f"{directions.shape[1]} of {len(directions)}"
    return (f"the weights are not determined by any demonstrations in {ways} directions: there, rewards are constant",)


def _chances(mdp: TabularMDP, states: Ints, actions: Ints, after: Ints) -> Floats:
    """P(s' | s, a) of each step."""
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
