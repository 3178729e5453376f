"""Soft planning, visits and maximum entropy, slowly: plain recursions and enumeration, sharing no code with subgoal.

Worlds are dense, P (S, A, S), with zero rows for illegal actions and in terminal states, whose value is their reward.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np


def soft_values(table, reward, discount, temperature, sweeps):
    """(S,) and (S, A): V and π after so many backups, state by state; ``reward`` (S, A), and (S,) for endings."""
    gains, ending = reward
    states, actions = table.shape[:2]
    legal = [[a for a in range(actions) if table[s, a].any()] for s in range(states)]
    value = [ending[s] if not legal[s] else 0.0 for s in range(states)]
    policy = np.zeros((states, actions))
    for _ in range(sweeps):
        after = list(value)
        for s in range(states):
            if legal[s]:
                q = {
                    a: gains[s, a] + discount * sum(table[s, a, t] * value[t] for t in range(states)) for a in legal[s]
                }
                top = max(q.values())
                total = sum(math.exp((q[a] - top) / temperature) for a in legal[s])
                after[s] = top + temperature * math.log(total)
                for a in legal[s]:
                    policy[s, a] = math.exp((q[a] - after[s]) / temperature)
        value = after
    return np.array(value), policy


def visits(table, policy, start, discount, steps):
    """(S,) Σ_t γ^t P(s_t = s) over so many steps, one step after the other."""
    here, total = np.array(start, float), np.zeros(len(start))
    for t in range(steps):
        total += discount**t * here
        after = np.zeros_like(here)
        for s, a in product(range(table.shape[0]), range(table.shape[1])):
            after += here[s] * policy[s, a] * table[s, a]
        here = after
    return total


def trajectories(table, start, steps):
    """Every (states (steps + 1,), actions (steps,), Π P) of exactly ``steps`` actions from ``start``."""
    if steps == 0:
        yield (start,), (), 1.0
        return
    for a, after in product(range(table.shape[1]), range(table.shape[0])):
        if table[start, a, after] > 0:
            for states, actions, chance in trajectories(table, after, steps - 1):
                yield (start, *states), (a, *actions), chance * table[start, a, after]


def trajectory_log_probability(table, reward, discount, states, actions, final):
    """log P of one trajectory among all of its length from its start; ``final`` None: summed over."""

    def weight(path, chance):
        return chance * math.exp(sum(discount**t * reward[s] for t, s in enumerate(path)))

    mine, total = 0.0, 0.0
    for path, acted, chance in trajectories(table, states[0], len(actions)):
        total += weight(path, chance)
        if path[:-1] == tuple(states) and acted == tuple(actions) and final in (None, path[-1]):
            mine += weight(path, chance)
    return math.log(mine / total)
