"""Slow and obvious: optimal values by value iteration, the readings of (3.3) by their definitions, PolicyWalk anew."""

from __future__ import annotations

import itertools

import numpy as np


def optimal_values(transition: np.ndarray, reward: np.ndarray, discount: float) -> np.ndarray:
    """V (S,) of V = R + γ max_a P_a V, by policy iteration with dense solves."""
    states = len(transition)
    policy = np.zeros(states, int)
    while True:
        value = np.linalg.solve(np.eye(states) - discount * transition[np.arange(states), policy], reward)
        ahead = transition @ value
        better = ahead.max(axis=1) > ahead[np.arange(states), policy] + 1e-12 * max(1.0, np.abs(value).max())
        if not better.any():
            return value
        policy = np.where(better, ahead.argmax(axis=1), policy)


def log_likelihood(transition, reward, discount, states, actions, confidence, reading) -> float:
    """log p(actions | states) as each reading defines it, constant sequences by listing them."""
    value = optimal_values(transition, reward, discount)
    table = reward[:, None] + discount * transition @ value
    chosen = confidence * table[states, actions].sum()
    if reading == "unnormalised":
        return float(chosen)
    if reading == "constant sequences":
        return float(chosen - np.log(np.exp(confidence * table[states].sum(axis=0)).sum()))
    return float(chosen - np.log(np.exp(confidence * table[states]).sum(axis=1)).sum())


def posterior(transition, discount, states, actions, confidence, reading, features, levels, log_prior) -> dict:
    """p(level of each coordinate | demonstrations) over all combinations."""
    law = {}
    for point in itertools.product(range(len(levels)), repeat=features.shape[1]):
        reward = features @ np.array([levels[k] for k in point])
        fit = log_likelihood(transition, reward, discount, states, actions, confidence, reading)
        law[point] = fit + sum(log_prior[k] for k in point)
    peak = max(law.values())
    total = sum(np.exp(value - peak) for value in law.values())
    return {point: float(np.exp(value - peak) / total) for point, value in law.items()}


def policy_walk(transition, discount, states, actions, confidence, step, relevance, log_density, count, generator):
    """PolicyWalk on R, every proposal solved anew; (count,) accepted, and the optimal values after each step."""
    reward, value = np.zeros(len(transition)), np.zeros(len(transition))
    fit = log_likelihood(transition, reward, discount, states, actions, confidence, "product")
    edges = np.cumsum(relevance)
    accepted, values = np.zeros(count, bool), np.zeros((count, len(transition)))
    for t in range(count):
        f = int(np.searchsorted(edges, generator.random() * edges[-1], side="right"))
        proposal = reward.copy()
        proposal[f] += step if generator.random() < 0.5 else -step
        solved = optimal_values(transition, proposal, discount)
        table = confidence * discount * transition @ solved
        table -= table.max(axis=1, keepdims=True)
        new = float((table[states, actions] - np.log(np.exp(table[states]).sum(axis=1))).sum())
        gain = log_density(proposal[f]) - log_density(reward[f])
        accepted[t] = generator.random() < np.exp(min(0.0, new - fit + gain))
        if accepted[t]:
            reward, value, fit = proposal, solved, new
        values[t] = value
    return accepted, values
