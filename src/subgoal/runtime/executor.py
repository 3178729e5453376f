"""The executor seam: joblib runs the work in threads by default, in processes or on a cluster on request."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from subgoal.runtime.checks import whole
from subgoal.runtime.errors import InputError, MissingExtraError

BACKENDS = ("threading", "loky", "dask")


def worker_count(workers: int | None) -> int:
    """``workers``, or the number of processor cores this process may use."""
    if workers is not None:
        return whole("workers", workers)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def run_all(
    function: Callable[..., Any], jobs: Iterable[tuple[Any, ...]], *, workers: int | None, backend: str = "threading"
) -> list[Any]:
    """``function(*job)`` for every job, in order: in threads, in processes ("loky"), or on a connected Dask cluster.

    One thread is this one: nothing is started for it.
    """
    return list(run_each(function, jobs, workers=workers, backend=backend))


def run_each(
    function: Callable[..., Any], jobs: Iterable[tuple[Any, ...]], *, workers: int | None, backend: str = "threading"
) -> Iterator[Any]:
    """As ``run_all``, each answer as soon as it and those before it are there."""
    from joblib import Parallel, delayed, parallel_config

    if backend not in BACKENDS:
        raise InputError("backend", found=repr(backend), wanted=", ".join(map(repr, BACKENDS)))
    if backend == "threading" and worker_count(workers) == 1:
        for job in jobs:
            yield function(*job)
        return
    try:
        config = parallel_config(backend, n_jobs=worker_count(workers))
    except ImportError:
        raise MissingExtraError("distributed", "dask") from None
    except ValueError as problem:
        hint = "dask.distributed.Client(address) before sampling"
        raise InputError("backend", found=str(problem), wanted="a connected Dask client", hint=hint) from None
    with config:
        yield from Parallel(return_as="generator")(delayed(function)(*job) for job in jobs)
