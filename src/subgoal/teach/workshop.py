"""Threads that compute while the event loop listens."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

from subgoal.runtime.executor import worker_count

Found = TypeVar("Found")


class Workshop:
    """Work of all sessions: what a hand waits for in one pool, what has time in another with one thread."""

    def __init__(self) -> None:
        self._prompt = ThreadPoolExecutor(max(2, worker_count(None)), "teach-prompt")
        self._patient = ThreadPoolExecutor(1, "teach-patient")

    async def now(self, work: Callable[..., Found], *arguments: Any) -> Found:
        """``work(*arguments)`` in a thread, as soon as one is free."""
        return await asyncio.get_running_loop().run_in_executor(self._prompt, partial(work, *arguments))

    async def later(self, work: Callable[..., Found], *arguments: Any) -> Found:
        """The same, after other work of this kind, and never in the way of ``now``."""
        return await asyncio.get_running_loop().run_in_executor(self._patient, partial(work, *arguments))

    def close(self) -> None:
        """Leave what has not begun."""
        for pool in (self._prompt, self._patient):
            pool.shutdown(wait=False, cancel_futures=True)
