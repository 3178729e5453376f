"""What a demonstrator and a policy collect of each feature, discounted: what the margin methods compare.

All of it is per step of discounted time, (1 − γ) Σ_t γ^t φ(s_t), so that numbers are of the size of the features
whatever the discount. Features are scaled to a range of one; where none of the states of a world ends an episode their
origin is of no account, as everybody's visits sum to one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.single_reward import Shown, check_features, shown, told, undetermined_directions
from subgoal.mdp.planners.flow import expected_visits
from subgoal.mdp.planners.iteration import action_values, policy_iteration
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, frozen
from subgoal.runtime.errors import InputError

Tail = Literal["held", "none"]
"""What happens after a demonstration that breaks off: it stays where it ended for ever, or collects nothing."""


@dataclass(frozen=True, eq=False)
class Demonstrator:
    """A demonstrator's discounted visits, and the world and features in which policies are compared with them.

    Attributes
    ----------
    pairs:
        What was shown.
    scale:
        (F,) range of each feature as given.
    features:
        (S, F) Φ, of range one.
    start:
        (S,) share of the demonstrations that start in each state.
    visits:
        (S,) (1 − γ) Σ_t γ^t 1[s_t = s], the mean over the demonstrations.
    undetermined, notes:
        As in ``SingleReward``.
    """

    mdp: TabularMDP
    pairs: Shown
    scale: Floats
    features: Floats
    start: Floats
    visits: Floats
    undetermined: Floats
    notes: tuple[str, ...]

    @classmethod
    def of(cls, demonstrations: Demonstrations, mdp: TabularMDP, features: Any, tail: Tail) -> Demonstrator:
        """Checked. Raises ``InputError`` as ``shown`` and for unordered pairs, discount 1 and an unknown tail."""
        pairs, table = shown(demonstrations, mdp), check_features(features, mdp)
        if tail not in ("held", "none"):
            raise InputError("tail", found=repr(tail), wanted="'held' or 'none'")
        if not pairs.ordered:
            hint = "Demonstrations.from_arrays(states, actions, offset), or bayesian_irl, which takes single pairs"
            wanted = "trajectories, as visits over time count"
            raise InputError("demonstrations", found="unordered pairs", wanted=wanted, hint=hint)
        if mdp.discount == 1:
            raise InputError("discount", found=1.0, wanted="below 1: visits are discounted here")
        scale = np.ptp(table, axis=0)
        scale = np.where(scale > 0, scale, np.maximum(np.abs(table).max(axis=0), np.finfo(float).tiny))
        free = undetermined_directions(table, mdp)
        start = np.bincount(pairs.starts, minlength=mdp.n_states) / pairs.n_trajectories
        visits, broken = _visits(pairs, mdp, tail)
        return cls(mdp, pairs, scale, table / scale, start, visits, free, told(free) + broken)

    def difference(self, visits: Floats) -> Floats:
        """(F,) how much more of each feature the demonstrator collects than whoever makes these visits (S,)."""
        return np.asarray((self.visits - visits) @ self.features)

    def policy_visits(self, policy: Floats) -> Floats:
        """(S,) (1 − γ) Σ_t γ^t P(s_t = s) of a policy, started as the demonstrations were; by one linear solve."""
        return (1 - self.mdp.discount) * expected_visits(self.mdp, policy, self.start)

    def reward(self, weights: Floats) -> Floats:
        """(S,) R = Φw."""
        return np.asarray(self.features @ weights)

    def given(self, weights: Floats) -> Floats:
        """(F,) weights of the features as they were given."""
        return np.asarray(frozen(weights / self.scale))


def optimal_policy(mdp: TabularMDP, reward: Floats) -> Floats:
    """(S, A) of a reward (S,), ties split evenly."""
    plan = policy_iteration(mdp, reward, allow_unconverged=True)
    return uniform_policy(greedy_actions(action_values(mdp, plan.value, reward), 2 * plan.error_bound))


def _visits(pairs: Shown, mdp: TabularMDP, tail: Tail) -> tuple[Floats, tuple[str, ...]]:
    """(S,) the mean visits of the demonstrations, and a note on those that break off."""
    lengths = np.diff(pairs.offset)
    step = np.arange(pairs.states.size) - np.repeat(pairs.offset[:-1], lengths)
    left, over = mdp.discount**lengths, mdp.terminal[pairs.final]
    visits = np.bincount(pairs.states, (1 - mdp.discount) * mdp.discount**step, minlength=mdp.n_states)
    after = np.where(over, (1 - mdp.discount) * left, left if tail == "held" else 0.0)
    visits += np.bincount(pairs.final, after, minlength=mdp.n_states)
    return frozen(visits / pairs.n_trajectories), _broken(left[~over], pairs.n_trajectories, tail)


def _broken(left: Floats, count: int, tail: Tail) -> tuple[str, ...]:
    if not left.size:
        return ()
    what = (
        "to stay where they ended" if tail == "held" else "to collect nothing, which makes every feature look shunned"
    )
    return (f"{left.size} of {count} demonstrations break off before {left.mean():.0%} of discounted time, "
            f"in which they are taken {what}",)  # fmt: skip
