"""Counts of candidates and the prior of an assignment (arrays named in the docstring are written)."""

from __future__ import annotations

from math import lgamma

from numba import njit


@njit(cache=True, nogil=True)
def recount(theta, counts, active, place):
    """Write counts (G,), the list of active candidates and its inverse ``place`` (−1: inactive); returns K."""
    counts[:] = 0
    for i in range(theta.size):
        counts[theta[i]] += 1
    k = 0
    for g in range(counts.size):
        place[g] = -1
        if counts[g] > 0:
            active[k] = g
            place[g] = k
            k += 1
    return k


@njit(cache=True, nogil=True)
def log_assignment_prior(counts, prior, concentration):
    """log p(θ): Dirichlet-multinomial of the counts (G,) with weights ηp_g."""
    n = 0
    value = lgamma(concentration)
    for g in range(counts.size):
        if counts[g] > 0:
            mass = concentration * prior[g]
            value += lgamma(counts[g] + mass) - lgamma(mass)
            n += counts[g]
    return value - lgamma(n + concentration)
