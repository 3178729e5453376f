"""What waits to be sent: of answers and acknowledgements only the newest, so that a slow page falls no farther back."""

from __future__ import annotations

import asyncio
from typing import Any

NEWEST = ("answer", "done")
"""Kinds of which a newer message takes the place of one that waits."""
MOST_WAITING = 200


class Outbox:
    """Messages for one page, taken in order by whoever sends them."""

    def __init__(self) -> None:
        self._waiting: list[dict[str, Any]] = []
        self._news = asyncio.Event()
        self.closed = False

    def put(self, message: dict[str, Any]) -> None:
        """Send this next; errors that nobody reads are dropped beyond a bound."""
        if self.closed:
            return
        kind = message["type"]
        if kind in NEWEST:
            self._waiting = [each for each in self._waiting if each["type"] != kind]
        if len(self._waiting) < MOST_WAITING or kind != "error":
            self._waiting.append(message)
        self._news.set()

    def close(self) -> None:
        """Nothing more is sent than what waits."""
        self.closed = True
        self._news.set()

    async def take(self) -> list[dict[str, Any]]:
        """All that waits, once there is something; nothing when it is closed and empty."""
        if not self._waiting and not self.closed:
            self._news.clear()
            await self._news.wait()
        waiting, self._waiting = self._waiting, []
        return waiting
