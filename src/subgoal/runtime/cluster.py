"""A Dask cluster, reached by the address of its scheduler or refused within a stated time."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from importlib import import_module
from typing import Any

from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError, MissingExtraError

PATIENCE = 5.0
"""Seconds that a scheduler has to answer."""
ADDRESS = 'the address of a scheduler, "tcp://host:port"'
HINT = "dask scheduler and dask worker on the machines of the cluster, and the address that the scheduler prints"


class ClusterError(InputError):
    """A Dask scheduler does not answer, or its cluster has no workers."""


def connect(address: str, *, timeout: float = PATIENCE) -> Any:
    """A ``dask.distributed.Client`` of the scheduler at ``address``, such as "tcp://10.0.0.5:8786".

    It is the default client until it is closed, so that ``backend="dask"`` finds it; use it in a ``with`` statement.
    Raises ``ClusterError`` when no scheduler answers there within ``timeout`` seconds, ``InputError`` for an address
    that is none, and ``MissingExtraError`` without the extra ``dask``.
    """
    seconds = positive("timeout", timeout)
    if not isinstance(address, str) or not address.strip():
        raise InputError("address", found=repr(address), wanted=ADDRESS)
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise MissingExtraError("distributed", "dask") from None
    place = address.strip()
    try:
        distributed.comm.addressing.parse_host_port(place.split("://")[-1])
    except ValueError as problem:
        raise InputError("address", found=f"{address!r} ({problem})", wanted=ADDRESS) from None
    answer = _identity(place, seconds)
    if answer != "Scheduler":
        said = f"no answer within {seconds:g} s" if answer is None else f"an answer of another kind ({answer})"
        raise ClusterError("Dask scheduler", where=place, found=said, wanted="one that answers", hint=HINT)
    return distributed.Client(place, timeout=seconds)


def connected(client: Any = None) -> tuple[Any, int]:
    """``client``, or the one that is connected, and how many threads its cluster has.

    Raises ``InputError`` where none is connected and ``ClusterError`` for a cluster without workers.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise MissingExtraError("distributed", "dask") from None
    try:
        found = distributed.get_client() if client is None else client
    except ValueError as problem:
        raise InputError("client", found=str(problem), wanted="a connected Dask client",
                         hint="connect(address) before sampling") from None  # fmt: skip
    if not isinstance(found, distributed.Client):
        raise InputError("client", found=type(found).__name__, wanted="a dask.distributed.Client")
    threads = sum(found.nthreads().values())
    if not threads:
        raise ClusterError("Dask cluster", found="no workers", wanted="at least one", hint=HINT)
    return found, threads


def run_on(client: Any, function: Callable[..., Any], jobs: Iterable[tuple[Any, ...]]) -> list[Any]:
    """``function(*job)`` for every job on the cluster, in order; what a lost worker had is given to another.

    Raises ``ClusterError`` where a job was lost with several workers, and where the scheduler is lost; whatever else
    the function raises comes as it is.
    """
    distributed: Any = import_module("distributed")
    try:
        answers: list[Any] = client.gather([client.submit(function, *job, pure=False) for job in jobs])
    except distributed.KilledWorker:
        raise ClusterError(
            "Dask cluster", found="work that was lost with every worker it was given to", wanted="workers that stay",
            hint="workers with more memory; the checkpoint can be resumed",
        ) from None  # fmt: skip
    except (CancelledError, distributed.client.FutureCancelledError, OSError) as problem:
        if isinstance(problem, OSError) and client.status == "running":
            raise
        raise ClusterError("Dask scheduler", found="a lost connection", wanted="one that stays",
                           hint="connect again; the checkpoint can be resumed") from None  # fmt: skip
    return answers


def _identity(address: str, seconds: float) -> str | None:
    """What listens at ``address`` says it is, or what went wrong; None for silence.

    Asked in a thread that may be left waiting: a client of its own would wait for ever for what never says a word.
    """
    answer: list[str] = []

    async def ask() -> None:
        core: Any = import_module("distributed.core")
        async with core.rpc(address, timeout=seconds) as peer:
            answer.append(str((await asyncio.wait_for(peer.identity(), seconds)).get("type")))

    def attempt() -> None:
        try:
            asyncio.run(ask())
        except (OSError, TimeoutError):
            return
        except Exception as problem:
            answer.append(f"{type(problem).__name__}: {problem}")

    asking = threading.Thread(target=attempt, daemon=True)
    asking.start()
    asking.join(seconds)
    return answer[0] if answer else None
