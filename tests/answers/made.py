"""Posteriors made by hand: the draws are given, all else follows from them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import sparse

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import CountDraws, Posterior
from tests.posterior.worlds import quiet_sample


def posterior_of(
    draws: np.ndarray,
    candidates: Candidates,
    *,
    chains: int = 1,
    offset: list[int] | None = None,
    silent: np.ndarray | None = None,
    times: np.ndarray | None = None,
) -> Posterior:
    """The posterior whose (draws, N) assignments are these."""
    rows, n = draws.shape
    offset = [0, n] if offset is None else offset
    demos = Demonstrations.from_arrays(np.zeros((n, 1)), np.ones((n, 1)), offset, times=times)
    start = LogLikelihood.from_table(
        np.zeros((n, candidates.n_candidates)), candidates=candidates, demonstrations=demos
    )
    g_count = candidates.n_candidates
    counts = [np.bincount(theta, minlength=g_count) for theta in draws]
    used = [np.flatnonzero(count) for count in counts]
    offsets = np.cumsum([0, *(each.size for each in used)])
    values = np.concatenate([count[each] for count, each in zip(counts, used, strict=True)])
    pairs = (np.tile(np.arange(n), rows), draws.ravel())
    shares = sparse.csr_array((np.full(draws.size, 1.0 / rows), pairs), shape=(n, g_count))
    drawn = quiet_sample(start, chains=1, draws=1, warmup=0, thin=1)
    return replace(
        drawn,
        assignments=draws.reshape(chains, -1, n).astype(np.int32),
        counts=CountDraws(offsets, np.concatenate(used), values),
        shares=shares,
        best_assignment=draws[0].astype(np.int32),
        log_joint=np.zeros((chains, rows // chains)),
        log_likelihood=np.zeros((chains, rows // chains)),
        uninformative=np.zeros(n, bool) if silent is None else silent,
    )
