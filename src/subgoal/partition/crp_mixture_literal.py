"""Algorithm 2 of the thesis as printed, under a name that says so: to be looked at, not to be used.

Three things are wrong with it. A new cluster's parameter is fitted to x_i and then weighted by its fit to x_i, which
counts x_i twice (right: a draw from the prior, or the weight η ∫ p(x_i|θ) dP(θ)). "P(θ|x)" is the maximum likelihood
fit, singular for one point. And the likelihood exp(−½ d²) lacks its normaliser: summed over a cluster at its own
fit it is −½ n d whatever the partition, so it cannot tell a good partition from a bad one.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.partition.crp_mixture import MixtureDraws, checked, reseat, run_chain
from subgoal.partition.crp_seating import Base, Uncollapsed, summed
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError


def literal_algorithm_2(
    points: Any,
    base: Base,
    *,
    concentration: float,
    sweeps: int,
    generator: np.random.Generator,
    start: Any = None,
) -> MixtureDraws:
    """Run Algorithm 2 as printed, with the likelihood that section 2.4 of the thesis describes. Wrong.

    ``base`` is used for ``log_joint`` alone. Other arguments and the result as in
    ``subgoal.partition.crp_mixture.collapsed_gibbs``.
    """
    x, label, eta = checked(points, start, concentration)
    printed = UnnormalisedGaussian(x)
    statistic = printed.statistics(x)

    def sweep(label: Ints, parameter: Floats) -> tuple[Ints, Floats]:
        fresh = printed.draw_given(statistic, generator)[:, None, :]
        label = reseat(Uncollapsed(x, printed, label, eta, parameter), fresh, generator, keeps_own=False)
        return label, printed.draw_given(summed(statistic, label), generator)

    return run_chain(x, base, label, eta, sweeps, printed.draw_given(summed(statistic, label), generator), sweep)


class UnnormalisedGaussian:
    """Thesis section 2.4 to the letter: maximum likelihood fits and exp(−½ d²). It has no prior and no marginal.

    A fit narrower than 1e-6 of the data's spread in some direction has no width there: points on it score 1 in
    that direction, all others 0.
    """

    narrow = 1e-6

    def __init__(self, points: Floats) -> None:
        self.centre = points.mean(axis=0)
        self.spread = max(float(np.abs(points - self.centre).max()), np.finfo(float).tiny)

    def statistics(self, points: Any) -> Floats:
        """(n, 1 + d + d²) rows (1, y, y yᵀ), y the point from the centre of the data."""
        y = points - self.centre
        return np.hstack([np.ones((len(y), 1)), y, (y[:, :, None] * y[:, None, :]).reshape(len(y), -1)])

    def log_marginal_of(self, totals: Floats) -> Floats:
        """Refused: the printed form has no prior to integrate over."""
        raise InputError("base", found="the printed form of Algorithm 2", wanted="a base with a proper prior")

    def draw_given(self, totals: Floats, generator: np.random.Generator) -> Floats:
        """(K, d + d²) maximum likelihood means and covariances: nothing is drawn."""
        d = self.centre.size
        mean = totals[:, 1 : 1 + d] / totals[:, :1]
        covariance = totals[:, 1 + d :] / totals[:, :1] - (mean[:, :, None] * mean[:, None, :]).reshape(-1, d * d)
        return np.hstack([self.centre + mean, covariance])

    def log_likelihood(self, points: Floats, parameters: Floats) -> Floats:
        """(n, K) −½ d²."""
        d, least = self.centre.size, self.narrow * self.spread
        width, axes = np.linalg.eigh(parameters[:, d:].reshape(-1, d, d))
        along = np.einsum("kba,nkb->nka", axes, points[:, None, :] - parameters[:, :d])
        flat = np.where(np.abs(along) <= least, 0.0, np.inf)
        narrow = width <= least**2
        distance: Floats = np.where(narrow, flat, along**2 / np.where(narrow, 1.0, width)).sum(axis=2)
        return -0.5 * distance
