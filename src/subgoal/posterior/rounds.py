"""Rounds of sweeps over all chains, each short enough to look up between them."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.protocol import Chain, Sampler, Stretch
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.memory import refuse_growth
from subgoal.posterior.posterior import Settings
from subgoal.runtime.checks import Bools
from subgoal.runtime.executor import run_all
from subgoal.runtime.interrupt import leave_to_parent

ROUND_SECONDS = {"threading": 0.4}
OTHER_ROUND_SECONDS = 4.0
ROUND_DRAWS = 2**20
"""At most so many kept assignments (draws × N) of one chain in a round."""


class Rounds:
    """Advances all chains together; how long a round is does not change the draws."""

    def __init__(
        self,
        likelihood: LogLikelihood,
        sampler: Sampler,
        settings: Settings,
        *,
        workers: int,
        backend: str,
        budget: float,
    ) -> None:
        self._likelihood, self._sampler, self._settings = likelihood, sampler, settings
        self._workers, self._backend, self._budget = workers, backend, budget
        fixed = settings.concentration
        self._concentration = fixed if isinstance(fixed, float) else 1.0
        self._target = ROUND_SECONDS.get(backend, OTHER_ROUND_SECONDS)
        self._most = settings.thin * max(1, ROUND_DRAWS // likelihood.n_observations)
        self._length = 1

    def done(self, records: Sequence[ChainRecord]) -> int:
        """Sweeps done over all chains."""
        return sum(record.sweeps for record in records)

    def advance(self, records: list[ChainRecord]) -> bool:
        """One round; False when there is nothing left to do. A round that fails leaves the records as they were."""
        first = records[0].sweeps
        length = min(self._length, self._settings.sweeps - first)
        if length <= 0:
            return False
        keep = self._kept(first, length)
        begin = time.monotonic()
        jobs = [
            (self._sampler, Chain(self._likelihood, self._concentration, r.generator, r.state), keep) for r in records
        ]
        answers = run_all(advance_chain, jobs, workers=self._workers, backend=self._backend)
        for record, (stretch, generator) in zip(records, answers, strict=True):
            record.generator = generator
            record.add(stretch, stretch.log_joint[keep])
        active = max(int(stretch.n_active[-1]) for stretch, _ in answers)
        refuse_growth(active, self._likelihood.n_candidates, self._settings.chains, self._budget)
        pace = (time.monotonic() - begin) / length
        self._length = max(1, min(8 * length, int(self._target / max(pace, 1e-9)), self._most))
        return True

    def _kept(self, first: int, length: int) -> Bools:
        after = np.arange(first, first + length) - self._settings.warmup
        return np.asarray((after >= 0) & ((after + 1) % self._settings.thin == 0))


def advance_chain(sampler: Sampler, chain: Chain, keep: Bools) -> tuple[Stretch, np.random.Generator]:
    """One chain's part of a round; a worker process leaves Ctrl-C to the process that gave it the work."""
    leave_to_parent()
    return sampler(chain, keep), chain.generator
