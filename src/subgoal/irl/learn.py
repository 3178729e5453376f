"""Everything learned, nothing set by hand: subgoals that persist, their noise, and what the recording is worth."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

from subgoal.answers.evidence import evidence
from subgoal.likelihood.fixed_table import FixedTable
from subgoal.likelihood.noise import NoiseLevels, NoiseSpec
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.persistence import Persistent
from subgoal.partition.priors import Gamma
from subgoal.partition.protocol import Sampler
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Noted, Progress, Silent

ROUNDS = 8
CLOSE = 0.1
"""Weights within 10 % are the same."""
UNSETTLED = f"what an observation is worth has not settled in {ROUNDS} rounds; the weight of the last one is used"
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
    thin: int = 5,
    seed: int = 0,
    workers: int | None = None,
    **sampling: Any,
) -> Posterior:
    """Sample with every number learned: how long subgoals persist, how many there are, how exact actions are.

    Observations in quick succession share their errors, so that each counts as ``evidence(posterior).weight`` of an
    independent one. Short preliminary runs find the weight that agrees with the errors it leaves, from 1 downwards; it
    is kept in ``Posterior.likelihood.weight``. A likelihood that has weights already keeps them. If the weight has not
    settled after eight rounds, the last one is used, ``Posterior.weight_settled`` is False, and a
    ``ConvergenceWarning`` says so.

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
    What ``sample`` raises; ``StoppedError`` also for Ctrl-C in a preliminary run; ``InputError`` for a plain table,
    whose noise is not known.
    """
    table = isinstance(likelihood, LogLikelihood) and isinstance(likelihood.source, FixedTable)
    if table and (confidence is not None or likelihood.weight is None):
        raise InputError("likelihood", found="a plain table, of which only these numbers are known",
                         wanted="one whose noise and errors can be learned, as of subgoal.action_comparison",
                         hint="subgoal.sample(likelihood, model=subgoal.models.Persistent(), "
                              "concentration=subgoal.models.Gamma())")  # fmt: skip
    learned: dict[str, Any] = {"model": model, "concentration": concentration, "confidence": confidence}
    common: dict[str, Any] = {**learned, "seed": seed, "workers": workers}
    settled = None
    if likelihood.weight is None:
        weight, settled = _worth(likelihood, common, sampling.get("progress") or Silent())
        likelihood = likelihood.weighted(weight)
    made = sample(likelihood, **common, draws=draws, warmup=warmup, thin=thin, **sampling)
    if settled is False:
        warnings.warn(UNSETTLED, ConvergenceWarning, stacklevel=2)
    return replace(made, weight_settled=settled)


def _worth(likelihood: LogLikelihood, common: dict[str, Any], display: Progress) -> tuple[float, bool]:
    """The weight of an observation that agrees with the errors it leaves, found in short runs; whether it settled."""
    weight = 1.0
    with Interrupt() as interrupt:
        for round_ in range(1, ROUNDS + 1):
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ConvergenceWarning)
                noted = Noted(display, f"what an observation is worth, round {round_}")
                trial = sample(likelihood.weighted(weight), **common, **PRELIMINARY, progress=noted)
            if interrupt.requested:
                raise StoppedError("stopped while it was found what an observation is worth: there are no draws yet")
            before, weight = weight, evidence(trial).weight
            if abs(weight - before) <= CLOSE * before:
                return weight, True
    return weight, False
