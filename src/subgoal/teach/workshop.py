"""Threads that compute while the event loop listens."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from enum import Enum
from functools import partial
from typing import Any, TypeVar

from subgoal.runtime.executor import worker_count

Found = TypeVar("Found")


class Lane(Enum):
    """Work that does not wait for that of another kind."""

    WAITED_FOR = "waited-for"
    """Somebody looks at the page and waits."""
    MEANWHILE = "meanwhile"
    """While the pen is down: what is not done now is done with the next points. One thing at a time."""
    IDLE = "idle"
    """When there is time."""


class Workshop:
    """Work of all sessions, with threads for each lane."""

    def __init__(self) -> None:
        threads = {Lane.WAITED_FOR: max(2, worker_count(None)), Lane.MEANWHILE: 1, Lane.IDLE: 1}
        self._pools = {lane: ThreadPoolExecutor(count, f"teach-{lane.value}") for lane, count in threads.items()}

    async def do(self, lane: Lane, work: Callable[..., Found], *arguments: Any) -> Found:
        """``work(*arguments)`` in a thread of the lane, once one is free."""
        return await asyncio.get_running_loop().run_in_executor(self._pools[lane], partial(work, *arguments))

    def close(self) -> None:
        """Leave what has not begun."""
        for pool in self._pools.values():
            pool.shutdown(wait=False, cancel_futures=True)
