"""``sample``: draws from the posterior over which subgoal explains which observation."""

from __future__ import annotations

import time
import warnings
from concurrent.futures import BrokenExecutor
from dataclasses import replace
from pathlib import Path

from subgoal.likelihood.noise import NoiseSpec
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.priors import Gamma, concentration_of
from subgoal.partition.protocol import Sampler
from subgoal.posterior.assemble import assemble
from subgoal.posterior.chains import ChainRecord
from subgoal.posterior.checkpoint import Checkpoint
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.composed import composed, name_of, told, words
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.memory import allocate, holds_assignments, refuse_above_budget
from subgoal.posterior.posterior import EXCHANGEABLE, Posterior, Settings
from subgoal.posterior.rounds import Rounds
from subgoal.runtime.checks import whole
from subgoal.runtime.errors import InputError
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
    concentration: float | Gamma = 1.0,
    confidence: NoiseSpec | None = None,
    model: Sampler | None = None,
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
    """Draw assignments of observations to subgoals from their posterior.

    By default that of the Chinese restaurant mixture (thesis 4.3), in which the order of observations says nothing.

    Parameters
    ----------
    likelihood:
        The N × G table.
    concentration:
        η of (2.8): larger expects more subgoals. A ``Gamma`` prior has it learned.
    confidence:
        None leaves α as the likelihood has it. ``OneConfidence``, ``OwnConfidence`` or ``NoiseLevels`` of
        ``subgoal.models`` have it learned, from the action values or distances that the likelihood keeps.
    model:
        How subgoals follow each other: None, not at all; or one of ``subgoal.models`` with a sampler of its own, such
        as ``Persistent()``.
    sampler:
        A function of ``subgoal.samplers``, for the exchangeable model. All give the same posterior but the
        ``alg4_literal`` forms, which the thesis printed and which are biased; their status says so.
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
        A setting out of range, an observation that no candidate allows, or a model of time where no trajectory has
        two observations.
    BudgetError
        The predicted memory is above the budget.
    StoppedError
        Ctrl-C during the warm-up: there are no draws yet; the checkpoint is written all the same.
    StorageError
        Resuming from a checkpoint of other settings or data, or a torn one.
    """
    if not isinstance(likelihood, LogLikelihood):
        raise InputError("likelihood", found=type(likelihood).__name__, wanted="a LogLikelihood", hint=LIKELIHOOD_HINT)
    advance, noise = composed(likelihood, sampler, model, concentration, confidence)
    settings = Settings(
        name_of(sampler if model is None else model), told(concentration_of(concentration)),
        told(likelihood.confidence if confidence is None else confidence), whole("chains", chains),
        whole("draws", draws), whole("warmup", warmup, least=0), whole("thin", thin), whole("seed", seed, least=0),
        likelihood.source.kind, "", VERSION, EXCHANGEABLE if model is None else words(model), likelihood.background,
        likelihood.planner,
    )  # fmt: skip
    refuse_above_budget(likelihood, settings, advance, memory_budget)
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
    rounds = Rounds(likelihood, advance, settings, workers=worker_count(workers), backend=backend, budget=memory_budget)
    _advance(rounds, records, keeper, progress or Silent(), settings.sweeps * settings.chains)
    complete = records[0].sweeps == settings.sweeps
    if keeper is not None and not complete:
        keeper.write(records)
    posterior = assemble(likelihood, noise, settings, records, room, time.monotonic() - begin)
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


def _resume(keeper: Checkpoint | None, records: list[ChainRecord]) -> None:
    if keeper is None:
        raise InputError("resume", found="no checkpoint", wanted="the path of one")
    torn = keeper.restore(records)
    if torn:
        warnings.warn(torn, stacklevel=3)
