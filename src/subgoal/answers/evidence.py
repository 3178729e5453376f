"""How many independent observations a recording is worth: the autocorrelation time of the errors of its actions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.likelihood.source import Assigned, Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, Ints, whole
from subgoal.runtime.errors import InputError

DRAWS = 40
"""Draws over which errors are averaged."""
SURE = 2.0
"""Correlations below so many of their standard errors are chance."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Serial correlation of the errors that a posterior leaves.

    Attributes
    ----------
    correlation:
        (K,) correlation of the scores of observations k steps apart in one trajectory, from k = 0.
    time:
        τ = 1 + 2·Σ correlation, in observations: so many in a row count as one.
    weight:
        1/τ, at most 1: the power to which likelihoods are raised.
    """

    correlation: Floats
    time: float
    weight: float


def evidence(posterior: Posterior, *, draws: int = DRAWS) -> Evidence:
    """Autocorrelation time of the scores ∂ log p(a_i | s_i, θ_i) / ∂(action asked for), over draws of θ.

    For a sum of dependent terms the likelihood is too sure by the factor by which the variance of its score exceeds
    that of independent terms, which is τ; raised to the power 1/τ it has the right information (the magnitude
    adjustment of composite likelihoods: Pauli, Racugno & Ventura 2011). The sum over lags ends before the first two
    neighbouring ones (Geyer 1992) that are together not above twice the error that they would have were all scores
    independent, whatever their sizes (Lobato, Nankervis & Savin 2001): of forty observations, chance alone would
    otherwise take half away.

    Raises ``InputError`` when the assignments were not kept, or the likelihood is a plain table.
    """
    likelihood = posterior.likelihood
    if posterior.assignments is None or likelihood is None:
        raise InputError("posterior", found="no assignments, or no likelihood", wanted="both",
                         hint="sample again with a larger memory_budget, or fewer draws")  # fmt: skip
    flat = posterior.assignments.reshape(-1, posterior.n_observations)
    chosen = flat[np.unique(np.linspace(0, len(flat) - 1, whole("draws", draws)).astype(int))]
    return autocorrelation(posterior.demonstrations.trajectory, [scores(likelihood, theta) for theta in chosen])


def autocorrelation(trajectory: Ints, parts: list[tuple[Floats, Bools]]) -> Evidence:
    """Of scores (N, k) in trajectories (N,), the rows of each in order, and of which (N,) there is one; several parts
    are averaged.
    """
    lags = _Lags(trajectory, parts)
    correlation, time = [1.0], 1.0
    for lag in range(1, lags.longest, 2):
        (first, error), (second, other) = lags.correlation(lag), lags.correlation(lag + 1)
        if not first + second > SURE * np.hypot(error, other):
            break
        correlation += [first, second]
        time += 2 * (first + second)
    return Evidence(np.array(correlation), time, min(1.0, 1.0 / time))


def scores(likelihood: LogLikelihood, theta: Ints) -> tuple[Floats, Bools]:
    """(N, k) scores, and (N,) which observations have one: those that serve a candidate and are asked for an action."""
    served = np.asarray(theta) >= 0
    told = likelihood.source.assigned(np.where(served, theta, 0))
    law = likelihood.confidence
    if isinstance(law, Levels):
        score = _of_levels(told, law)
    else:
        score = told.score(law if np.ndim(law) == 0 else np.asarray(law)[np.where(served, theta, 0)])
    spoken = served & (score != 0).any(axis=1)
    return np.where(spoken[:, None], score, 0.0), spoken


def _of_levels(told: Assigned, law: Levels) -> Floats:
    """Scores averaged over the level that each observation may have had."""
    log_weight = np.stack([told.log_density(alpha) for alpha in law.confidences.tolist()])
    with np.errstate(divide="ignore"):
        log_weight += np.log(law.shares)[:, None]
    weight = np.exp(log_weight - log_weight.max(axis=0))
    weight /= weight.sum(axis=0)
    parts = [w[:, None] * told.score(alpha) for w, alpha in zip(weight, law.confidences.tolist(), strict=True)]
    return np.asarray(sum(parts))


class _Lags:
    """Correlations of the scores of one trajectory, so many steps apart."""

    def __init__(self, trajectory: Ints, parts: list[tuple[Floats, Bools]]) -> None:
        self.trajectory, self.parts = trajectory, parts
        self.longest = int(np.bincount(trajectory).max())
        squares = [(score[spoken] ** 2).sum(axis=1).mean() for score, spoken in parts if spoken.any()]
        self.square = float(np.mean(squares)) if squares else 0.0

    def correlation(self, lag: int) -> tuple[float, float]:
        """Mean product of pairs that both have a score over the mean square, and its error were all independent."""
        if lag >= self.longest or not self.square > 0:
            return 0.0, 0.0
        together = self.trajectory[lag:] == self.trajectory[:-lag]
        product, count = np.zeros(together.size), 0
        for score, spoken in self.parts:
            both = together & spoken[lag:] & spoken[:-lag]
            product += (score[lag:] * score[:-lag]).sum(axis=1) * both
            count += int(both.sum())
        scale = count * self.square
        return (float(product.sum() / scale), float(np.linalg.norm(product) / scale)) if count else (0.0, 0.0)
