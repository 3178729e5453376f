"""Filtering: which subgoal is served now, given the actions so far; and how well each action was foretold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal._kernels.filters import add_weighted
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.again import same_likelihood
from subgoal.posterior.laws import draw_laws, run
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, Ints, whole

DRAWS = 100


@dataclass(frozen=True, eq=False)
class Filtering:
    """What was known at each observation of some demonstrations, from a posterior of others.

    Attributes
    ----------
    log_predictive:
        (M,) log p(a_t | states up to t, actions before t in the same trajectory, O), nats.
    probability:
        (M, G) p(candidate g is served at t | actions up to t, O); the rest to one is the background.
    """

    log_predictive: Floats
    probability: Floats

    @property
    def bits_per_decision(self) -> float:
        """Mean log₂ of the predictive probability (density, where actions are continuous)."""
        return float(self.log_predictive.mean() / np.log(2))


def filtering(posterior: Posterior, demonstrations: Demonstrations, *, draws: int = DRAWS, seed: int = 0) -> Filtering:
    """Filter ``demonstrations`` forward in time under a posterior of others, trajectory by trajectory.

    The exact predictive of the model, averaged over ``draws`` draws: weights, or rows of transitions, are drawn given
    the counts of each, and draws that foretold a trajectory so far better than others count for more in what follows.
    The noise is at its posterior mean, the scale of actions that of the posterior. Works for the exchangeable model,
    ``Persistent`` and ``StickyHMM``; only the past is used, so that this is also what can be said while a recording is
    still going on: ``OnlineFilter`` says the same one step at a time.

    Raises ``InputError`` for groups, for a posterior without its likelihood, and for demonstrations that do not fit.
    """
    table = same_likelihood(posterior.known_likelihood, demonstrations)
    laws = draw_laws(posterior, some_draws(posterior, draws), seed)
    first = np.zeros(table.n_observations, bool)
    first[table.offset[:-1]] = True
    so_far = np.zeros(laws.n_draws)
    predictive = np.empty(first.size)
    probability = np.zeros((first.size, posterior.candidates.n_candidates))
    for start, filtered, log_total in run(laws, table):
        block = slice(start, start + log_total.shape[1])
        predictive[block], so_far = averaged(so_far, first[block], filtered, log_total, probability[block])
    return Filtering(predictive, probability)


def some_draws(posterior: Posterior, draws: int) -> Ints:
    """At most ``draws`` rows of chains × draws, evenly spaced."""
    return np.unique(np.linspace(0, posterior.log_joint.size - 1, whole("draws", draws)).astype(int))


def averaged(
    so_far: Floats, first: Bools, filtered: Floats, log_total: Floats, probability: Floats
) -> tuple[Floats, Floats]:
    """Mean over draws, each weighted by how well it foretold the trajectory so far.

    Takes ``so_far`` (S,), log p(actions of the trajectory before the block) under each draw, and a block as
    ``laws.run`` gives it. Adds the mean laws to ``probability`` (B, G), which must be zero; returns the log predictive
    (B,) and ``so_far`` at the end of the block.
    """
    after = np.empty(log_total.shape)
    for r in range(first.size):
        so_far = log_total[:, r] if first[r] else so_far + log_total[:, r]
        after[:, r] = so_far
    before = after - log_total
    total = np.logaddexp.reduce(after, axis=0)
    add_weighted(filtered, np.exp(after - total), probability)
    return np.asarray(total - np.logaddexp.reduce(before, axis=0)), so_far
