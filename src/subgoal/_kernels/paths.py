"""Sums over all trajectories of a given number of steps, in logs, and how often each state and pair is part of them.

A trajectory s_0 a_0 s_1 ... s_L weighs Π P(s_{t+1} | s_t, a_t) exp(Σ_t fade_t R(s_t)). Row s·A + a of the sparse table
is entries offset[row] to offset[row + 1]; terminal states have none, so that nothing goes through them before the end.
"""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit


@njit(cache=True, nogil=True, error_model="numpy")
def log_sums(offset, successor, log_chance, n_actions, reward, fade, out):
    """Write ``out`` (L + 1, S): log of the sum over what can follow from s at step t, the reward of s included.

    ``reward`` is (S,), ``fade`` (L + 1,); −inf where no trajectory has so many steps left.
    """
    steps, n_states = fade.size - 1, reward.size
    for state in range(n_states):
        out[steps, state] = fade[steps] * reward[state]
    for t in range(steps - 1, -1, -1):
        for state in range(n_states):
            first, last = offset[state * n_actions], offset[(state + 1) * n_actions]
            peak = -np.inf
            for k in range(first, last):
                ahead = log_chance[k] + out[t + 1, successor[k]]
                peak = ahead if ahead > peak else peak
            out[t, state] = -np.inf
            if peak > -np.inf:
                total = 0.0
                for k in range(first, last):
                    total += exp(log_chance[k] + out[t + 1, successor[k]] - peak)
                out[t, state] = fade[t] * reward[state] + peak + log(total)


@njit(cache=True, nogil=True, error_model="numpy")
def add_visits(offset, successor, log_chance, n_actions, reward, fade, sums, start, visits, pairs):
    """Add to ``visits`` (S,) Σ_t fade_t E[s_t = s], and to ``pairs`` (S, A) Σ_t E[s_t = s, a_t = a], of the model.

    ``start`` (S,) is how many trajectories begin where; ``sums`` is what ``log_sums`` wrote.
    """
    steps, n_states = fade.size - 1, reward.size
    here, after = start.copy(), np.empty(n_states)
    for t in range(steps):
        after[:] = 0.0
        for state in range(n_states):
            if here[state] > 0:
                visits[state] += fade[t] * here[state]
                base = sums[t, state] - fade[t] * reward[state]
                for action in range(n_actions):
                    row = state * n_actions + action
                    for k in range(offset[row], offset[row + 1]):
                        share = here[state] * exp(log_chance[k] + sums[t + 1, successor[k]] - base)
                        after[successor[k]] += share
                        pairs[state, action] += share
        here, after = after, here
    for state in range(n_states):
        visits[state] += fade[steps] * here[state]
