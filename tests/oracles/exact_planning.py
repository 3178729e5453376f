"""Planning, slowly and exactly: dense linear solves and exact fractions, sharing no code with the library."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np


def evaluate(table, reward, ending, policy, discount):
    """(S,) value of one action per state (−1: terminal) in a dense world (S, A, S) with rewards (S, A)."""
    states = len(table)
    matrix, known = np.eye(states), np.array(ending, float)
    for state in range(states):
        if policy[state] >= 0:
            matrix[state] -= discount * table[state, policy[state]]
            known[state] = reward[state, policy[state]]
    return np.linalg.solve(matrix, known)


def best_by_enumeration(table, reward, ending, discount):
    """(S,) the largest value in every state over all deterministic policies."""
    choices = [[a for a in range(table.shape[1]) if table[s, a].any()] or [-1] for s in range(len(table))]
    return np.max([evaluate(table, reward, ending, policy, discount) for policy in product(*choices)], axis=0)


def best_by_policy_iteration(table, reward, ending, discount):
    """(S,) optimal values; actions are changed for gains above 1e-12 of the size of the values only."""
    legal = table.any(axis=2)
    policy = np.where(legal.any(axis=1), legal.argmax(axis=1), -1)
    while True:
        value = evaluate(table, reward, ending, policy, discount)
        gains = np.where(legal, reward + discount * table @ value, -np.inf)
        best = gains.argmax(axis=1)
        now = np.arange(len(policy))
        better = (policy >= 0) & (gains[now, best] > gains[now, policy] + 1e-12 * (1 + abs(value).max()))
        if not better.any():
            return value
        policy = np.where(better, best, policy)


def exact_values(table, reward, ending, discount, policy):
    """(S,) fractions: the value of ``policy`` in exact arithmetic on the floats as they are; whether it is optimal."""
    states, actions = table.shape[:2]
    gamma = Fraction(discount)
    rows = []
    for s in range(states):
        row = [Fraction(int(s == t)) for t in range(states)]
        if policy[s] >= 0:
            row = [row[t] - gamma * Fraction(float(table[s, policy[s], t])) for t in range(states)]
        rows.append([*row, Fraction(float(reward[s, policy[s]] if policy[s] >= 0 else ending[s]))])
    for k in range(states):
        pivot = next(i for i in range(k, states) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(states):
            if i != k and rows[i][k]:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    value = [row[-1] for row in rows]
    optimal = True
    for s in range(states):
        for a in range(actions):
            if table[s, a].any():
                ahead = sum(Fraction(float(p)) * v for p, v in zip(table[s, a], value, strict=True))
                optimal &= Fraction(float(reward[s, a])) + gamma * ahead <= value[s]
    return value, optimal
