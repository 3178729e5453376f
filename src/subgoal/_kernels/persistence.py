"""Loops for subgoals that persist: forward filter, backward draw, sums over runs. Arrays named as written are state.

A step keeps the subgoal of the step before with probability ``keep``, or ``keep_there`` where the state is at that
subgoal, and otherwise redraws it from the shared weights; the first step of a trajectory always draws it. The
transition is a multiple of the identity plus rank one, so that a step costs O(G). Which observation is at which
candidate comes as sparse rows: ``there[there_from[i]:there_from[i + 1]]``.
"""

from __future__ import annotations

from math import exp, log

import numpy as np
from numba import njit

from subgoal._kernels.draws import choose


@njit(cache=True, nogil=True)
def total_of(values):
    """Sum of a row, in four strands."""
    a = b = c = d = 0.0
    whole = values.size - values.size % 4
    for g in range(0, whole, 4):
        a += values[g]
        b += values[g + 1]
        c += values[g + 2]
        d += values[g + 3]
    for g in range(whole, values.size):
        a += values[g]
    return (a + b) + (c + d)


@njit(cache=True, nogil=True)
def leaving(before, at, keep, keep_there):
    """Probability that a subgoal with law ``before`` (G,), which sums to one, is left; ``at`` are those arrived at."""
    chance = 1.0 - keep
    if keep_there != keep:
        for g in at:
            chance += (keep - keep_there) * before[g]
    return max(chance, 0.0)


@njit(cache=True, nogil=True)
def advance(before, at, weights, keep, keep_there, out):
    """Write ``out`` (G,): the law of the next subgoal before its action is seen."""
    chance = leaving(before, at, keep, keep_there)
    for g in range(out.size):
        out[g] = keep * before[g] + chance * weights[g]
    if keep_there != keep:
        for g in at:
            out[g] = keep_there * before[g] + chance * weights[g]


@njit(cache=True, nogil=True)
def filter_rows(start, relative, first, there_from, there, weights, keep, keep_there, entering, out, log_total):
    """Write ``out`` (B, G), p(θ_i | actions up to i) for i = start + r, and ``log_total`` (B,), log p(a_i | before).

    ``relative`` (B, G) is L_ig / Σ_g p_g L_ig, and the totals are relative to the same; ``entering`` (G,) is the law
    of the row before, ``first`` (N,) marks the first rows of trajectories. This is the forward pass of a hidden Markov
    model with transition ρ·I + (1 − ρ)·1wᵀ.
    """
    for r in range(relative.shape[0]):
        i = start + r
        if first[i]:
            for g in range(weights.size):
                out[r, g] = weights[g]
        else:
            at = there[there_from[i] : there_from[i + 1]]
            advance(entering if r == 0 else out[r - 1], at, weights, keep, keep_there, out[r])
        for g in range(weights.size):
            out[r, g] *= relative[r, g]
        total = total_of(out[r])
        log_total[r] = log(total)
        for g in range(weights.size):
            out[r, g] /= total


@njit(cache=True, nogil=True)
def draw_rows(start, filtered, first, there_from, there, weights, keep, keep_there, theta, redrawn, work, generator):
    """Backward draw of θ for rows start + B − 1 down to start, and of whether row i + 1 redrew; writes both.

    ``filtered`` (B, G) is what ``filter_rows`` wrote. The rows after these must have been drawn.
    """
    for r in range(filtered.shape[0] - 1, -1, -1):
        i = start + r
        law = filtered[r]
        if i + 1 == theta.size or first[i + 1]:
            theta[i] = choose(law, law.size, generator)
        else:
            following = theta[i + 1]
            at = there[there_from[i + 1] : there_from[i + 2]]
            stay = keep
            for g in at:
                if g == following:
                    stay = keep_there
            work[0] = stay * law[following]
            work[1] = leaving(law, at, keep, keep_there) * weights[following]
            if choose(work, 2, generator) == 0:
                redrawn[i + 1] = False
                theta[i] = following
            else:
                redrawn[i + 1] = True
                for g in range(law.size):
                    work[g] = (1.0 - keep) * law[g]
                for g in at:
                    work[g] = (1.0 - keep_there) * law[g]
                theta[i] = choose(work, law.size, generator)
        if first[i]:
            redrawn[i] = True


@njit(cache=True, nogil=True)
def add_to_runs(start, tile, run, there_from, there, first, redrawn, log_kept, log_left, sums):
    """Add to ``sums`` (R, G) the log likelihood of each run of one subgoal, were it each candidate; ``run`` (N,).

    ``log_kept`` and ``log_left`` are what arriving adds to the log probability of keeping and of leaving, over that
    elsewhere, which is the same for all candidates and left out.
    """
    for r in range(tile.shape[0]):
        i = start + r
        row = sums[run[i]]
        for g in range(tile.shape[1]):
            row[g] += tile[r, g]
        if first[i] or (log_kept == 0.0 and log_left == 0.0):
            continue
        if redrawn[i]:
            before = sums[run[i - 1]]
            for g in there[there_from[i] : there_from[i + 1]]:
                before[g] += log_left
        else:
            for g in there[there_from[i] : there_from[i + 1]]:
                row[g] += log_kept


@njit(cache=True, nogil=True)
def count_steps(theta, redrawn, first, there_from, there, counts):
    """Write ``counts`` (2, 2): steps that kept (0) or redrew (1), away from (0) or at (1) the subgoal before them."""
    counts[:] = 0
    for i in range(theta.size):
        if first[i]:
            continue
        at = 0
        for g in there[there_from[i] : there_from[i + 1]]:
            if g == theta[i - 1]:
                at = 1
        counts[1 if redrawn[i] else 0, at] += 1


@njit(cache=True, nogil=True)
def count_repeats(theta, first, there_from, there, repeats):
    """Write ``repeats`` (2, G): steps at which θ stays g, away from (0) or at (1) g; returns how many change, of each.

    Whether a step that stays kept its subgoal or redrew the same one is not asked.
    """
    repeats[:] = 0
    changes_away = 0
    changes_there = 0
    for i in range(theta.size):
        if first[i]:
            continue
        at = 0
        for g in there[there_from[i] : there_from[i + 1]]:
            if g == theta[i - 1]:
                at = 1
        if theta[i] == theta[i - 1]:
            repeats[at, theta[i]] += 1
        elif at == 1:
            changes_there += 1
        else:
            changes_away += 1
    return changes_away, changes_there


@njit(cache=True, nogil=True)
def normalise_runs(sums, log_prior, out):
    """Write ``out`` (R, G): exp(sums) relative to its mean under the prior."""
    for r in range(sums.shape[0]):
        peak = -np.inf
        for g in range(log_prior.size):
            peak = max(peak, sums[r, g] + log_prior[g])
        for g in range(log_prior.size):
            below = sums[r, g] - peak
            out[r, g] = exp(below) if below > -700.0 else 0.0
        total = 0.0
        for g in range(log_prior.size):
            total += exp(log_prior[g]) * out[r, g]
        for g in range(log_prior.size):
            out[r, g] /= total
