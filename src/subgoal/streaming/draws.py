"""From the chains of a stream to a ``Posterior``: of late draws, at once, or of new ones, with diagnostics."""

from __future__ import annotations

import time
from typing import NamedTuple

import numpy as np
from scipy import sparse

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.sources import Directions
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.protocol import Int32s
from subgoal.posterior.assemble import assemble, count_draws
from subgoal.posterior.chains import ChainRecord, sparse_rows
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior, Settings
from subgoal.runtime.checks import Bools, Ints
from subgoal.runtime.version import VERSION
from subgoal.streaming.chains import Chains


class Target(NamedTuple):
    """What the chains draw from, but for the table: η and α, and the seed of the chains."""

    concentration: float
    confidence: float
    seed: int

    def settings(self, chains: int, draws: int, warmup: int = 0, thin: int = 1, data: str = "") -> Settings:
        """What decides the draws, but for how the data came."""
        return Settings(
            collapsed_blocks.__name__, self.concentration, self.confidence, chains, draws, warmup, thin, self.seed,
            Directions.kind, data, VERSION,
        )  # fmt: skip


def of_late(
    target: Target, chains: Chains, demonstrations: Demonstrations, candidates: Candidates, uninformative: Bools
) -> Posterior:
    """The latest draws of all chains; their log joint is not a number, nothing is said of convergence."""
    latest, g_count = chains.latest, candidates.n_candidates
    count, held, n = latest.shape
    flat = latest.reshape(-1, n)
    counted = np.stack([np.bincount(theta, minlength=g_count) for theta in flat])
    unknown = np.full((count, held), np.nan)
    return Posterior(
        demonstrations=demonstrations,
        candidates=candidates,
        settings=target.settings(count, held),
        assignments=latest,
        counts=count_draws([sparse_rows(counted)]),
        shares=_shares(flat, np.flatnonzero(counted.any(axis=0)), g_count),
        best_assignment=chains.theta[0].copy(),
        log_joint=unknown,
        log_likelihood=unknown,
        traces={},
        diagnostics={},
        status=Status.NOT_CONVERGED,
        uninformative=uninformative,
        seconds=0.0,
    )


def _shares(draws: Int32s, used: Ints, g_count: int) -> sparse.csr_array:
    """(N, G) share of the draws (S, N) in which each pair is at each candidate, of which (U,) are ``used``."""
    n, place = draws.shape[1], np.empty(g_count, np.int64)
    place[used] = np.arange(used.size)
    codes = place[draws] + np.arange(n) * used.size
    few = sparse.csr_array(np.bincount(codes.ravel(), minlength=n * used.size).reshape(n, -1) / len(draws))
    return sparse.csr_array((few.data, used[few.indices], few.indptr), shape=(n, g_count))


def drawn(
    target: Target, chains: Chains, likelihood: LogLikelihood, *, draws: int, warmup: int, thin: int
) -> Posterior:
    """``draws`` of each chain from where it is, after ``warmup`` sweeps, every ``thin``-th."""
    begin = time.monotonic()
    settings = target.settings(chains.count, draws, warmup, thin, checksum_of(likelihood))
    after = np.arange(settings.sweeps) - warmup
    keep = (after >= 0) & ((after + 1) % thin == 0)
    n = likelihood.n_observations
    room = np.empty((chains.count, draws, n), np.int32)
    records = [
        ChainRecord(n, likelihood.n_candidates, generator, room[k]) for k, generator in enumerate(chains.generators)
    ]
    for record, stretch in zip(records, chains.advance(likelihood, target.concentration, keep), strict=True):
        record.add(stretch, stretch.log_joint[keep])
    return assemble(likelihood, None, settings, records, room, time.monotonic() - begin)
