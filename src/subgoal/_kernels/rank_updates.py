"""Optimal values of a reward that changes a little, by low-rank corrections of one inverse. Arrays are written.

Of a base policy b the matrix M = (I − γP_b)⁻¹ is held. A policy that differs from b in the states C has the matrix
I − γP_b + Σ_{c ∈ C} e_c u_cᵀ with u_c = γ(P_b(c) − P(c)), so that its values follow from those of b by a system of
|C| equations (Woodbury). What is added to a reward adds the same to the values, seen through M.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

ROUNDS = 1_000
"""Improvements of a policy after which something is wrong."""
ROUNDING = 64 * 2.0**-52
"""An action is better than another by more than this share of the largest value over 1 − γ."""
PATIENCE = 50
"""Rounds after which that share doubles with each, so that rounding cannot lead round in a circle."""


class World(NamedTuple):
    """A ``TabularMDP`` as the loops take it: entries ``offset[s·A + a]`` on are the successors of action a."""

    offset: NDArray[np.int64]
    successor: NDArray[np.int64]
    probability: NDArray[np.float64]
    available: NDArray[np.bool_]
    discount: float


class Base(NamedTuple):
    """What is held of the base policy; written when it changes.

    Attributes
    ----------
    policy:
        (S,) its actions, −1 in terminal states.
    columns:
        (S, S) row c is column c of M.
    responses:
        (F, S) row f is M times feature f; the same array as ``columns`` where each state has a reward of its own.
    """

    policy: NDArray[np.int64]
    columns: NDArray[np.float64]
    responses: NDArray[np.float64]


@njit(cache=True, nogil=True)
def look_ahead(world, value, ahead):
    """Write γ Σ P(s' | s, a) v(s') into ``ahead`` (S, A), −inf for illegal actions; returns the largest |v|."""
    offset, successor, probability, available, discount = world
    n_states, n_actions = ahead.shape
    largest = 0.0
    for s in range(n_states):
        largest = max(largest, abs(value[s]))
        for a in range(n_actions):
            if not available[s, a]:
                ahead[s, a] = -np.inf
                continue
            total = 0.0
            row = s * n_actions + a
            for e in range(offset[row], offset[row + 1]):
                total += probability[e] * value[successor[e]]
            ahead[s, a] = discount * total
    return largest


@njit(cache=True, nogil=True)
def improve(ahead, policy, slack):
    """Switch ``policy`` to the best action wherever it is better by more than ``slack``; returns how often."""
    switched = 0
    for s in range(policy.size):
        held = policy[s]
        if held < 0:
            continue
        best = held
        for a in range(ahead.shape[1]):
            if ahead[s, a] > ahead[s, best]:
                best = a
        if ahead[s, best] > ahead[s, held] + slack:
            policy[s] = best
            switched += 1
    return switched


@njit(cache=True, nogil=True)
def differing(policy, base_policy, rows):
    """List the states in which two policies differ in ``rows``; returns how many."""
    k = 0
    for s in range(policy.size):
        if policy[s] != base_policy[s]:
            rows[k] = s
            k += 1
    return k


@njit(cache=True, nogil=True)
def seen_through(world, base, policy, rows, k, vector):
    """(k,) u_c · v for each of the first k states of ``rows``."""
    offset, successor, probability, _, discount = world
    n_actions = world.available.shape[1]
    out = np.empty(k)
    for i in range(k):
        total = 0.0
        row = rows[i] * n_actions + base.policy[rows[i]]
        for e in range(offset[row], offset[row + 1]):
            total += probability[e] * vector[successor[e]]
        row = rows[i] * n_actions + policy[rows[i]]
        for e in range(offset[row], offset[row + 1]):
            total -= probability[e] * vector[successor[e]]
        out[i] = discount * total
    return out


@njit(cache=True, nogil=True)
def capacitance(world, base, policy, rows, k):
    """(k, k) I + UᵀM restricted to ``rows``: entry (i, j) is 1[i = j] + u_i · M[:, j]."""
    matrix = np.empty((k, k))
    for j in range(k):
        matrix[:, j] = seen_through(world, base, policy, rows, k, base.columns[rows[j]])
        matrix[j, j] += 1.0
    return matrix


@njit(cache=True, nogil=True)
def eliminate(matrix, right):
    """Solve ``matrix`` (k, k) x = ``right`` (k, m) by elimination with row pivots; both are written, x into right."""
    k, m = right.shape
    for p in range(k):
        best = p
        for i in range(p + 1, k):
            if abs(matrix[i, p]) > abs(matrix[best, p]):
                best = i
        if best != p:
            for j in range(k):
                matrix[p, j], matrix[best, j] = matrix[best, j], matrix[p, j]
            for j in range(m):
                right[p, j], right[best, j] = right[best, j], right[p, j]
        for i in range(p + 1, k):
            factor = matrix[i, p] / matrix[p, p]
            if factor == 0.0:
                continue
            for j in range(p + 1, k):
                matrix[i, j] -= factor * matrix[p, j]
            for j in range(m):
                right[i, j] -= factor * right[p, j]
    for p in range(k - 1, -1, -1):
        for j in range(m):
            right[p, j] /= matrix[p, p]
        for i in range(p):
            factor = matrix[i, p]
            for j in range(m):
                right[i, j] -= factor * right[p, j]


@njit(cache=True, nogil=True)
def evaluate(world, base, policy, rows, k, base_value, value):
    """Write the value of ``policy``, which differs from the base in k ``rows``, from that of the base."""
    value[:] = base_value
    if k == 0:
        return
    right = np.empty((k, 1))
    right[:, 0] = seen_through(world, base, policy, rows, k, base_value)
    eliminate(capacitance(world, base, policy, rows, k), right)
    for i in range(k):
        weight, column = right[i, 0], base.columns[rows[i]]
        for s in range(value.size):
            value[s] -= weight * column[s]


@njit(cache=True, nogil=True)
def optimise(world, base, base_value, policy, rows, value, ahead):
    """Policy iteration from ``policy``; writes it, its ``value`` and ``ahead``; returns the number of rounds.

    That is ``ROUNDS`` where it did not end.
    """
    for count in range(ROUNDS):
        evaluate(world, base, policy, rows, differing(policy, base.policy, rows), base_value, value)
        slack = ROUNDING * look_ahead(world, value, ahead) / (1.0 - world.discount)
        if improve(ahead, policy, slack * 2.0 ** max(0, count - PATIENCE)) == 0:
            return count + 1
    return ROUNDS


@njit(cache=True, nogil=True)
def rebase(world, base, policy, rows, k, linear):
    """Make ``policy``, which differs from the base in k ``rows``, the base: a correction of rank k of M.

    ``linear``: the responses are an array of their own.
    """
    left = np.empty((k, base.columns.shape[1]))
    for i in range(k):
        left[i] = base.columns[rows[i]]
    systems = capacitance(world, base, policy, rows, k)
    _correct(world, base, policy, rows, k, systems.copy(), left, base.columns)
    if linear:
        _correct(world, base, policy, rows, k, systems, left, base.responses)
    for i in range(k):
        base.policy[rows[i]] = policy[rows[i]]


@njit(cache=True, nogil=True)
def _correct(world, base, policy, rows, k, matrix, left, columns):
    """Take M[:, C] (I + UᵀM[:, C])⁻¹ Uᵀ X from X, the columns of which are rows of ``columns``."""
    right = np.empty((k, columns.shape[0]))
    for f in range(columns.shape[0]):
        right[:, f] = seen_through(world, base, policy, rows, k, columns[f])
    eliminate(matrix, right)
    for f in range(columns.shape[0]):
        for i in range(k):
            weight = right[i, f]
            for s in range(columns.shape[1]):
                columns[f, s] -= weight * left[i, s]
