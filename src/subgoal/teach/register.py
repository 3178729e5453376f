"""All sessions of a server, by name."""

from __future__ import annotations

import asyncio
import secrets
import time
from pathlib import Path

from subgoal.teach.limits import Limits
from subgoal.teach.messages import Hello, RefusedError
from subgoal.teach.outbox import Outbox
from subgoal.teach.session import Session
from subgoal.teach.workshop import Workshop

LOOK_AGAIN = 0.05


class Register:
    """Gives each page its session: the one it had, or a new one."""

    def __init__(self, limits: Limits, out: Path) -> None:
        self._limits, self._out = limits, out
        self._workshop = Workshop()
        self._sessions: dict[str, Session] = {}

    async def welcome(self, hello: Hello, outbox: Outbox) -> Session:
        """The session of a page, attached to it.

        A page that lost its connection takes its session up at once. One that was loaded anew waits for the one before
        it to go; where that stays, it is a tab that was copied, and gets a session of its own. Raises ``RefusedError``
        where there are too many.
        """
        session = self._sessions.get(hello.session or "")
        until = time.monotonic() + self._limits.take_over_seconds
        while session is not None and session.present and session.page != hello.page:
            if time.monotonic() > until:
                session = None
                break
            await asyncio.sleep(LOOK_AGAIN)
        if session is None or session.name not in self._sessions:
            session = self._new()
        session.attach(hello.page, outbox)
        return session

    def _new(self) -> Session:
        if len(self._sessions) >= self._limits.sessions:
            away = [each for each in self._sessions.values() if not each.present]
            if not away:
                raise RefusedError("full", f"{self._limits.sessions} pages are open already. Close one.")
            oldest = min(away, key=lambda each: (each.used, each.left))
            oldest.close()
            del self._sessions[oldest.name]
        session = Session(secrets.token_urlsafe(16), self._limits, self._workshop, self._out)
        self._sessions[session.name] = session
        return session

    def close(self) -> None:
        """The server ends."""
        for session in self._sessions.values():
            session.close()
        self._workshop.close()
