"""Everything learned, nothing set by hand: subgoals that persist, their noise, and what the recording is worth."""

from __future__ import annotations

import warnings
from typing import Any

from subgoal.answers.evidence import evidence
from subgoal.likelihood.noise import NoiseLevels, NoiseSpec
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.persistence import Persistent
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample

ROUNDS = 8
CLOSE = 0.1
"""Weights within 10 % are the same."""
PRELIMINARY: dict[str, Any] = {"chains": 2, "draws": 60, "warmup": 200, "thin": 5}
PERSISTENT = Persistent()
CONCENTRATION = Gamma()
LEVELS = NoiseLevels()


def learn(
    likelihood: LogLikelihood,
    *,
    model: Sampler | None = PERSISTENT,
    concentration: float | Gamma = CONCENTRATION,
    confidence: NoiseSpec | None = LEVELS,
    draws: int = 1000,
    warmup: int = 500,
    thin: int = 3,
    seed: int = 0,
    workers: int | None = None,
    **sampling: Any,
) -> Posterior:
    """Sample with every number learned: how long subgoals persist, how many there are, how exact actions are.

    Observations in quick succession share their errors, so that each counts as ``evidence(posterior).weight`` of an
    independent one. Short preliminary runs find the weight that agrees with the errors it leaves, from 1 downwards; it
    is kept in ``Posterior.likelihood.weight``. A likelihood that has weights already keeps them.

    Parameters
    ----------
    likelihood:
        The N × G table; its own confidence is not used.
    model, concentration, confidence:
        As in ``sample``. By default ρ is uniform beforehand, η ~ Gamma(1, 1), and the shares of eight levels of
        confidence are uniform on their simplex.
    draws, warmup, thin, seed, workers, sampling:
        As in ``sample``.

    Raises
    ------
    What ``sample`` raises; ``InputError`` for a plain table, whose noise is not known.
    """
    learned: dict[str, Any] = {"model": model, "concentration": concentration, "confidence": confidence}
    weight = 1.0
    for _ in range(ROUNDS if likelihood.weight is None else 0):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            trial = sample(likelihood.weighted(weight), **learned, seed=seed, workers=workers, **PRELIMINARY)
        before, weight = weight, evidence(trial).weight
        if abs(weight - before) <= CLOSE * before:
            break
    weighted = likelihood if likelihood.weight is not None else likelihood.weighted(weight)
    length: dict[str, Any] = {"draws": draws, "warmup": warmup, "thin": thin}
    return sample(weighted, **learned, **length, seed=seed, workers=workers, **sampling)
