"""The Chinese restaurant process as exact functions: no sampler, no approximation.

Symbols, here and in the thesis: η (``concentration``) above zero, N customers, K occupied tables, n_j customers
at table j. All probabilities are natural logarithms with every constant kept.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.special import gammaln

from subgoal.runtime.checks import Floats, Ints, positive, real_array, whole
from subgoal.runtime.errors import InputError


def log_eppf(block_sizes: Any, concentration: float) -> float:
    """Log prior probability of one partition, given the sizes of its blocks.

    log P = K log η + log Γ(η) − log Γ(N + η) + Σ_j log Γ(n_j): the chain rule over (2.8) of the thesis. It
    replaces (4.5), which multiplies full conditionals (Pitman 1995, exchangeable partition probability function).

    Parameters
    ----------
    block_sizes:
        (K,) whole numbers of at least 1; empty for the partition of nothing.
    concentration:
        η above 0.
    """
    eta = positive("concentration", concentration)
    sizes = real_array("block_sizes", block_sizes, ndim=1)
    bad = ~(sizes >= 1) | (sizes != np.floor(sizes))
    if bad.any():
        where = int(np.argmax(bad))
        raise InputError(
            "block_sizes", where=f"index {where}", found=sizes[where], wanted="a whole number of at least 1"
        )
    return float(sizes.size * np.log(eta) + gammaln(sizes).sum() - _log_rising([eta], [sizes.sum()]))


def expected_clusters(n: int, concentration: float) -> float:
    """Prior mean of the number of occupied tables: Σ_{i=1..n} η/(η + i − 1)."""
    return float(_chances_of_new(n, concentration).sum())


def variance_clusters(n: int, concentration: float) -> float:
    """Prior variance of the number of occupied tables: Σ p_i (1 − p_i), p_i = η/(η + i − 1)."""
    chance = _chances_of_new(n, concentration)
    return float((chance * (1.0 - chance)).sum())


def _chances_of_new(n: int, concentration: float) -> Floats:
    """(n,) probability that customer i opens a table; independent over i."""
    eta = positive("concentration", concentration)
    return eta / (eta + np.arange(whole("n", n, least=0), dtype=np.float64))


def draw_partition(n: int, concentration: float, generator: np.random.Generator) -> Ints:
    """One partition from the prior: (n,) table labels, numbered from 0 in order of opening ((2.8))."""
    eta = positive("concentration", concentration)
    labels = np.zeros(whole("n", n, least=0), dtype=np.int64)
    tables = 0
    # Sitting beside a uniformly chosen earlier customer is sitting at a table with probability n_j / (i + η).
    for customer, place in enumerate(generator.random(labels.size) * (eta + np.arange(labels.size))):
        if place < customer:
            labels[customer] = labels[int(place)]
        else:
            labels[customer] = tables
            tables += 1
    return labels


def log_dirichlet_multinomial(counts: Any, concentration: float, prior: Any) -> float:
    """Log probability of one sequence of dishes with these counts, under a finite base measure.

    log p(θ) = log Γ(η) − log Γ(N + η) + Σ_g [log Γ(n_g + ηp_g) − log Γ(ηp_g)], the sum over used g: the Chinese
    restaurant with base P = Σ_g p_g δ_g, summed over all its seatings (Ferguson 1973).

    Parameters
    ----------
    counts:
        (G,) observations of each candidate, whole numbers of at least 0.
    concentration:
        η above 0.
    prior:
        (G,) probabilities p_g that sum to 1 within 1e-8.

    Returns
    -------
    The log probability; −inf when a candidate of probability 0 is used.
    """
    eta = positive("concentration", concentration)
    used = real_array("counts", counts, ndim=1)
    base = _probabilities(prior, used.size)
    bad = ~(used >= 0) | (used != np.floor(used))
    if bad.any():
        where = int(np.argmax(bad))
        raise InputError("counts", where=f"index {where}", found=used[where], wanted="a whole number of at least 0")
    seen = used > 0
    mass = eta * base[seen]
    if (mass == 0).any():
        return -np.inf
    return _log_rising(mass, used[seen]) - _log_rising([eta], [used.sum()])


def _log_rising(start: Any, length: Any) -> float:
    """Σ_k log Γ(start_k + length_k) − log Γ(start_k), term by term: the two log Γ cancel badly for large start."""
    steps = np.asarray(length, dtype=np.int64)
    first = np.repeat(np.cumsum(steps) - steps, steps)
    return float(np.log(np.repeat(np.asarray(start, np.float64), steps) + (np.arange(first.size) - first)).sum())


def _probabilities(prior: Any, size: int) -> Floats:
    base = real_array("prior", prior, ndim=1)
    if base.size != size:
        raise InputError("prior", found=f"{base.size} entries", wanted=f"{size}, one for each entry of counts")
    if not (base >= 0).all():
        where = int(np.argmax(base < 0))
        raise InputError("prior", where=f"index {where}", found=base[where], wanted="a probability")
    if not abs(base.sum() - 1.0) <= 1e-8:
        raise InputError("prior", found=f"a sum of {base.sum():.10g}", wanted="1 within 1e-8")
    return base
