"""Apprenticeship learning in worlds too large to be written down: inside an envelope around the demonstrations.

As in thesis 5.2.1, where Abbeel and Ng's method runs on real-time dynamic programming. Policies are compared in the
states that planning has met; the reward that comes of it says which others it should have met.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.single_reward import SingleReward
from subgoal.likelihood.pairs import checked_pairs
from subgoal.mdp.local_world import LocalWorld, local_world
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rtdp import MOST_STATES
from subgoal.mdp.planners.rtdp_reward import RewardBounds, rtdp_reward
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, Ints, frozen, real_array, whole
from subgoal.runtime.errors import InputError

FeatureFunction = Callable[[Ints], Any]
"""``features(states (M,))`` gives (M, F)."""
ROUNDING = 1e-12


@dataclass(frozen=True, eq=False, repr=False)
class LocalReward:
    """What apprenticeship learning found in an envelope, and how much of the world that reward would need.

    Attributes
    ----------
    learned:
        The answer in ``mdp``.
    states:
        (S',) the states of the world that are those of ``mdp``, in its order.
    mdp:
        The envelope as a world of its own, in which episodes are over at the edge.
    bounds:
        Of the optimal values of the learned reward in the whole world, at the demonstrated states.
    rounds:
        Envelopes that were learned in.
    """

    learned: SingleReward
    states: Ints
    mdp: TabularMDP
    bounds: RewardBounds
    rounds: int

    def __repr__(self) -> str:
        return (
            f"LocalReward({self.learned!r} in {len(self.states)} states, {self.status.name}, ±{self.error_bound:.1g})"
        )

    @property
    def status(self) -> PlanStatus:
        """SOLVED where the bounds meet; BUDGET where the envelope had reached its largest size before."""
        return self.bounds.status

    @property
    def error_bound(self) -> float:
        """Half of what knowing the whole world could add to the value of a demonstrated state, at most."""
        return self.bounds.error_bound

    def policy_at(self, states: Any) -> Floats:
        """(M, A) the policy in states of the world. Raises ``InputError`` for one that is not among ``states``."""
        wanted = np.atleast_1d(np.asarray(states, np.int64))
        order = np.argsort(self.states, kind="stable")
        place = order[np.minimum(np.searchsorted(self.states, wanted, sorter=order), order.size - 1)]
        unmet = self.states[place] != wanted
        if unmet.any():
            i = int(np.argmax(unmet))
            raise InputError("states", where=f"index {i}", found=int(wanted[i]), wanted="a state of the envelope")
        return np.asarray(self.learned.policy[place])


def apprenticeship_in_envelope(
    demonstrations: Demonstrations,
    world: Any,
    features: FeatureFunction,
    *,
    support: Any = None,
    feature_bounds: Any = None,
    tolerance: float | None = None,
    most_states: int = MOST_STATES,
    most_rounds: int = 20,
    **settings: Any,
) -> LocalReward:
    """``apprenticeship`` in the states that its own reward makes worth knowing.

    The envelope begins as the demonstrated states and all that one action may lead to. In it, with episodes over at its
    edge, a reward is learned; ``rtdp_reward`` takes in what the optimal values of this reward at the demonstrated
    states hang on; and so again, until nothing is taken in. A policy that leaves the envelope is held to collect
    nothing more.

    Parameters
    ----------
    demonstrations, world:
        As in ``rtdp_subgoals``: any ``LocalWorld`` of discount below 1, such as an ``ImplicitGrid``.
    features:
        Φ as a function of an array of states.
    support:
        (K,) states outside which every feature is zero, such as the demonstrated states for their indicators.
    feature_bounds:
        Where there is no ``support``: (2, F) the least and the most that each feature can be anywhere.
    tolerance, most_states:
        As in ``rtdp_reward``.
    most_rounds:
        Envelopes to learn in, at most.
    settings:
        As in ``apprenticeship``.

    Raises
    ------
    InputError
        Neither ``support`` nor ``feature_bounds``, or both; features of another shape, outside their bounds, or not
        zero outside their support; what ``apprenticeship`` and ``rtdp_reward`` refuse.
    """
    seen, rounds = local_world(world), whole("most_rounds", most_rounds)
    states, actions = checked_pairs(demonstrations, seen)
    final = seen.check("demonstrations.final_states", demonstrations.final_states)
    told = _Features(seen, features, support, feature_bounds)
    roots = np.unique(np.concatenate([states, final]))
    envelope = Envelope(seen)
    envelope.expand(envelope.meet(roots))
    envelope.expand(np.flatnonzero(~envelope.inside))
    done = 0
    for _ in range(rounds):
        done, inside, known, mdp = done + 1, envelope.n_inside, envelope.states.copy(), envelope.sub_world()
        shown = Demonstrations(
            envelope.places(states), actions, demonstrations.offset, final_states=envelope.places(final)
        )
        learned = apprenticeship(shown, mdp, told(known), **settings)
        reward, least, most = told.reward(learned)
        bounds = rtdp_reward(
            seen, reward, states=roots, least=least, most=most, support=told.support, tolerance=tolerance,
            most_states=most_states, envelope=envelope,
        )  # fmt: skip
        if envelope.n_inside == inside:
            break
    return LocalReward(learned, frozen(known), mdp, bounds, done)


class _Features:
    """Features that are checked whenever they are asked for, and bounds of rewards that are linear in them."""

    def __init__(self, world: LocalWorld, function: FeatureFunction, support: Any, bounds: Any) -> None:
        if not callable(function):
            raise InputError("features", found=type(function).__name__, wanted="a function of an array of states")
        if (support is None) == (bounds is None):
            found = "neither" if support is None else "both"
            raise InputError("support, feature_bounds", found=found, wanted="one of them")
        self.function, self.n_features = function, 0
        self.support: Any = None if support is None else np.unique(world.check("support", support))
        self.limits: Any = None
        if bounds is not None:
            self.limits = real_array("feature_bounds", bounds, ndim=2)
            if len(self.limits) != 2 or not (self.limits[0] <= self.limits[1]).all():
                found = f"shape {self.limits.shape}" if len(self.limits) != 2 else "a least above its most"
                raise InputError("feature_bounds", found=found, wanted="(2, F), the least and the most of each")
            self.n_features = self.limits.shape[1]

    def __call__(self, states: Ints) -> Floats:
        """(M, F)."""
        table = real_array("features", self.function(states.copy()), ndim=2)
        self.n_features = self.n_features or table.shape[1]
        if table.shape != (states.size, self.n_features):
            raise InputError("features", found=f"shape {table.shape}", wanted=f"{(states.size, self.n_features)}")
        if self.limits is None:
            wrong = (table != 0) & ~np.isin(states, self.support)[:, None]
        else:
            wrong = ~((table >= self.limits[0]) & (table <= self.limits[1]))
        if wrong.any():
            i, f = np.argwhere(wrong)[0].tolist()
            wanted = "0 outside the support" if self.limits is None else "a number within feature_bounds"
            raise InputError(f"feature {f}", where=f"state {states[i]}", found=table[i, f], wanted=wanted)
        return table

    def reward(self, learned: SingleReward) -> tuple[Callable[[Ints], Floats], float, float]:
        """R = Φw as a function, and its bounds."""
        weights = np.asarray(learned.weights)
        if self.limits is None:
            least, most = (float(end(self(self.support) @ weights, initial=0.0)) for end in (np.min, np.max))
        else:
            ends = self.limits * weights
            least, most = float(ends.min(axis=0).sum()), float(ends.max(axis=0).sum())
        slack = ROUNDING * max(abs(least), abs(most))
        return lambda states: self(states) @ weights, least - slack, most + slack
