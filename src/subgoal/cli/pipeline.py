"""From a file to a folder of results: the pipeline behind the commands that learn."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from subgoal.runtime.errors import InputError, StoppedError

if TYPE_CHECKING:
    from subgoal.likelihood.table import LogLikelihood
    from subgoal.posterior.posterior import Posterior

CONFIDENCE = 3.0
CHECKPOINT = ".checkpoint.npz"


@contextmanager
def scheduler_of(address: str | None, backend: str) -> Iterator[None]:
    """A connected Dask client while it lasts, where there is an address."""
    if address is None:
        yield
        return
    if backend != "dask":
        raise InputError("--scheduler", found=address, wanted="--backend dask beside it")
    from subgoal.runtime.cluster import connect

    with connect(address):
        yield


def learn_file(
    file: Path,
    out: Path,
    reading: dict[str, Any],
    places: dict[str, Any],
    metric: dict[str, Any],
    table: dict[str, Any],
    run: dict[str, Any],
    *,
    merge_radius: float | None,
    y_down: bool,
    quiet: bool,
    learn_all: bool = False,
    sensitive: bool = False,
    swept: bool = False,
) -> None:
    """The pipeline behind ``learn`` and ``demo``: read, tabulate, sample, write, print."""
    from subgoal.cli.compose import (
        candidate_places,
        clock_told,
        few_told,
        likelihood_table,
        output_folder,
        rate_hint,
    )
    from subgoal.demonstrations.metric import Metric
    from subgoal.demonstrations.read import read

    demonstrations = read(file, **reading)
    if not quiet:
        print(clock_told(demonstrations, file, reading))
        if hint := rate_hint(demonstrations, reading):
            print(hint)
    plan = Metric.of(demonstrations.states.shape[-1], metric["weights"], metric["period"])
    chosen = candidate_places(demonstrations, plan, **places)
    fixed = table["confidence"] is not None
    likelihood = likelihood_table(demonstrations, chosen, **(table if fixed else {**table, "confidence": CONFIDENCE}))
    if not quiet and (warning := few_told(demonstrations, reading)):
        print(warning, file=sys.stderr)
    with output_folder(out) as folder:
        learn_table(
            likelihood, folder, run, merge_radius=merge_radius, y_down=y_down, quiet=quiet, learn_all=learn_all,
            sensitive=sensitive, swept=swept, fixed=fixed, grouped="group" in reading,
        )  # fmt: skip


def learn_table(
    likelihood: LogLikelihood,
    folder: Path,
    run: dict[str, Any],
    *,
    merge_radius: float | None,
    y_down: bool,
    quiet: bool,
    learn_all: bool,
    sensitive: bool,
    swept: bool,
    fixed: bool,
    grouped: bool,
) -> None:
    """Sample, write and print, of a likelihood with its demonstrations; ``fixed`` keeps its confidence."""
    from subgoal.cli.compose import model_and_sampler, tell_replaced
    from subgoal.cli.table import print_results
    from subgoal.cli.write import write
    from subgoal.reporting.learned import GROUPS_DO_NOT_LAST
    from subgoal.runtime.checks import positive

    merge_radius = None if merge_radius is None else positive("merge_radius", merge_radius, zero=True)
    if not run.get("resume"):
        tell_replaced(folder, quiet=quiet)
    if learn_all and grouped and not quiet:
        print(f"note: {GROUPS_DO_NOT_LAST}")
    sampler = run.pop("sampler", None)
    run = run | model_and_sampler(likelihood.demonstrations, sampler, grouped=grouped, learn_all=learn_all)
    run |= {"confidence": None} if learn_all and fixed else {}
    posterior = _sampled(likelihood, folder, run, learn_all=learn_all, quiet=quiet)
    complete = posterior.n_draws == posterior.settings.draws
    results = write(
        posterior,
        folder,
        merge_radius=merge_radius,
        y_down=y_down,
        sensitive=sensitive and complete,
        swept=swept and complete,
        quiet=quiet,
    )
    if not quiet:
        print_results(posterior, results, folder)
    if not complete:
        told = f"{posterior.n_draws} of {posterior.settings.draws} draws per chain"
        raise StoppedError(f"stopped with {told}, which stand in {folder}; --resume goes on")


def _sampled(
    likelihood: LogLikelihood, folder: Path, run: dict[str, Any], *, learn_all: bool, quiet: bool
) -> Posterior:
    """From ``learn`` or ``sample``, with a checkpoint in the folder; whether it converged is told later."""
    from subgoal.irl.learn import learn as learn_everything
    from subgoal.posterior.sample import ConvergenceWarning, sample
    from subgoal.runtime.progress import progress_display

    draw = learn_everything if learn_all else sample
    display = progress_display("sampling", quiet=quiet)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return draw(likelihood, checkpoint=folder / CHECKPOINT, progress=display, **run)
