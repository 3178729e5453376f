"""Clusters by address: a client of a scheduler that answers, a typed error within the stated time otherwise."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator

import pytest

from subgoal.runtime.cluster import ClusterError, connect
from subgoal.runtime.errors import InputError

pytest.importorskip("distributed", reason="the dask extra is not installed")


@pytest.fixture
def listener() -> Iterator[str]:
    """A place where something takes calls and never says a word."""
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        yield f"tcp://127.0.0.1:{silent.getsockname()[1]}"


def refused_in_time(address: str) -> str:
    begin = time.monotonic()
    with pytest.raises(ClusterError) as refused:
        connect(address, timeout=1)
    assert time.monotonic() - begin < 10
    return str(refused.value)


def test_silence_is_refused_in_time_with_the_address(listener: str) -> None:
    assert listener in refused_in_time(listener)


def test_nobody_there_is_refused_in_time() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        place = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    assert "no answer within 1 s" in refused_in_time(place)


@pytest.mark.parametrize("address", ["", "  ", None, 8786, "nonsense", "10.0.0.5", "tcp://10.0.0.5:port"])
def test_what_is_no_address_is_refused_by_name(address: object) -> None:
    with pytest.raises(InputError, match="address: found"):
        connect(address)  # type: ignore[arg-type]


@pytest.mark.parametrize("timeout", [0, -1, float("nan"), float("inf")])
def test_patience_is_a_number_of_seconds(timeout: float) -> None:
    with pytest.raises(InputError, match="timeout"):
        connect("tcp://127.0.0.1:1", timeout=timeout)


def test_a_scheduler_gives_a_client_and_a_worker_none() -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None,
                      protocol="tcp://") as cluster:  # fmt: skip
        with connect(cluster.scheduler_address) as client:
            assert client.submit(abs, -3).result(timeout=20) == 3
        (worker,) = cluster.workers.values()
        assert "another kind (Worker)" in refused_in_time(worker.address)
