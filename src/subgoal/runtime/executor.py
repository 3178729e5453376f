"""The executor seam: joblib runs the work in threads by default, in processes or on a cluster on request."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import Any

from subgoal.runtime.checks import whole


def worker_count(workers: int | None) -> int:
    """``workers``, or the number of processor cores this process may use."""
    if workers is not None:
        return whole("workers", workers)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def run_all(
    function: Callable[..., Any], jobs: Iterable[tuple[Any, ...]], *, workers: int | None, backend: str = "threading"
) -> list[Any]:
    """``function(*job)`` for every job, in order. ``backend`` is any joblib backend ("threading", "loky", "dask")."""
    from joblib import Parallel, delayed

    return list(Parallel(n_jobs=worker_count(workers), backend=backend)(delayed(function)(*job) for job in jobs))
