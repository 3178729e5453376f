"""Loops of the sampler ``StickyHMM``: rows of transitions, forward filter, backward draw, tables, whole candidates.

Row j of a matrix of transitions is the law of the next subgoal after candidate j; row G is that of first steps. Most
entries of a row are below e^−600 and are taken as that: a row is ``FLOOR`` everywhere, and what it has above as a
packed list, so that a step of the filter costs what is above the floor. Arrays named as written are state.
"""

from __future__ import annotations

from math import exp, lgamma, log

import numpy as np
from numba import njit

from subgoal._kernels.draws import choose
from subgoal._kernels.persistence import total_of

LOWEST = -600.0
FLOOR = 2.6503965530043e-261
"""e^−600: logarithms of weights stop there, as everywhere in the samplers."""
UNHEARD = 1e-280
"""Laws below this times any weight are lost in the last binary digit of ``FLOOR``."""
SPARE = 10.0
"""No draw of Gamma(a), a ≤ 2, is above e^10 in the arithmetic of a generator."""


@njit(cache=True, nogil=True)
def draw_log_row(shape, out, generator):
    """Write ``out`` (G,): the logarithm of a draw from Dirichlet(shape), cut at ``LOWEST``, for shapes however small.

    Gamma(a) is Gamma(a + 1)·U^{1/a}. Gamma(a + 1) is drawn only where the entry can end above the cut.
    """
    top = 0
    for g in range(shape.size):
        out[g] = -generator.standard_exponential() / shape[g] if shape[g] > 0.0 else -np.inf
        if out[g] > out[top]:
            top = g
    out[top] += log(generator.standard_gamma(shape[top] + 1.0))
    peak, least = out[top], out[top] + LOWEST - SPARE
    for g in range(shape.size):
        if g == top:
            continue
        if shape[g] <= 1.0 and out[g] < least:
            out[g] = -np.inf
        else:
            out[g] += log(generator.standard_gamma(shape[g] + 1.0))
            peak = max(peak, out[g])
    total = 0.0
    for g in range(shape.size):
        out[g] -= peak
        if out[g] > LOWEST:
            total += exp(out[g])
    total = log(total)
    for g in range(shape.size):
        out[g] = max(out[g] - total, LOWEST)


@njit(cache=True, nogil=True)
def pack_row(j, log_row, size, index, above, onto):
    """Put one row of logarithms (G,) into ``size`` (G,), ``index`` (G, G), ``above`` (G, G) and ``onto`` (G, G).

    ``above[j, :size[j]]`` is what entries ``index[j, :size[j]]`` have above the floor; ``onto[g, j]`` is the
    probability of g after j.
    """
    count = 0
    for g in range(log_row.size):
        onto[g, j] = FLOOR
        if log_row[g] > LOWEST:
            index[j, count] = g
            above[j, count] = exp(log_row[g])
            onto[g, j] = FLOOR + above[j, count]
            count += 1
    size[j] = count


@njit(cache=True, nogil=True)
def draw_transitions(counts, weights, mass, sticky, begin, size, index, above, onto, work, generator):
    """Draw every row from Dirichlet(mass·weights + sticky·own + counts); writes ``begin`` (G,) and what is packed.

    ``counts`` (G + 1, G) are steps from row to column, ``weights`` (G,) sum to one. First steps are not sticky.
    """
    g_count = weights.size
    log_row = np.empty(g_count)
    for j in range(g_count + 1):
        for g in range(g_count):
            work[g] = mass * weights[g] + counts[j, g]
        if j < g_count:
            work[j] += sticky
        draw_log_row(work[:g_count], log_row, generator)
        if j < g_count:
            pack_row(j, log_row, size, index, above, onto)
        else:
            for g in range(g_count):
                begin[g] = exp(log_row[g])


@njit(cache=True, nogil=True)
def filter_rows(start, relative, first, begin, size, index, above, entering, out):
    """Write ``out`` (B, G): p(θ_i | actions up to i) for i = start + r; returns Σ log p(a_i | before), relative.

    ``relative`` (B, G) is L_ig / Σ_g p_g L_ig, ``entering`` (G,) the law of the row before, ``first`` (N,) marks the
    first rows of trajectories.
    """
    value = 0.0
    for r in range(relative.shape[0]):
        if first[start + r]:
            for g in range(begin.size):
                out[r, g] = begin[g]
        else:
            before = entering if r == 0 else out[r - 1]
            for g in range(begin.size):
                out[r, g] = FLOOR
            for j in range(begin.size):
                law = before[j]
                if law > UNHEARD:
                    for e in range(size[j]):
                        out[r, index[j, e]] += law * above[j, e]
        for g in range(begin.size):
            out[r, g] *= relative[r, g]
        total = total_of(out[r])
        value += log(total)
        for g in range(begin.size):
            out[r, g] /= total
    return value


@njit(cache=True, nogil=True)
def draw_path(start, filtered, first, onto, theta, work, generator):
    """Backward draw of ``theta`` for rows start + B − 1 down to start; the rows after these must have been drawn."""
    for r in range(filtered.shape[0] - 1, -1, -1):
        i = start + r
        law = filtered[r]
        if i + 1 == theta.size or first[i + 1]:
            theta[i] = choose(law, law.size, generator)
        else:
            into = onto[theta[i + 1]]
            for j in range(law.size):
                work[j] = law[j] * into[j]
            theta[i] = choose(work, law.size, generator)


@njit(cache=True, nogil=True)
def count_transitions(theta, first, counts):
    """Write ``counts`` (G + 1, G): steps from candidate (row G: from nowhere, first steps) to candidate."""
    counts[:] = 0
    for i in range(theta.size):
        counts[counts.shape[1] if first[i] else theta[i - 1], theta[i]] += 1


@njit(cache=True, nogil=True)
def draw_tables(counts, weights, mass, sticky, tables, own, shared, work, generator):
    """Seat the steps of each row and column, and say which tables of staying are owed to stickiness.

    Writes ``tables`` (G + 1, G), tables of a Chinese restaurant of concentration mass·weights (+ sticky where a row
    meets its own column); ``own`` (G,), those of them whose candidate was set by stickiness and not drawn; and
    ``shared`` (G,), how often each candidate was drawn from the shared weights (Fox et al. 2011, overrides).
    """
    shared[:] = 0
    own[:] = 0
    for j in range(counts.shape[0]):
        for g in range(weights.size):
            tables[j, g] = 0
            base = mass * weights[g]
            extra = sticky if j == g else 0.0
            for i in range(counts[j, g]):
                new = True
                if i > 0:
                    work[0], work[1] = float(i), base + extra
                    new = choose(work, 2, generator) == 1
                if new:
                    tables[j, g] += 1
                    if extra > 0.0:
                        work[0], work[1] = extra, base
                        if choose(work, 2, generator) == 0:
                            own[g] += 1
                            continue
                    shared[g] += 1


@njit(cache=True, nogil=True)
def by_first_appearance(theta, place, cluster, label):
    """Number the candidates in use by when they first appear; writes ``cluster`` (N,), ``label`` (G,); returns K."""
    place[:] = -1
    k = 0
    for i in range(theta.size):
        if place[theta[i]] < 0:
            place[theta[i]] = k
            label[k] = theta[i]
            k += 1
        cluster[i] = place[theta[i]]
    return k


@njit(cache=True, nogil=True)
def add_rows(start, tile, cluster, sums):
    """Add the rows of ``tile`` (B, G) to those of their cluster in ``sums`` (K, G)."""
    for r in range(tile.shape[0]):
        row = sums[cluster[start + r]]
        for g in range(tile.shape[1]):
            row[g] += tile[r, g]


@njit(cache=True, nogil=True)
def move_clusters(sums, prior, concentration, label, shared, work, generator):
    """Each candidate in use moves as a whole to one that is not, or stays; writes ``label`` (K,) and ``shared`` (G,).

    Rows and shared weights are integrated out: a candidate drawn m times from the shared weights goes to g with weight
    Γ(ηp_g + m) / Γ(ηp_g)·Π L_ig. The order is that of first appearance, which no move changes.
    """
    for k in range(sums.shape[0]):
        drawn = shared[label[k]]
        shared[label[k]] = 0
        peak = -np.inf
        for g in range(prior.size):
            mass = concentration * prior[g]
            work[g] = -np.inf
            if shared[g] == 0 and mass > 0.0:
                work[g] = sums[k, g] + lgamma(mass + drawn) - lgamma(mass)
            peak = max(peak, work[g])
        for g in range(prior.size):
            work[g] = exp(work[g] - peak)
        label[k] = choose(work, prior.size, generator)
        shared[label[k]] = drawn
