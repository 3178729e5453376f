"""What Bayesian inverse reinforcement learning found: draws of a reward, and what they say of policies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import softmax

from subgoal.irl.reward_walk import RewardLaw
from subgoal.irl.single_reward import SingleReward
from subgoal.mdp.planners.iteration import action_values
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.partition.outcome import Outcome
from subgoal.posterior.diagnostics import Diagnostic, Status
from subgoal.runtime.checks import Floats, positive
from subgoal.runtime.errors import InputError

REFERENCE = "Ramachandran & Amir 2007, Bayesian inverse reinforcement learning; Michini 2013, chapter 3"


@dataclass(frozen=True, eq=False, repr=False)
class RewardPosterior:
    """Draws of the reward given the demonstrations, C chains of K draws.

    Attributes
    ----------
    weights:
        (C, K, F) of the features; without features, the reward of each state.
    values:
        (C, K, S) optimal values V of each draw (2.2).
    log_likelihood, log_joint:
        (C, K), up to the constant that (3.3) leaves out where its reading is "unnormalised".
    acceptance:
        (C,) share of the proposals that were accepted, warm-up left out.
    diagnostics, status:
        Of log joint, log likelihood and each coordinate that was proposed: the gate of ``subgoal.sample``.
    law:
        Prior, likelihood and proposals: world, features, α, δ.
    seconds:
        Wall time of the chains.
    error_bound:
        Of the values at the last draw of each chain, the largest: how far low-rank updates have drifted.
    undetermined:
        (F, k) directions of the weights of which the demonstrations can say nothing: there the posterior is the prior.
    """

    weights: Floats
    values: Floats
    log_likelihood: Floats
    log_joint: Floats
    acceptance: Floats
    diagnostics: dict[str, Diagnostic]
    status: Status
    law: RewardLaw
    seconds: float
    error_bound: float
    undetermined: Floats

    def __repr__(self) -> str:
        chains, draws, count = self.weights.shape
        return f"RewardPosterior({chains} chains × {draws} draws of {count} weights, {self.status.name})"

    @cached_property
    def mean_weights(self) -> Floats:
        """(F,) posterior mean."""
        return np.asarray(self.weights.mean(axis=(0, 1)))

    @property
    def mean_reward(self) -> Floats:
        """(S,) posterior mean of R(s), which minimises the expected squared reward loss (3.4)."""
        return np.asarray(self.law.features @ self.mean_weights)

    def interval(self, level: float = 0.95) -> Floats:
        """(2, S) ends of the central interval of each R(s). Raises ``InputError`` for a level outside (0, 1)."""
        level = positive("level", level)
        if not level < 1:
            raise InputError("level", found=level, wanted="a number between 0 and 1")
        rewards = self.weights.reshape(-1, self.weights.shape[-1]) @ self.law.features.T
        return np.quantile(rewards, [(1 - level) / 2, (1 + level) / 2], axis=0)

    @cached_property
    def policy(self) -> Floats:
        """(S, A) the optimal policy of the posterior mean reward, which minimises the expected policy loss (3.5).

        Ties are split evenly.
        """
        return greedy_policy_of(self.law, self.mean_reward)

    @cached_property
    def predictive(self) -> Floats:
        """(S, A) p(a | s, demonstrations): the softmax (3.2) averaged over the draws. Zero in terminal states."""
        mdp, total = self.law.mdp, np.zeros(self.law.mdp.available.shape)
        acting, legal = ~mdp.terminal, mdp.available[~mdp.terminal]
        draws = self.values.reshape(-1, mdp.n_states)
        for value in draws:
            ahead = (mdp.discount * (mdp.matrix @ value)).reshape(total.shape)[acting]
            total[acting] += softmax(np.where(legal, self.law.confidence * ahead, -np.inf), axis=1)
        return np.asarray(total / len(draws))

    def point(self) -> SingleReward:
        """The posterior mean and its policy, in the form that all methods of one reward share."""
        outcome = {Status.CONVERGED: Outcome.CONVERGED, Status.INTERRUPTED: Outcome.INTERRUPTED}
        chains, draws, _ = self.weights.shape
        return SingleReward(
            method="Bayesian IRL, posterior mean", reference=REFERENCE, policy=self.policy, reward=self.mean_reward,
            weights=self.mean_weights, outcome=outcome.get(self.status, Outcome.OUT_OF_ITERATIONS),
            iterations=chains * draws, solutions=chains * draws, undetermined=self.undetermined,
        )  # fmt: skip


def greedy_policy_of(law: RewardLaw, reward: Floats) -> Floats:
    """(S, A) the optimal policy of a reward, ties split evenly."""
    plan = policy_iteration(law.mdp, reward, allow_unconverged=True)
    table = action_values(law.mdp, plan.value, reward)
    return uniform_policy(greedy_actions(table, 2 * plan.error_bound))
