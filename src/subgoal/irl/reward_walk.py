"""One chain of PolicyWalk: its posterior, its proposals and where it has come."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from subgoal._kernels import policy_walk as loops
from subgoal._kernels.rank_updates import ROUNDS, Base, World, look_ahead
from subgoal.irl.single_reward import Shown, observed
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, positive, real_array
from subgoal.runtime.errors import BudgetError, InputError, PlanningError

READINGS = {
    "product": loops.PRODUCT,
    "constant sequences": loops.CONSTANT_SEQUENCES,
    "unnormalised": loops.UNNORMALISED,
}
"""Of thesis (3.3): the product over observations; as printed, where only sequences of one action count as possible;
and exp(αΣQ) of Ramachandran & Amir (2007), which is no likelihood because its normaliser depends on the reward."""
LARGEST_INVERSE = 2**31
"""Bytes that one chain may hold."""


class Prior(Protocol):
    """Law of each coordinate of the reward, independent of the others."""

    @property
    def start(self) -> float:
        """Where chains begin: the mode."""

    def log_density(self, values: Floats) -> Floats:
        """Complete log densities, −inf outside the support."""


@dataclass(frozen=True, eq=False)
class RewardLaw:
    """Posterior over rewards R = Φw on a lattice of step δ, and how coordinates are proposed.

    Attributes
    ----------
    mdp, pairs, features:
        The world, what was demonstrated, and Φ (S, F).
    prior:
        Of each w_f.
    confidence, step, reading:
        α of (3.2), δ, and a key of ``READINGS``.
    relevance:
        (F,) how often each coordinate is proposed, up to a constant.
    """

    mdp: TabularMDP
    pairs: Shown
    features: Floats
    prior: Prior
    confidence: float
    step: float
    reading: str
    relevance: Floats

    def __post_init__(self) -> None:
        positive("confidence", self.confidence, zero=True)
        positive("step", self.step)
        if self.reading not in READINGS:
            raise InputError("likelihood", found=repr(self.reading), wanted=", ".join(map(repr, READINGS)))
        if self.mdp.discount == 1:
            raise InputError("discount", found=1.0, wanted="below 1, for values to be those of an inverse")
        weights = real_array("relevance", self.relevance, ndim=1)
        if weights.shape != self.features.shape[1:] or not ((weights >= 0).all() and weights.sum() > 0):
            wanted = f"{self.features.shape[1]} numbers of at least 0, one of them above"
            raise InputError("relevance", found=f"{weights.size} numbers from {weights.min():g}", wanted=wanted)
        object.__setattr__(self, "relevance", weights)
        if not self._log_prior(1)[1] > -np.inf:
            raise InputError("prior", found=f"no density at its start {self.prior.start}", wanted="some")
        if self.reading == "constant sequences" and not self.mdp.available[self.pairs.states].all():
            wanted = "worlds in which every action is legal at every observed state"
            raise InputError("likelihood", found="'constant sequences' with illegal actions", wanted=wanted)
        needed = 8.0 * self.mdp.n_states * (self.mdp.n_states + (self.features.shape[1] if self.linear else 0))
        if needed > LARGEST_INVERSE:
            raise BudgetError("the inverse of I − γP", needed=needed, budget=LARGEST_INVERSE, hint="fewer states")

    @property
    def linear(self) -> bool:
        """Whether rewards are combinations of features, and not one of their own for each state."""
        return self.features.shape[0] != self.features.shape[1] or not np.array_equal(
            self.features, np.eye(len(self.features))
        )

    @cached_property
    def world(self) -> World:
        """As the loops take it."""
        mdp = self.mdp
        successor = np.asarray(mdp.successor, np.int64)
        return World(np.array(mdp.offset), successor, np.array(mdp.probability), np.array(mdp.available), mdp.discount)

    @cached_property
    def counts(self) -> loops.Pairs:
        """Observations by state and action."""
        table = observed(self.mdp.available.shape, self.pairs)
        states = np.flatnonzero(table.sum(axis=1))
        return loops.Pairs(states, np.ascontiguousarray(table[states]))

    def _log_prior(self, reach: int) -> Floats:
        values = self.prior.start + self.step * np.arange(-reach, reach + 1, dtype=np.float64)
        return np.ascontiguousarray(self.prior.log_density(values), np.float64)

    def reaching(self, reach: int) -> loops.Law:
        """For the loops, with the prior of ``reach`` lattice points to both sides."""
        return loops.Law(
            np.ascontiguousarray(self.features.T), np.array(self.relevance), self._log_prior(reach), self.prior.start,
            self.step, self.confidence, READINGS[self.reading],
        )  # fmt: skip


@dataclass(frozen=True)
class Steps:
    """What a run of steps left: points (kept, F), values (kept, S), and (T,) log likelihood, log joint, accepted."""

    points: Any
    values: Floats
    log_likelihood: Floats
    log_joint: Floats
    accepted: Bools


class RewardChain:
    """A chain between runs of steps. How its steps are cut into runs does not change them."""

    def __init__(self, law: RewardLaw, generator: np.random.Generator, point: Any = None) -> None:
        self.law, self.generator = law, generator
        n_weights = law.features.shape[1]
        point = np.zeros(n_weights, np.int64) if point is None else np.array(point, np.int64)
        reward = law.features @ (law.prior.start + law.step * point)
        plan = policy_iteration(law.mdp, reward, allow_unconverged=True)
        columns = loops.inverse_of(law.world, plan.policy)
        responses = np.ascontiguousarray(law.features.T @ columns) if law.linear else columns
        self.base = Base(plan.policy.copy(), columns, responses)
        prior = law.reaching(int(np.abs(point).max(initial=0)) + 1).log_prior
        value = reward @ columns
        ahead = np.empty(law.mdp.available.shape)
        look_ahead(law.world, value, ahead)
        fit = loops.log_likelihood(law.counts, reward, ahead, law.confidence, READINGS[law.reading])
        numbers = np.array([fit, prior[point + prior.size // 2].sum(), 0.0])
        self.walk = loops.Walk(point, reward, plan.policy.copy(), value, value.copy(), numbers)
        self.solutions = 1

    def advance(self, heat: Floats, keep: Bools) -> Steps:
        """``len(heat)`` steps at these inverse temperatures, of which those that ``keep`` marks are recorded.

        Raises ``PlanningError`` where the policies of a reward go round in a circle.
        """
        law, n_steps, kept = self.law, len(heat), int(keep.sum())
        reach = int(np.abs(self.walk.point).max()) + n_steps + 1
        made = Steps(
            np.empty((kept, law.features.shape[1]), np.int64), np.empty((kept, law.mdp.n_states)), np.empty(n_steps),
            np.empty(n_steps), np.zeros(n_steps, bool),
        )  # fmt: skip
        rounds = loops.steps(
            law.world, law.counts, law.reaching(reach), self.walk, self.base, law.linear, heat, keep, made.points,
            made.values, made.log_likelihood, made.log_joint, made.accepted, self.generator,
        )  # fmt: skip
        if rounds == ROUNDS:
            raise PlanningError(f"policy iteration did not end in {ROUNDS} rounds. Try: a smaller discount or step")
        self.solutions += n_steps
        return made

    @property
    def error_bound(self) -> float:
        """No value where the chain is now is further than this from the optimal one, rounding of this bound aside."""
        ahead = np.empty(self.law.mdp.available.shape)
        look_ahead(self.law.world, self.walk.value, ahead)
        best = np.where(self.law.mdp.terminal, 0.0, ahead.max(axis=1))
        residual = np.abs(self.walk.reward + best - self.walk.value).max()
        return float(residual / (1 - self.law.mdp.discount))
