"""Sampling shards on a Dask cluster of processes: the same draws, also when a worker is killed."""

from __future__ import annotations

import logging
import os
import signal
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.cluster import run_on
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent
from subgoal.sharded import ClusterError, Shards, connect, write_shards
from subgoal.storage.shards import BLOCK
from tests.posterior.test_sharded import assert_same, quiet

distributed = pytest.importorskip("distributed", reason="the dask extra is not installed")
RUN: dict[str, Any] = {"draws": 12, "warmup": 2, "chains": 2, "seed": 5}


@pytest.fixture(scope="module")
def shards(tmp_path_factory: pytest.TempPathFactory) -> Shards:
    likelihood = LogLikelihood.from_table(np.random.default_rng(0).normal(scale=2, size=(3 * BLOCK + 9, 3)))
    return write_shards(likelihood, tmp_path_factory.mktemp("s") / "s", rows=BLOCK)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        connect(cluster.scheduler_address, timeout=9) as client,
    ):  # fmt: skip
        yield client


def test_a_cluster_gives_the_draws_of_one_thread(shards: Shards, client: Any) -> None:
    assert_same(quiet(shards, backend="dask", client=client, **RUN), quiet(shards, **RUN))


def test_the_connected_client_is_found(shards: Shards, client: Any) -> None:
    run = {**RUN, "draws": 1}
    assert_same(quiet(shards, backend="dask", **run), quiet(shards, **run))


def test_a_worker_killed_in_a_sweep_changes_nothing(shards: Shards, client: Any) -> None:
    victim = next(iter(client.run(os.getpid).values()))

    class Killer(Silent):
        def update(self, done: int, total: int, note: str = "") -> None:
            if done == 8:
                threading.Timer(0.01, os.kill, (victim, signal.SIGKILL)).start()

    found = quiet(shards, backend="dask", client=client, progress=Killer(), **RUN)
    assert victim not in client.run(os.getpid).values()
    assert_same(found, quiet(shards, **RUN))


def test_a_cluster_without_workers_is_told(shards: Shards) -> None:
    with (
        distributed.LocalCluster(n_workers=0, dashboard_address=":0", processes=False) as cluster,
        distributed.Client(cluster, set_as_default=False) as idle,
        pytest.raises(ClusterError, match="no workers"),
    ):
        quiet(shards, backend="dask", client=idle, **RUN)


def test_work_that_kills_its_workers_is_told() -> None:
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0",
                                 silence_logs=logging.CRITICAL) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
        pytest.raises(ClusterError, match="lost with every worker"),
    ):  # fmt: skip
        run_on(client, os._exit, [(1,)])


def test_a_lost_scheduler_is_told() -> None:
    cluster = distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0",
                                       silence_logs=logging.CRITICAL)  # fmt: skip
    with distributed.Client(cluster, set_as_default=False) as client:
        threading.Timer(0.3, cluster.close).start()
        with pytest.raises(ClusterError, match="lost connection"):
            run_on(client, time.sleep, [(3,)])


def test_what_the_work_raises_comes_as_it_is(client: Any) -> None:
    with pytest.raises(FileNotFoundError, match="nowhere"):
        run_on(client, os.stat, [("/nowhere",)])


def test_a_client_is_for_the_cluster_alone(shards: Shards, client: Any) -> None:
    with pytest.raises(InputError, match="backend='dask'"):
        quiet(shards, client=client, **RUN)
