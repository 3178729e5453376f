"""How many subgoals there are at each confidence (thesis 7.3.1): many short chains at each of many levels."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.answers.subgoals import reaches
from subgoal.irl.gpsrl import CONCENTRATION, STEPS_KEPT
from subgoal.irl.sweep_record import LevelCounts, Sweep
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.collapsed_blocks import collapsed_blocks
from subgoal.partition.persistence import Persistent
from subgoal.partition.protocol import Chain, Sampler
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.composed import composed, name_of, words
from subgoal.runtime.checks import Floats, positive, real_array, whole
from subgoal.runtime.errors import InputError, StoppedError
from subgoal.runtime.executor import run_all
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, progress_display
from subgoal.runtime.seeds import stream

LEVELS = 12
RANGE = 0.1, 100.0
"""Of the levels where none are given, in units of the likelihood's own scale."""
LEAST_SHARE = 0.03
TRIALS, SWEEPS = 50, 1500
LASTING = Persistent(keep=math.exp(-1 / STEPS_KEPT))
"""Subgoals that are kept for 20 steps on average, as in ``gpsrl``."""
Form = Callable[[LogLikelihood], LogLikelihood]


def confidence_sweep(
    likelihood: LogLikelihood,
    confidences: Any = None,
    *,
    trials: int = TRIALS,
    sweeps: int = SWEEPS,
    model: Sampler | None = None,
    sampler: Sampler | None = None,
    form: Form | None = None,
    concentration: float = CONCENTRATION,
    least_share: float = LEAST_SHARE,
    seed: int = 0,
    workers: int | None = None,
    progress: Progress | None = None,
    checkpoint: str | Path | None = None,
    resume: bool = False,
) -> Sweep:
    """Count subgoals at one confidence after another: one, then some that last over a range, then more and more.

    Each trial is a chain of its own from its own start. Counted are the distinct candidates that serve at least
    ``least_share`` of the observations in its last draw, so that the mean over trials is the posterior's as far as
    chains of ``sweeps`` reach it; the best draw would tell of the joint mode, which has too few subgoals wherever pairs
    are exchangeable. Candidates next to each other count as two.

    Parameters
    ----------
    likelihood:
        The N × G table, one that knows other confidences (``at``).
    confidences:
        (L,) levels, rising; by default twelve from a tenth to a hundred times the unit of the likelihood, log-spaced.
    trials, sweeps:
        Chains at each level, and the length of each: thesis 7.3.1 has 50 and 1,500.
    model, sampler:
        How subgoals follow each other, or a sampler of the exchangeable model, such as ``subgoal.samplers.annealed``.
        Neither: subgoals are kept for 20 steps on average.
    form:
        Made of the table at each level, such as ``literal_maximum``.
    concentration:
        η (2.8).
    seed:
        Trial k at level l hangs on the seed, k and l alone.
    workers:
        Threads; all cores by default. The counts do not depend on it.
    progress:
        Told the trials; by default a bar on a terminal and lines elsewhere.
    checkpoint, resume:
        File that keeps the levels that are done, removed at the end; ``resume`` goes on from it.

    Returns
    -------
    Sweep. Ctrl-C gives the levels that are done, and names the others.

    Raises
    ------
    InputError
        Levels that do not rise or are not above zero, a setting out of range, a table of given numbers.
    StoppedError
        Ctrl-C before the first level was done.
    StorageError
        Resuming from a checkpoint of other settings or data.
    """
    if not isinstance(likelihood, LogLikelihood):
        raise InputError("likelihood", found=type(likelihood).__name__, wanted="a LogLikelihood",
                         hint="posterior.likelihood, or subgoal.continuous.gp_actions(...)")  # fmt: skip
    levels = _levels(likelihood, confidences)
    trials, sweeps = whole("trials", trials), whole("sweeps", sweeps)
    share, eta = positive("least_share", least_share, zero=True), positive("concentration", concentration)
    if share > 1:
        raise InputError("least_share", found=share, wanted="a share of the observations, at most 1")
    chosen = _sampler(likelihood, model, sampler)
    settings = {
        "sampler": words(chosen) if model is not None or sampler is None else name_of(chosen),
        "form": "" if form is None else name_of(form, "form"), "sweeps": sweeps, "concentration": eta,
        "least_share": share, "seed": whole("seed", seed, least=0),
    }  # fmt: skip
    counts = LevelCounts(levels, trials, settings, checkpoint)
    if checkpoint is not None or resume:
        counts.settle(checksum_of(likelihood), resume)
    begin, display = time.monotonic(), progress_display("confidence sweep") if progress is None else progress
    with Interrupt() as interrupt, display:

        def trial(table: LogLikelihood, level: int, k: int) -> int:
            if interrupt.requested:
                return -1
            chain = Chain(table, eta, stream(seed, level, k))
            return _count(chosen, chain, sweeps, share, likelihood.candidates.n_candidates)

        for level in range(counts.done, levels.size):
            if interrupt.requested:
                break
            table = likelihood.at(float(levels[level]))
            table = table if form is None else form(table)
            table.relative  # noqa: B018  (made once, here, for all trials)
            found = run_all(trial, [(table, level, k) for k in range(trials)], workers=workers)
            if -1 in found:
                break
            counts.add(found)
            display.update(counts.done * trials, levels.size * trials, f"α = {levels[level]:.3g}")
    if not counts.done:
        raise StoppedError("stopped before the first level of the sweep was done")
    return counts.swept(time.monotonic() - begin)


def _count(sampler: Sampler, chain: Chain, sweeps: int, share: float, places: int) -> int:
    """How many candidates serve at least ``share`` of the observations in the last of so many sweeps."""
    keep = np.zeros(sweeps, bool)
    keep[-1] = True
    last = sampler(chain, keep).assignments[-1]
    served = np.bincount(last, minlength=places)[:places] / last.size
    return int(sum(x > 0 and reaches(x, share) for x in served.tolist()))


def _levels(likelihood: LogLikelihood, given: Any) -> Floats:
    if given is None:
        low, high = RANGE
        return likelihood.source.unit * np.geomspace(low, high, LEVELS)
    levels = real_array("confidences", given, ndim=1)
    if not levels.size or not levels[0] > 0 or not (np.diff(levels) > 0).all():
        raise InputError("confidences", found=str(levels), wanted="numbers above 0, each larger than the one before",
                         hint="np.geomspace(1, 300, 12)")  # fmt: skip
    return levels


def _sampler(likelihood: LogLikelihood, model: Sampler | None, sampler: Sampler | None) -> Sampler:
    """The one that is to run; raises ``InputError`` for both, and for what cannot."""
    if model is None and sampler is None:
        model = LASTING
    chosen, _ = composed(likelihood, collapsed_blocks if sampler is None else sampler, model, 1.0, None)
    return chosen
