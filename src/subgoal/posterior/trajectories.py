"""How probable each trajectory is under each draw, with its subgoals summed out."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.likelihood.noise import NoiseLevels, OneConfidence, OwnConfidence
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.learning import Noise
from subgoal.posterior.laws import draw_laws, run
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints

TOGETHER = 64
"""Draws that are filtered at a time where all have the same noise."""


def trajectory_log_likelihood(posterior: Posterior, rows: Ints, *, seed: int = 0, weighted: bool = True) -> Floats:
    """(S, D) log p(actions of trajectory d | their states, draw s), nats, for some draws of chains × draws.

    The subgoals of the trajectory are summed out, by forward filtering; what a draw has are the shared weights or rows
    of transitions, drawn given its counts, how long subgoals persist, the concentration, and its own noise. Given
    these, trajectories are independent, so that this is the factor by which trajectory d enters the posterior.
    ``weighted`` raises likelihoods to the weights that the observations of the posterior have; then it is that factor,
    and no probability.

    Raises ``InputError`` for groups (a trajectory then is not independent of the others of its group given what is
    shared), for a posterior without its likelihood, and for ``StickyHMM`` without assignments.
    """
    out = np.empty((rows.size, posterior.demonstrations.n_trajectories))
    for part, table in _tables(posterior, rows, weighted):
        laws = draw_laws(posterior, rows[part], seed)
        totals = np.empty((laws.n_draws, table.n_observations))
        for start, _, log_total in run(laws, table):
            totals[:, start : start + log_total.shape[1]] = log_total
        out[part] = np.add.reduceat(totals, table.offset[:-1], axis=1)
    return out


def is_weighted(posterior: Posterior) -> bool:
    """Whether observations count for more or less than one each."""
    weight = None if posterior.likelihood is None else posterior.likelihood.weight
    return weight is not None and bool((np.asarray(weight) != 1).any())


def _tables(posterior: Posterior, rows: Ints, weighted: bool) -> Iterator[tuple[slice, LogLikelihood]]:
    """Blocks of draws, each with the table at its noise."""
    likelihood = posterior.known_likelihood
    if not weighted:
        likelihood = replace(likelihood, weight=None)
    noise = _noise(posterior, likelihood)
    if noise is None:
        for first in range(0, rows.size, TOGETHER):
            yield slice(first, min(first + TOGETHER, rows.size)), likelihood
        return
    drawn = posterior.parameters[noise.name].reshape(posterior.log_joint.size, -1)
    for k, row in enumerate(rows.tolist()):
        table: Any = noise.table(drawn[row])
        yield slice(k, k + 1), table


def _noise(posterior: Posterior, likelihood: LogLikelihood) -> Noise | None:
    """What of the noise was learned, bound to the table."""
    specs: list[Any] = [OneConfidence(), OwnConfidence()]
    if isinstance(likelihood.confidence, Levels):
        specs.append(NoiseLevels(tuple((likelihood.confidence.confidences / likelihood.source.unit).tolist())))
    for spec in specs:
        noise: Noise = spec.of(likelihood)
        if noise.name in posterior.parameters:
            return noise
    return None
