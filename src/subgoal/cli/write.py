"""Results written to a folder, with the answers under other settings if these are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from subgoal.answers.subgoals import subgoals
from subgoal.irl.as_sampled import as_sampled
from subgoal.irl.confidence_sweep import confidence_sweep
from subgoal.irl.sensitivity import sensitivity
from subgoal.irl.sweep_record import Sweep
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.results import Results, write_results
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import progress_display


def write(
    posterior: Posterior, folder: Path, *, merge_radius: float | None, y_down: bool, sensitive: bool, quiet: bool,
    swept: bool = False,
) -> Results:  # fmt: skip
    """``write_results``, then again with ``sensitivity`` and ``confidence_sweep`` where these are asked for.

    The results stand in the folder before either begins.
    """
    found = subgoals(posterior, merge_radius=merge_radius)
    more: dict[str, Any] = {}
    results = write_results(posterior, folder, found=found, y_down=y_down)
    if sensitive:
        more["sensitivity"] = sensitivity(
            posterior, found=found, progress=progress_display("sensitivity", quiet=quiet)
        )  # fmt: skip
    if swept:
        more["sweep"] = _sweep(posterior, folder, quiet)
    for each in more.values() if not quiet else ():
        print(each)
    return write_results(posterior, folder, found=found, y_down=y_down, **more) if more else results


def _sweep(posterior: Posterior, folder: Path, quiet: bool) -> Sweep:
    """Over the confidence, with the model and the concentration that the posterior was sampled with."""
    used = as_sampled(posterior)
    if not isinstance(used.concentration, float):
        raise InputError("--sweep", found="a concentration that is learned", wanted="a number, without --learn-all")
    how: dict[str, Any] = {"sampler": used.sampler} if used.model is None else {"model": used.model}
    kept = folder / ".sweep.npz"
    return confidence_sweep(
        used.likelihood, concentration=used.concentration, checkpoint=kept, resume=kept.exists(),
        progress=progress_display("sweep", quiet=quiet), **how,
    )  # fmt: skip
