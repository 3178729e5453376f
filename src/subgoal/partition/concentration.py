"""How the concentration η of the Dirichlet process is learned."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import gammaln

from subgoal.partition.priors import Gamma, slice_draw
from subgoal.runtime.checks import Floats, Ints

WIDTH = 1.0


def log_counts(counts: Ints, prior: Floats, concentration: float) -> float:
    """log p(θ | η) of counts (G,): the Dirichlet-multinomial with weights ηp_g, sequence by sequence."""
    used = np.flatnonzero(counts)
    mass = concentration * prior[used]
    inside = float((gammaln(counts[used] + mass) - gammaln(mass)).sum())
    return math.lgamma(concentration) - math.lgamma(int(counts.sum()) + concentration) + inside


def draw_concentration(
    concentration: float, law: Gamma, counts: Ints, prior: Floats, generator: np.random.Generator
) -> float:
    """η given the counts (G,), by a slice on log η under the prior ``law``; the weights are integrated out."""

    def log_density(log_eta: float) -> float:
        if not -60 < log_eta < 60:
            return -math.inf
        eta = math.exp(log_eta)
        return log_counts(counts, prior, eta) + law.log_density(eta) + log_eta

    return math.exp(slice_draw(log_density, math.log(concentration), WIDTH, generator))
