"""Bounds of groups of goals side by side: in threads, processes or on a cluster, kept on disk by content."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np

from subgoal.mdp.planners.growing import Bounds, Settings
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.runtime.errors import InputError, StorageError
from subgoal.runtime.executor import run_each
from subgoal.runtime.progress import Progress
from subgoal.runtime.version import VERSION
from subgoal.storage.archive import digest_arrays, read_archive, write_archive

KIND = "bounds of a group of goals"
ATTEMPTS = 4
"""Times that work is begun again after a process that did it has died."""
Job = tuple[Any, list[Any], Any, Settings]
"""World, goals, states and settings of one group."""


def over_groups(
    plan: Callable[..., Bounds],
    jobs: Sequence[Job],
    sizes: Sequence[int],
    *,
    workers: int | None,
    backend: str,
    cache: str | Path | None,
    progress: Progress,
) -> list[Bounds]:
    """``plan(*job)`` of every job, in order; what a dead process had in hand is done again, nothing else.

    ``progress`` is told how many goals are done, of the sum of ``sizes``.
    """
    folder = None if cache is None else _folder(Path(cache), jobs[0][0])
    known = "" if folder is None else str(jobs[0][0].fingerprint())
    paths = [None if folder is None else folder / f"{_key(known, job)}.npz" for job in jobs]
    solved: list[Bounds] = []
    with progress as display:
        display.update(0, sum(sizes))
        for attempt in range(ATTEMPTS):
            left = [(plan, job, path) for job, path in zip(jobs, paths, strict=True)][len(solved) :]
            try:
                for each in run_each(_planned_or_kept, left, workers=workers, backend=backend):
                    solved.append(each)
                    display.update(sum(sizes[: len(solved)]), sum(sizes))
                return solved
            except Exception as problem:
                if attempt == ATTEMPTS - 1 or not _died(problem):
                    raise
    return solved


def _planned_or_kept(plan: Callable[..., Bounds], job: Job, path: Path | None) -> Bounds:
    if path is not None and path.exists():
        try:
            return _kept(path)
        except StorageError:
            path.unlink(missing_ok=True)
    made = plan(*job)
    if path is not None:
        _keep(path, made)
    return made


def _keep(path: Path, bounds: Bounds) -> None:
    numbers = bounds._asdict() | {"status": bounds.status.name}
    arrays = {name: numbers.pop(name) for name in ("value", "rows")}
    write_archive(path, KIND, numbers, arrays, keep_previous=False)


def _kept(path: Path) -> Bounds:
    header, arrays = read_archive(path, KIND)
    numbers = {name: header[name] for name in Bounds._fields if name in header} | arrays
    return Bounds(**(numbers | {"status": PlanStatus[header["status"]]}))


def _folder(folder: Path, world: Any) -> Path:
    if world.fingerprint() is None:
        wanted = "one that is known again: a table, a map, or an ImplicitGrid with a name="
        raise InputError("cache", found=f"{world!r}, which is told by a function", wanted=wanted)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise InputError("cache", found=str(problem), wanted="a folder that can be written") from None
    return folder


def _key(known: str, job: Job) -> str:
    """What a group's bounds are kept under: the same for the same world, goals, states, settings and version."""
    _, goals, states, settings = job
    words = np.frombuffer(f"{VERSION} {known} {astuple(settings)}".encode(), np.uint8)
    return digest_arrays(words, states, *goals)


def _died(problem: Exception) -> bool:
    """Whether a process went away, as opposed to the work failing."""
    from concurrent.futures.process import BrokenProcessPool

    return isinstance(problem, BrokenProcessPool) or type(problem).__name__ in ("KilledWorker", "TerminatedWorkerError")
