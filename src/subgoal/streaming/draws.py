"""From the chains of a stream to a ``Posterior``: of late draws, at once, or of new ones, with diagnostics."""

from __future__ import annotations

import time

import numpy as np
from scipy import sparse

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.posterior.assemble import assemble, count_draws
from subgoal.posterior.chains import ChainRecord, sparse_rows
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior, Settings
from subgoal.runtime.version import VERSION
from subgoal.streaming.chains import Chains


def settings_of(
    likelihood: LogLikelihood, concentration: float, chains: int, seed: int, *, draws: int, warmup: int, thin: int,
    data: str = "",
) -> Settings:  # fmt: skip
    """What decides the draws, but for how the data came."""
    return Settings(
        collapsed_blocks.__name__, concentration, float(np.asarray(likelihood.confidence)), chains, draws, warmup, thin,
        seed, likelihood.source.kind, data, VERSION,
    )  # fmt: skip


def of_late(likelihood: LogLikelihood, concentration: float, chains: Chains, seed: int) -> Posterior:
    """The latest draws of all chains; their log joint is not a number, nothing is said of convergence."""
    latest, g_count = chains.latest, likelihood.n_candidates
    count, held, n = latest.shape
    flat = latest.reshape(-1, n)
    counted = np.stack([np.bincount(theta, minlength=g_count) for theta in flat])
    tally = np.bincount((np.arange(n) * g_count + flat).ravel(), minlength=n * g_count).reshape(n, g_count)
    unknown = np.full((count, held), np.nan)
    return Posterior(
        demonstrations=likelihood.demonstrations,
        candidates=likelihood.candidates,
        settings=settings_of(likelihood, concentration, count, seed, draws=held, warmup=0, thin=1),
        assignments=latest,
        counts=count_draws([sparse_rows(counted)]),
        shares=sparse.csr_array(tally / len(flat)),
        best_assignment=chains.theta[0].copy(),
        log_joint=unknown,
        log_likelihood=unknown,
        traces={},
        diagnostics={},
        status=Status.NOT_CONVERGED,
        uninformative=likelihood.source.uninformative,
        seconds=0.0,
        likelihood=likelihood,
    )


def drawn(likelihood: LogLikelihood, concentration: float, chains: Chains, seed: int, *, draws: int, warmup: int,
          thin: int) -> Posterior:  # fmt: skip
    """``draws`` of each chain from where it is, after ``warmup`` sweeps, every ``thin``-th."""
    begin = time.monotonic()
    settings = settings_of(
        likelihood, concentration, chains.count, seed, draws=draws, warmup=warmup, thin=thin,
        data=checksum_of(likelihood),
    )  # fmt: skip
    after = np.arange(settings.sweeps) - warmup
    keep = (after >= 0) & ((after + 1) % thin == 0)
    n = likelihood.n_observations
    room = np.empty((chains.count, draws, n), np.int32)
    records = [
        ChainRecord(n, likelihood.n_candidates, generator, room[k]) for k, generator in enumerate(chains.generators)
    ]
    for record, stretch in zip(records, chains.advance(likelihood, concentration, keep), strict=True):
        record.add(stretch, stretch.log_joint[keep])
    return assemble(likelihood, None, settings, records, room, time.monotonic() - begin)
