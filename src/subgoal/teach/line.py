"""Connections: a request that is not whole in time is left, and what is no request is logged once."""

from __future__ import annotations

import asyncio
import logging
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

HEAD_SECONDS = 10.0
"""Within which the head of a request must be there."""
INVALID = "Invalid HTTP request received."


class PatientProtocol(H11Protocol):
    """HTTP that is closed where ``HEAD_SECONDS`` pass without a request, though something may trickle in."""

    head_seconds = HEAD_SECONDS

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait."""
        super().connection_made(transport)
        self._last_request: Any = None
        self.loop.call_later(self.head_seconds, self._look)

    def _look(self) -> None:
        if self.transport.is_closing() or self.transport.get_protocol() is not self:
            return
        waiting = self.cycle is None or self.cycle.response_complete
        if waiting and self.cycle is self._last_request:
            self.transport.close()
            return
        self._last_request = self.cycle
        self.loop.call_later(self.head_seconds, self._look)


class Once(logging.Filter):
    """Lets the complaint of what is no HTTP through once."""

    def __init__(self) -> None:
        super().__init__()
        self._said = False

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether to log it."""
        if record.getMessage() != INVALID:
            return True
        said, self._said = self._said, True
        return not said
