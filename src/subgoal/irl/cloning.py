"""Behavioural cloning: what was done in each state, counted; neither a reward nor planning."""

from __future__ import annotations

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.single_reward import SingleReward, observed, shown
from subgoal.mdp.tabular import TabularMDP
from subgoal.partition.outcome import Outcome
from subgoal.runtime.checks import Floats, Ints, frozen, positive

REFERENCE = "posterior mean of a Dirichlet law in each state"


def behaviour_cloning(demonstrations: Demonstrations, mdp: TabularMDP, *, prior: float = 1.0) -> SingleReward:
    """The policy π(a | s) = (n(s, a) + c) / Σ_b (n(s, b) + c), b over the legal actions of s, n being how often.

    It is the posterior mean where the actions of each state have a Dirichlet law with parameter c = ``prior`` each, and
    the predictive probability of the next action shown there. In states that were never shown it is uniform: what a
    method that learns a reward has to beat.

    Raises ``InputError`` for what ``shown`` refuses, and for a prior that is not above zero. Single pairs will do.
    """
    pairs = shown(demonstrations, mdp)
    counts = observed(mdp.available.shape, pairs) + positive("prior", prior) * mdp.available
    policy = counts / np.where(mdp.terminal, 1.0, counts.sum(axis=1))[:, None]
    missed = int((~mdp.terminal).sum()) - np.unique(pairs.states).size
    note = f"{missed} of {mdp.n_states} states were never shown: their policy is uniform"
    return SingleReward(
        method="behavioural cloning", reference=REFERENCE, policy=frozen(policy), reward=None, weights=None,
        outcome=Outcome.CONVERGED, iterations=0, solutions=0, notes=(note,) if missed else (),
    )  # fmt: skip


def counted(learned: Demonstrations, asked: Demonstrations, *, shape: tuple[int, int], order: int = 2) -> Floats:
    """(N, A) how often each action was taken in ``learned`` where each of the N pairs of ``asked`` stands.

    With ``order`` 1 that is its state, with 2 the state before, or the start of a trajectory, and its state: the counts
    of a Markov chain of that order. ``shape`` is (S, A). Only states of ``asked`` are looked at.
    """
    context, place = np.unique(contexts(learned, shape[0], order), return_inverse=True)
    counts = np.zeros((context.size, shape[1]))
    np.add.at(counts, (place, np.asarray(learned.actions)), 1.0)
    wanted = contexts(asked, shape[0], order)
    at = np.minimum(np.searchsorted(context, wanted), context.size - 1)
    return np.where((context[at] == wanted)[:, None], counts[at], 0.0)


def contexts(demonstrations: Demonstrations, n_states: int, order: int = 2) -> Ints:
    """(N,) number of the state, or with ``order`` 2 of the pair of the state before, S at a start, and the state."""
    states = np.asarray(demonstrations.states)
    if order == 1:
        return states
    before = np.append(n_states, states[:-1])
    before[demonstrations.offset[:-1]] = n_states
    return np.asarray(before * n_states + states)
