"""``sample``: draws from the posterior over which subgoal explains which observation."""

from __future__ import annotations

import time
import warnings
from collections.abc import Sequence
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.alg4 import PRINTED_FORMS
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.protocol import Int32s, Sampler
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.checkpoint import Checkpoint
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.diagnostics import LARGEST_SHARES, Status, gate
from subgoal.posterior.memory import allocate, holds_assignments, refuse_above_budget
from subgoal.posterior.posterior import CountDraws, Posterior, Settings
from subgoal.posterior.rounds import Rounds
from subgoal.runtime.checks import Floats, positive, whole
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.executor import worker_count
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream
from subgoal.runtime.version import VERSION

MEMORY_BUDGET = 2**31
LIKELIHOOD_HINT = "subgoal.action_comparison(demonstrations, candidates), or LogLikelihood.from_table(values)"


class ConvergenceWarning(UserWarning):
    """The draws did not pass the gate; the posterior's status says so too."""


def sample(
    likelihood: LogLikelihood,
    *,
    concentration: float = 1.0,
    sampler: Sampler = collapsed_blocks,
    chains: int = 4,
    draws: int = 1000,
    warmup: int = 1000,
    thin: int = 10,
    seed: int = 0,
    workers: int | None = None,
    backend: str = "threading",
    memory_budget: float = MEMORY_BUDGET,
    checkpoint: str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Posterior:
    """Draw assignments of observations to subgoals from the Chinese restaurant mixture posterior (thesis 4.3).

    Parameters
    ----------
    likelihood:
        The N × G table.
    concentration:
        η of (2.8): larger expects more subgoals.
    sampler:
        A function of ``subgoal.samplers``. All give the same posterior but the ``alg4_literal`` forms, which the
        thesis printed and which are biased; their status says so.
    chains, draws, warmup, thin, seed:
        Each chain makes ``warmup`` sweeps, then ``draws × thin``, keeping every ``thin``-th (the thesis's burn-in and
        lag). Chain k depends on ``seed`` and k alone.
    workers, backend:
        How many chains run at once (default: all cores), and in which joblib backend: "threading", "loky"
        (processes), or "dask" where a client is connected. The draws do not depend on either.
    memory_budget:
        Bytes. A predicted need above it is refused; assignments are kept whole while they fit in a quarter of it.
    checkpoint, resume:
        File written now and then (at most 2 % of the time), removed at the end; ``resume`` goes on from it.
    progress:
        Told how many sweeps are done.

    Returns
    -------
    Posterior. Ctrl-C gives the draws so far. Not converging does not raise: ``status`` says so and a
    ``ConvergenceWarning`` is given.

    Raises
    ------
    InputError
        A setting out of range, or an observation that no candidate allows.
    BudgetError
        The predicted memory is above the budget.
    StoppedError
        Ctrl-C during the warm-up: there are no draws yet; the checkpoint is written all the same.
    StorageError
        Resuming from a checkpoint of other settings or data, or a torn one.
    """
    if not isinstance(likelihood, LogLikelihood):
        raise InputError("likelihood", found=type(likelihood).__name__, wanted="a LogLikelihood", hint=LIKELIHOOD_HINT)
    settings = Settings(
        _name(sampler), positive("concentration", concentration), likelihood.confidence, whole("chains", chains),
        whole("draws", draws), whole("warmup", warmup, least=0), whole("thin", thin), whole("seed", seed, least=0),
        likelihood.source.kind, "", VERSION,
    )  # fmt: skip
    refuse_above_budget(likelihood, settings, memory_budget)
    begin = time.monotonic()
    settings = replace(settings, data=checksum_of(likelihood))
    n, g_count = likelihood.n_observations, likelihood.n_candidates
    held = holds_assignments(n, settings, memory_budget)
    room = allocate((settings.chains, settings.draws, n)) if held else None
    records = [
        ChainRecord(n, g_count, stream(settings.seed, k), None if room is None else room[k])
        for k in range(settings.chains)
    ]
    keeper = Checkpoint(Path(checkpoint), settings) if checkpoint is not None else None
    if resume:
        _resume(keeper, records)
    likelihood.relative  # noqa: B018  (made once, here, for all chains)
    rounds = Rounds(likelihood, sampler, settings, workers=worker_count(workers), backend=backend, budget=memory_budget)
    _advance(rounds, records, keeper, progress or Silent(), settings.sweeps * settings.chains)
    complete = records[0].sweeps == settings.sweeps
    if keeper is not None and not complete:
        keeper.write(records)
    posterior = _assemble(likelihood, settings, records, room, time.monotonic() - begin)
    if keeper is not None and complete:
        keeper.remove()
    if posterior.status is not Status.CONVERGED:
        warnings.warn(posterior.status.value, ConvergenceWarning, stacklevel=2)
    return posterior


def _advance(
    rounds: Rounds, records: list[ChainRecord], keeper: Checkpoint | None, display: Progress, total: int
) -> None:
    """Rounds until all is done or Ctrl-C; worker processes that Ctrl-C ended lose their last round and nothing else.

    A second Ctrl-C, in the middle of a round, is passed on: the streams have run on, so the records may not be used.
    """
    with Interrupt() as interrupt, display:
        try:
            while not interrupt.requested and rounds.advance(records):
                display.update(rounds.done(records), total)
                if keeper is not None:
                    keeper.write_if_due(records)
        except BrokenExecutor:
            if not interrupt.requested:
                raise


def _name(sampler: Sampler) -> str:
    if not callable(sampler):
        raise InputError("sampler", found=repr(sampler), wanted="a function, such as subgoal.samplers.collapsed_blocks")
    return str(getattr(sampler, "__name__", type(sampler).__name__))


def _resume(keeper: Checkpoint | None, records: list[ChainRecord]) -> None:
    if keeper is None:
        raise InputError("resume", found="no checkpoint", wanted="the path of one")
    torn = keeper.restore(records)
    if torn:
        warnings.warn(torn, stacklevel=3)


def _assemble(
    likelihood: LogLikelihood, settings: Settings, records: Sequence[ChainRecord], room: Int32s | None, seconds: float
) -> Posterior:
    traces = {name: np.stack([r.trace(name) for r in records]) for name in ("n_active", "log_joint", "log_likelihood")}
    kept = slice(settings.warmup + settings.thin - 1, None, settings.thin)
    joint, fit = traces["log_joint"][:, kept], traces.pop("log_likelihood")
    if not joint.size:
        raise StoppedError("stopped during the warm-up: there are no draws yet to give")
    counts = _count_draws(records)
    n = likelihood.n_observations
    summaries = _summaries(counts, joint, traces["n_active"][:, kept], n)
    diagnostics, status = gate(
        summaries, interrupted=traces["n_active"].shape[1] < settings.sweeps, biased=settings.sampler in PRINTED_FORMS
    )
    tally: Any = sum((record.tally for record in records[1:]), records[0].tally)
    best = max(records, key=lambda record: record.best[0]).best[1]
    return Posterior(
        demonstrations=likelihood.demonstrations,
        candidates=likelihood.candidates,
        settings=settings,
        assignments=room[:, : joint.shape[1]] if room is not None and records[0].room is not None else None,
        counts=counts,
        shares=sparse.csr_array(tally / joint.size),
        best_assignment=best,
        log_joint=joint,
        log_likelihood=fit[:, kept],
        traces={**traces, "loss": -fit / n},
        diagnostics=diagnostics,
        status=status,
        uninformative=np.asarray(likelihood.source.uninformative),
        seconds=seconds,
        likelihood=likelihood,
    )


def _count_draws(records: Sequence[ChainRecord]) -> CountDraws:
    sizes, candidates, counts = (np.concatenate(parts) for parts in zip(*(r.count_rows for r in records), strict=True))
    return CountDraws(np.concatenate([[0], np.cumsum(sizes)]), candidates, counts)


def _summaries(counts: CountDraws, joint: Floats, n_active: Floats, n: int) -> dict[str, Floats]:
    """Label-invariant summaries (chain, draw): log joint, K, and the largest shares in falling order."""
    largest = counts.largest(LARGEST_SHARES) / n
    shares = {f"share {rank + 1}": largest[:, rank].reshape(joint.shape) for rank in range(LARGEST_SHARES)}
    return {"log joint": joint, "K": n_active, **shares}
