"""The executor seam: order kept, backends checked, the same draws from a Dask cluster."""

from __future__ import annotations

import os
import threading

import numpy as np
import pytest

import subgoal
from subgoal.runtime.errors import InputError, MissingExtraError
from subgoal.runtime.executor import run_all, worker_count


def test_answers_come_in_the_order_of_the_jobs() -> None:
    assert run_all(lambda k: k * k, [(k,) for k in range(20)], workers=4) == [k * k for k in range(20)]


def test_threads_share_this_process() -> None:
    places = run_all(lambda k: (os.getpid(), threading.get_ident()), [(k,) for k in range(4)], workers=2)
    assert {process for process, _ in places} == {os.getpid()}


@pytest.mark.parametrize("workers", [0, -1, 1.5, True])
def test_workers_are_counted_in_whole_numbers(workers: object) -> None:
    with pytest.raises(InputError, match="workers"):
        worker_count(workers)  # type: ignore[arg-type]


def test_unknown_backend_is_refused_by_name() -> None:
    with pytest.raises(InputError, match="'threading', 'loky', 'dask'"):
        run_all(abs, [(1,)], workers=1, backend="ray")


def test_dask_without_a_client_says_what_to_do() -> None:
    with pytest.raises((InputError, MissingExtraError), match=r"Client|subgoal\[dask\]"):
        run_all(abs, [(1,)], workers=1, backend="dask")


@pytest.mark.filterwarnings("ignore")
def test_a_dask_cluster_gives_the_same_draws() -> None:
    distributed = pytest.importorskip("distributed", reason="the dask extra is not installed")
    likelihood = subgoal.LogLikelihood.from_table(np.random.default_rng(0).normal(size=(40, 6)))
    here = subgoal.sample(likelihood, draws=20, warmup=5)
    with distributed.Client(n_workers=2, threads_per_worker=1, dashboard_address=None):
        there = subgoal.sample(likelihood, draws=20, warmup=5, backend="dask")
    np.testing.assert_array_equal(here.assignments, there.assignments)
