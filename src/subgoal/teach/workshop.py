"""Threads that compute while the event loop listens."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import Future
from enum import Enum
from functools import partial
from queue import SimpleQueue
from typing import Any, TypeVar

from subgoal.runtime.executor import worker_count

Found = TypeVar("Found")
Waiting = SimpleQueue[tuple[Future[Any], Callable[[], Any]] | None]


class Lane(Enum):
    """Work that does not wait for that of another kind."""

    WAITED_FOR = "waited-for"
    """Somebody looks at the page and waits."""
    MEANWHILE = "meanwhile"
    """While the pen is down: what is not done now is done with the next points. One thing at a time."""
    FLIGHT = "flight"
    """Flights, one at a time."""
    IDLE = "idle"
    """When there is time."""


class Workshop:
    """Work of all sessions, with threads for each lane.

    They are daemons: the process ends without waiting for what they compute.
    """

    def __init__(self) -> None:
        self._threads = dict.fromkeys(Lane, 1) | {Lane.WAITED_FOR: max(2, worker_count(None))}
        self._queues: dict[Lane, Waiting] = {lane: SimpleQueue() for lane in Lane}
        for lane, count in self._threads.items():
            for k in range(count):
                name = f"teach-{lane.value}-{k}"
                threading.Thread(target=_work_off, args=(self._queues[lane],), name=name, daemon=True).start()

    async def do(self, lane: Lane, work: Callable[..., Found], *arguments: Any) -> Found:
        """``work(*arguments)`` in a thread of the lane, once one is free; left out if cancelled before it begins."""
        future: Future[Found] = Future()
        self._queues[lane].put((future, partial(work, *arguments)))
        return await asyncio.wrap_future(future)

    def close(self) -> None:
        """Leave what has not begun."""
        for lane, queue in self._queues.items():
            while not queue.empty():
                queue.get()
            for _ in range(self._threads[lane]):
                queue.put(None)


def _work_off(queue: Waiting) -> None:
    while (given := queue.get()) is not None:
        future, work = given
        if not future.set_running_or_notify_cancel():
            continue
        try:
            found = work()
        except BaseException as problem:
            future.set_exception(problem)
        else:
            future.set_result(found)
