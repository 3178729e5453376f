"""Expected number of observations on each candidate, exactly, for more observations than can be enumerated.

The prior of an assignment hangs on its counts alone, so it is enough to sum the likelihood over the assignments of each
vector of counts, one observation after the other. No package code.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def expected_counts(log_table: np.ndarray, eta: float, prior: Sequence[float]) -> np.ndarray:
    """(G,) E[n_g | O] under θ ~ the urn with masses ηp_g and likelihoods exp(log_table[i, θ_i])."""
    n, g_count = log_table.shape
    peak = log_table.max(axis=1)
    sums = {(0,) * g_count: 1.0}
    for i in range(n):
        following: dict[tuple[int, ...], float] = {}
        for counts, value in sums.items():
            for g in range(g_count):
                more = (*counts[:g], counts[g] + 1, *counts[g + 1 :])
                following[more] = following.get(more, 0.0) + value * math.exp(log_table[i, g] - peak[i])
        sums = following
    log_weight = {}
    for counts, value in sums.items():
        urn = sum(math.lgamma(k + eta * p) - math.lgamma(eta * p) for k, p in zip(counts, prior, strict=True))
        log_weight[counts] = math.log(value) + urn if value > 0 else -math.inf
    top = max(log_weight.values())
    weight = {counts: math.exp(value - top) for counts, value in log_weight.items()}
    total = sum(weight.values())
    return np.sum([np.array(counts) * value for counts, value in weight.items()], axis=0) / total
