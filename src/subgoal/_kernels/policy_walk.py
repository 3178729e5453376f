"""Loops of PolicyWalk over rewards on a lattice, with optimal values kept exact by low-rank corrections.

One coordinate of the reward moves by a step at a time, so the optimal values move by a column of an inverse and by a
few switches of the greedy policy. Arrays named as written are state.
"""

from __future__ import annotations

from math import exp, log
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from subgoal._kernels.draws import choose
from subgoal._kernels.rank_updates import differing, optimise, rebase

PRODUCT, CONSTANT_SEQUENCES, UNNORMALISED = 0, 1, 2
"""Readings of thesis (3.3)."""
LARGEST_RANK = 6
"""States in which the policy differs from the base before it becomes the base."""
FRESH_EVERY = 200
"""Changes of base after which the inverse is computed anew, against drift."""


class Pairs(NamedTuple):
    """What was demonstrated: (U,) states, and (U, A) how often each action was taken there."""

    state: NDArray[np.int64]
    taken: NDArray[np.float64]


class Law(NamedTuple):
    """The posterior and the proposals.

    Attributes
    ----------
    features, relevance:
        (F, S) rows Φ_f, and (F,) weights by which a coordinate is proposed.
    log_prior, start:
        (2L + 1,) log density of a coordinate at the points −L, ..., L of its lattice, and its value at point 0.
    step, confidence, reading:
        δ, α, and which reading of (3.3) the likelihood is.
    """

    features: NDArray[np.float64]
    relevance: NDArray[np.float64]
    log_prior: NDArray[np.float64]
    start: float
    step: float
    confidence: float
    reading: int


class Walk(NamedTuple):
    """State of a chain.

    Attributes
    ----------
    point:
        (F,) lattice point of each coordinate: it is start + point·step.
    reward, policy, value, base_value:
        (S,) the reward Σ_f w_f Φ_f, its optimal policy and value, and the value of the base policy.
    numbers:
        (3,) log likelihood, log prior, and how often the base changed since the inverse was computed.
    """

    point: NDArray[np.int64]
    reward: NDArray[np.float64]
    policy: NDArray[np.int64]
    value: NDArray[np.float64]
    base_value: NDArray[np.float64]
    numbers: NDArray[np.float64]


@njit(cache=True, nogil=True)
def log_likelihood(pairs, reward, ahead, confidence, reading):
    """log p(actions | states) from ``ahead`` (S, A) = Q − R: by one of the readings of (3.3)."""
    total, n_actions = 0.0, ahead.shape[1]
    whole = np.zeros(n_actions)
    for u in range(pairs.state.size):
        s = pairs.state[u]
        peak, seen = -np.inf, 0.0
        for a in range(n_actions):
            peak = max(peak, ahead[s, a])
            seen += pairs.taken[u, a]
        sum_of = 0.0
        for a in range(n_actions):
            if pairs.taken[u, a] > 0.0:
                total += confidence * pairs.taken[u, a] * ahead[s, a]
            sum_of += exp(confidence * (ahead[s, a] - peak))
            whole[a] += seen * ahead[s, a]
        if reading == PRODUCT:
            total -= seen * (confidence * peak + log(sum_of))
        elif reading == UNNORMALISED:
            total += confidence * seen * reward[s]
    if reading == CONSTANT_SEQUENCES:
        peak = whole.max()
        total -= confidence * peak + log(np.exp(confidence * (whole - peak)).sum())
    return total


@njit(cache=True, nogil=True)
def inverse_of(world, policy):
    """(S, S) the transpose of (I − γP)⁻¹ for a policy."""
    n_states, n_actions = world.available.shape
    system = np.eye(n_states)
    for s in range(n_states):
        if policy[s] < 0:
            continue
        row = s * n_actions + policy[s]
        for e in range(world.offset[row], world.offset[row + 1]):
            system[s, world.successor[e]] -= world.discount * world.probability[e]
    return np.ascontiguousarray(np.linalg.inv(system).T)


@njit(cache=True, nogil=True)
def settle(world, base, law, walk, rows, linear):
    """Make the policy of the walk the base where it has gone too far from it, and add its sums up anew."""
    k = differing(walk.policy, base.policy, rows)
    if k <= LARGEST_RANK:
        return
    rebase(world, base, walk.policy, rows, k, linear)
    walk.numbers[2] += 1.0
    if walk.numbers[2] >= FRESH_EVERY:
        walk.numbers[2] = 0.0
        base.columns[:] = inverse_of(world, base.policy)
        if linear:
            base.responses[:] = law.features @ base.columns
    walk.reward[:] = (law.start + law.step * walk.point) @ law.features
    walk.base_value[:] = walk.reward @ base.columns


@njit(cache=True, nogil=True)
def steps(world, pairs, law, walk, base, linear, heat, keep, points, values, log_lik, log_joint, accepted, generator):
    """``len(heat)`` steps, accepted with min(1, ratio^heat); writes the walk, the base and the records.

    ``points`` (kept, F) and ``values`` (kept, S) are written at the steps that ``keep`` marks; ``log_lik``,
    ``log_joint`` and ``accepted`` (T,) at all. Returns the most rounds that an optimisation took, ``ROUNDS`` where one
    did not end.
    """
    n_states, n_actions = world.available.shape
    rows, ahead = np.empty(n_states, np.int64), np.empty((n_states, n_actions))
    policy, value, base_value = np.empty(n_states, np.int64), np.empty(n_states), np.empty(n_states)
    reward, work, most, row = np.empty(n_states), np.empty(2), 0, 0
    middle = law.log_prior.size // 2
    for t in range(heat.size):
        f = choose(law.relevance, law.relevance.size, generator)
        work[:] = 0.5
        move = law.step * (1 - 2 * choose(work, 2, generator))
        there = walk.point[f] + (1 if move > 0.0 else -1)
        gain = law.log_prior[middle + there] - law.log_prior[middle + walk.point[f]]
        if gain > -np.inf:
            for s in range(n_states):
                base_value[s] = walk.base_value[s] + move * base.responses[f, s]
                reward[s] = walk.reward[s] + move * law.features[f, s]
            policy[:] = walk.policy
            most = max(most, optimise(world, base, base_value, policy, rows, value, ahead))
            likelihood = log_likelihood(pairs, reward, ahead, law.confidence, law.reading)
            work[0] = exp(min(0.0, heat[t] * (likelihood - walk.numbers[0] + gain)))
            work[1] = 1.0 - work[0]
            accepted[t] = choose(work, 2, generator) == 0
            if accepted[t]:
                walk.point[f] = there
                walk.reward[:], walk.policy[:], walk.value[:], walk.base_value[:] = reward, policy, value, base_value
                walk.numbers[0], walk.numbers[1] = likelihood, walk.numbers[1] + gain
                settle(world, base, law, walk, rows, linear)
        log_lik[t], log_joint[t] = walk.numbers[0], walk.numbers[0] + walk.numbers[1]
        if keep[t]:
            points[row], values[row] = walk.point, walk.value
            row += 1
    return most
