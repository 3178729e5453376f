"""``sample_shards``: blocked Gibbs over observations in files, in threads, processes or on a cluster."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import BrokenExecutor
from pathlib import Path
from typing import Any

import numpy as np

from subgoal._kernels.counts import log_assignment_prior
from subgoal.likelihood.shards import DIRECTIONS, Shards
from subgoal.partition.sharded_blocked import UNIT, draw_part, parts_of, together
from subgoal.posterior.assemble import count_draws, label_free
from subgoal.posterior.checkpoint import Checkpoint
from subgoal.posterior.diagnostics import Status, gate
from subgoal.posterior.posterior import Settings
from subgoal.posterior.sample import ConvergenceWarning
from subgoal.posterior.sharded_chains import TRACES, ShardedChain
from subgoal.posterior.sharded_posterior import ShardedPosterior
from subgoal.runtime.checks import Floats, Ints, positive, whole
from subgoal.runtime.cluster import connected, run_on
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.executor import run_all, worker_count
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream
from subgoal.runtime.version import VERSION

Sweep = Callable[[Floats, int], tuple[Ints, tuple[int, ...]]]
"""Log weights (C, G) and the number of the sweep in, counts (C, G) and Σ log shares out."""


def sample_shards(
    shards: Shards,
    *,
    concentration: float = 1.0,
    chains: int = 4,
    draws: int = 1000,
    warmup: int = 1000,
    thin: int = 1,
    seed: int = 0,
    workers: int | None = None,
    backend: str = "threading",
    client: Any = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> ShardedPosterior:
    """Draw how many observations serve each candidate, of the mixture that ``subgoal.sample`` draws from.

    A sweep draws w | n ~ Dirichlet(ηp + n), then every θ_i ∝ w_g L_ig on its own (``subgoal.samplers.blocked``). Each
    sweep reads the files once for all chains; only counts (G,) and Σ ℓ of each chain come back, so memory does not grow
    with N.

    Parameters
    ----------
    shards:
        From ``write_shards`` or ``open_shards``; workers must see the same folder.
    concentration, chains, draws, warmup, thin, seed:
        As in ``subgoal.sample``.
    workers, backend, client:
        How many parts run at once, and where: "threading", "loky" (processes), or "dask", on ``client`` or the one
        that is connected. The draws depend on none of them, nor on the division into files: random numbers hang on
        chain, sweep and block of 65,536 observations.
    checkpoint, resume, progress:
        As in ``subgoal.sample``.

    Returns
    -------
    ShardedPosterior. Ctrl-C gives the draws so far. Not converging does not raise: ``status`` says so and a
    ``ConvergenceWarning`` is given.

    Raises
    ------
    InputError
        A setting out of range.
    StorageError
        A shard that went missing or was changed; resuming from a checkpoint of other settings or data.
    StoppedError
        Ctrl-C during the warm-up.
    ClusterError
        A Dask cluster without workers.
    """
    if not isinstance(shards, Shards):
        raise InputError("shards", found=type(shards).__name__, wanted="Shards", hint="open_shards(folder)")
    settings = Settings(
        "blocked", positive("concentration", concentration), shards.confidence, whole("chains", chains),
        whole("draws", draws), whole("warmup", warmup, least=0), whole("thin", thin), whole("seed", seed, least=0),
        f"shards, {shards.kind}", shards.checksum, VERSION, background=shards.background,
    )  # fmt: skip
    begin = time.monotonic()
    records = [ShardedChain(shards.n_candidates, stream(settings.seed, k)) for k in range(settings.chains)]
    keeper = Checkpoint(Path(checkpoint), settings) if checkpoint is not None else None
    if resume:
        _resume(keeper, records)
    sweep = _sweeper(shards, settings.seed, workers, backend, client)
    _advance(sweep, shards, settings, records, keeper, progress or Silent())
    complete = records[0].sweeps == settings.sweeps
    if keeper is not None and not complete:
        keeper.write(records)
    posterior = _assemble(shards, settings, records, time.monotonic() - begin)
    if keeper is not None and complete:
        keeper.remove()
    if posterior.status is not Status.CONVERGED:
        warnings.warn(posterior.status.value, ConvergenceWarning, stacklevel=2)
    return posterior


def _sweeper(shards: Shards, seed: int, workers: int | None, backend: str, client: Any) -> Sweep:
    """One sweep over all parts, wherever they are worked on."""
    if client is not None and backend != "dask":
        raise InputError("client", found=f"a client, and backend={backend!r}", wanted="backend='dask' with it")
    cluster, threads = connected(client) if backend == "dask" else (None, worker_count(workers))
    parts = parts_of(shards.files, shards.compass if shards.kind == DIRECTIONS else None, threads)

    def sweep(log_weights: Floats, number: int) -> tuple[Ints, tuple[int, ...]]:
        jobs = [(part, log_weights, seed, number) for part in parts]
        if cluster is not None:
            answers = run_on(cluster, draw_part, jobs)
        else:
            answers = run_all(draw_part, jobs, workers=threads, backend=backend)
        return together(answers, log_weights.shape)

    return sweep


def _advance(
    sweep: Sweep, shards: Shards, settings: Settings, records: list[ShardedChain], keeper: Checkpoint | None,
    display: Progress,
) -> None:  # fmt: skip
    """Sweeps until all are done or Ctrl-C; one that Ctrl-C ended in worker processes is lost and nothing else."""
    prior, concentration = np.exp(shards.log_prior), float(settings.concentration)
    with Interrupt() as interrupt, display:
        try:
            for number in range(records[0].sweeps, settings.sweeps):
                weights, generators = zip(*(each.weights(prior, concentration) for each in records), strict=True)
                counts, fits = sweep(np.stack(weights), number)
                after = number + 1 - settings.warmup
                for record, row, fit, generator in zip(records, counts, fits, generators, strict=True):
                    total = (fit + shards.peaks) * UNIT
                    joint = total + log_assignment_prior(row, prior, concentration)
                    record.add(row, total, joint, generator, after > 0 and after % settings.thin == 0)
                display.update((number + 1) * settings.chains, settings.sweeps * settings.chains)
                if keeper is not None:
                    keeper.write_if_due(records)
                if interrupt.requested:
                    break
        except BrokenExecutor:
            if not interrupt.requested:
                raise


def _resume(keeper: Checkpoint | None, records: list[ShardedChain]) -> None:
    if keeper is None:
        raise InputError("resume", found="no checkpoint", wanted="the path of one")
    torn = keeper.restore(records)
    if torn:
        warnings.warn(torn, stacklevel=3)


def _assemble(shards: Shards, settings: Settings, records: Sequence[ShardedChain], seconds: float) -> ShardedPosterior:
    traces = {name: np.stack([record.trace(name) for record in records]) for name in TRACES}
    kept = slice(settings.warmup + settings.thin - 1, None, settings.thin)
    joint, fit = traces["log_joint"][:, kept], traces.pop("log_likelihood")
    if not joint.size:
        raise StoppedError("stopped during the warm-up: there are no draws yet to give")
    counts = count_draws([record.count_rows for record in records])
    n, places = shards.n_observations, shards.candidates.n_candidates
    summaries = label_free(counts, joint, traces["n_active"][:, kept], n)
    if shards.background:
        background = counts.by_group(np.arange(shards.n_candidates) - places, 1)
        summaries["background"] = background.reshape(joint.shape) / n
    interrupted = traces["n_active"].shape[1] < settings.sweeps
    diagnostics, status = gate(summaries, interrupted=interrupted, biased=False)
    return ShardedPosterior(
        shards.candidates, n, settings, counts.of_places(places), joint, fit[:, kept], traces | {"loss": -fit / n},
        diagnostics, status, seconds,
    )  # fmt: skip
