"""Weights β ~ Dirichlet(ηp) that several Dirichlet laws share: their density, and that of counts given them."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import gammaln, logsumexp

from subgoal.partition.priors import Gamma, slice_draw
from subgoal.runtime.checks import Floats, Ints, positive

WIDTH = 1.0
FARTHEST = 60.0


def log_shared(log_weights: Floats, used: Ints, prior: Floats, concentration: float) -> float:
    """Log density of the weights of the candidates in use, and of all others together.

    ``log_weights`` (G,) are log β, ``used`` the candidates in use. The density is that of the logarithms of the ratios
    of the weights, in which it is bounded however small ηp_g is: Γ(η) Π β^{ηp} / Γ(ηp), unused candidates as one.
    """
    others = np.setdiff1d(np.arange(prior.size), used)
    mass = list(concentration * prior[used])
    logs = list(log_weights[used])
    if others.size and prior[others].sum() > 0:
        mass.append(float(concentration * prior[others].sum()))
        logs.append(float(logsumexp(log_weights[others])))
    shape = np.array(mass)
    return math.lgamma(concentration) + float((shape * np.array(logs) - gammaln(shape)).sum())


def log_rows(counts: Ints, shape: Floats, totals: Floats) -> float:
    """Σ log p(sequence of row j), each of whose laws is Dirichlet and integrated out.

    ``counts`` and ``shape`` are those of all pairs of row and candidate that occur; ``totals`` (R, 2) the summed shape
    and the number of steps of each row.
    """
    inside = float((gammaln(counts + shape) - gammaln(shape)).sum())
    return inside - float((gammaln(totals.sum(axis=1)) - gammaln(totals[:, 0])).sum())


def mass_of(what: str, value: float | Gamma) -> float | Gamma:
    """A checked mass of Dirichlet laws: a number above zero, or its prior."""
    return value if isinstance(value, Gamma) else positive(what, value)


def draw_mass(mass: float, law: Gamma, tables: int, sizes: Ints, generator: np.random.Generator) -> float:
    """Concentration of restaurants with ``sizes`` (R,) customers at ``tables`` tables in all, by a slice on its log."""
    sizes = sizes[sizes > 0]

    def log_density(log_mass: float) -> float:
        if not -FARTHEST < log_mass < FARTHEST:
            return -math.inf
        value = math.exp(log_mass)
        inside = float((gammaln(value) - gammaln(value + sizes)).sum())
        return tables * log_mass + inside + law.log_density(value) + log_mass

    return math.exp(slice_draw(log_density, math.log(mass), WIDTH, generator))
