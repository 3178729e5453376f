"""``sample``: draws from the posterior over which subgoal explains which observation."""

from __future__ import annotations

import time
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from subgoal.likelihood.table import FixedTable, LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.crp import expected_clusters
from subgoal.partition.protocol import Chain, Sampler, Stretch
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.checkpoint import Checkpoint
from subgoal.posterior.diagnostics import LARGEST_SHARES, Status, gate
from subgoal.posterior.posterior import CountDraws, Posterior, Settings
from subgoal.runtime.checks import Bools, Floats, positive, whole
from subgoal.runtime.errors import BudgetError, InputError, StoppedError
from subgoal.runtime.executor import run_all, worker_count
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream
from subgoal.runtime.version import VERSION
from subgoal.storage.archive import digest_arrays

MEMORY_BUDGET = 2**31
ROUND_SECONDS = {"threading": 0.4}
OTHER_ROUND_SECONDS = 4.0
PROBED_ROWS = 4


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
        A function of ``subgoal.samplers``; all give the same posterior.
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
    settings = Settings(
        sampler.__name__, positive("concentration", concentration), likelihood.confidence, whole("chains", chains),
        whole("draws", draws), whole("warmup", warmup, least=0), whole("thin", thin), whole("seed", seed, least=0),
        likelihood.source.kind, _checksum(likelihood), VERSION,
    )  # fmt: skip
    _refuse_above_budget(likelihood, settings, memory_budget)
    begin = time.monotonic()
    likelihood.log_marginal  # noqa: B018  (an impossible observation is refused before anything runs)
    keep_whole = 4.0 * settings.chains * settings.draws * likelihood.n_observations <= memory_budget / 4
    shape = likelihood.n_observations, likelihood.n_candidates
    records = [ChainRecord(*shape, stream(seed, k), keep_whole) for k in range(settings.chains)]
    keeper = Checkpoint(Path(checkpoint), settings) if checkpoint is not None else None
    if resume:
        _resume(keeper, records)
    run = _Run(likelihood, sampler, settings, worker_count(workers), backend)
    with Interrupt() as interrupt, progress or Silent() as display:
        while not interrupt.requested and run.advance(records):
            display.update(run.done(records), settings.sweeps * settings.chains)
            if keeper is not None:
                keeper.write_if_due(records)
    complete = records[0].sweeps == settings.sweeps
    if keeper is not None and not complete:
        keeper.write(records)
    posterior = _assemble(likelihood, settings, records, time.monotonic() - begin)
    if keeper is not None and complete:
        keeper.remove()
    if posterior.status is not Status.CONVERGED:
        warnings.warn(posterior.status.value, ConvergenceWarning, stacklevel=2)
    return posterior


class _Run:
    """Rounds of sweeps over all chains, each short enough to look up between them."""

    def __init__(
        self, likelihood: LogLikelihood, sampler: Sampler, settings: Settings, workers: int, backend: str
    ) -> None:
        self._likelihood, self._sampler, self._settings = likelihood, sampler, settings
        self._workers, self._backend = workers, backend
        self._target = ROUND_SECONDS.get(backend, OTHER_ROUND_SECONDS)
        self._length = 1

    def done(self, records: Sequence[ChainRecord]) -> int:
        """Sweeps done over all chains."""
        return sum(record.sweeps for record in records)

    def advance(self, records: list[ChainRecord]) -> bool:
        """One round; False when there is nothing left to do."""
        first = records[0].sweeps
        length = min(self._length, self._settings.sweeps - first)
        if length <= 0:
            return False
        keep = self._kept(first, length)
        begin = time.monotonic()
        jobs = [
            (self._sampler, Chain(self._likelihood, self._settings.concentration, r.generator, r.state), keep)
            for r in records
        ]
        answers = run_all(_advance_chain, jobs, workers=self._workers, backend=self._backend)
        for record, (stretch, generator) in zip(records, answers, strict=True):
            record.generator = generator
            record.add(stretch, stretch.log_joint[keep])
        pace = (time.monotonic() - begin) / length
        self._length = max(1, min(8 * length, int(self._target / max(pace, 1e-9))))
        return True

    def _kept(self, first: int, length: int) -> Bools:
        after = np.arange(first, first + length) - self._settings.warmup
        return np.asarray((after >= 0) & ((after + 1) % self._settings.thin == 0))


def _advance_chain(sampler: Sampler, chain: Chain, keep: Bools) -> tuple[Stretch, np.random.Generator]:
    return sampler(chain, keep), chain.generator


def _checksum(likelihood: LogLikelihood) -> str:
    """One checksum of what the table is made from: given numbers in full, a computed table by some of its rows."""
    demos, candidates, source = likelihood.demonstrations, likelihood.candidates, likelihood.source
    if isinstance(source, FixedTable):
        probe = source.values
    else:
        rows = np.unique(np.linspace(0, likelihood.n_observations - 1, PROBED_ROWS).astype(int))
        probe = np.concatenate([likelihood.rows(i, i + 1) for i in rows])
    return digest_arrays(
        demos.states, demos.actions, demos.offset, candidates.points, candidates.log_prior, candidates.radius,
        candidates.metric.weights, candidates.metric.period, probe,
    )  # fmt: skip


def _refuse_above_budget(likelihood: LogLikelihood, settings: Settings, budget: float) -> None:
    n, g_count = likelihood.n_observations, likelihood.n_candidates
    table = 16.0 * n * g_count if likelihood.is_dense else 0.0
    sums = settings.chains * g_count * (64 + 2 * expected_clusters(n, settings.concentration)) * 8
    needed = table + sums + settings.chains * (100.0 * n + 8 * 3 * settings.sweeps)
    if needed > positive("memory_budget", budget):
        raise BudgetError("sample", needed=needed, budget=budget, hint="fewer candidates, or a larger memory_budget")


def _resume(keeper: Checkpoint | None, records: list[ChainRecord]) -> None:
    if keeper is None:
        raise InputError("resume", found="no checkpoint", wanted="the path of one")
    torn = keeper.restore(records)
    if torn:
        warnings.warn(torn, stacklevel=3)


def _assemble(
    likelihood: LogLikelihood, settings: Settings, records: Sequence[ChainRecord], seconds: float
) -> Posterior:
    traces = {name: np.stack([r.trace(name) for r in records]) for name in ("n_active", "log_joint", "log_likelihood")}
    kept = slice(settings.warmup + settings.thin - 1, None, settings.thin)
    joint, fit = traces["log_joint"][:, kept], traces.pop("log_likelihood")
    if not joint.size:
        raise StoppedError("stopped during the warm-up: there are no draws yet to give")
    counts = _count_draws(records)
    n = likelihood.n_observations
    summaries = _summaries(counts, joint, traces["n_active"][:, kept], n)
    diagnostics, status = gate(summaries, interrupted=traces["n_active"].shape[1] < settings.sweeps)
    tally: Any = sum((record.tally for record in records[1:]), records[0].tally)
    best = max(records, key=lambda record: record.best[0]).best[1]
    return Posterior(
        demonstrations=likelihood.demonstrations,
        candidates=likelihood.candidates,
        settings=settings,
        assignments=np.stack([r.draws for r in records]) if records[0].whole else None,
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
