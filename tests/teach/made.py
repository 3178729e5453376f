"""Drawings made by numbers, a server in a thread, and a page's side of the conversation."""

from __future__ import annotations

import http.client
import json
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import uvicorn
from websockets.sync.client import ClientConnection, connect

from subgoal.teach.app import make_app
from subgoal.teach.limits import Limits
from subgoal.teach.messages import Point
from subgoal.teach.server import bound, settings

TOKEN, LOOPBACK = "t0ken", "127.0.0.1"
PATIENCE = 20.0
CORNERS = np.array([[1.0, 0.5], [1.0, 2.5], [-1.0, 2.5], [-1.0, 0.5]])


def square(seconds: float = 8.0, rate: float = 60.0) -> list[Point]:
    """Points (t, y, z) along the corners, from the last of them and back to it, slow at each as a hand is."""
    count = round(seconds * rate / 4)
    far = (1 - np.cos(np.pi * np.arange(1, count + 1) / count))[:, None] / 2
    begins = np.roll(CORNERS, 1, axis=0)
    places = [begins[0][None], *(a + far * (b - a) for a, b in zip(begins, CORNERS, strict=True))]
    rows = np.vstack(places)
    return [(round(k / rate, 6), round(float(y), 6), round(float(z), 6)) for k, (y, z) in enumerate(rows)]


class Page:
    """What a page says, numbered as it must be, and what it hears."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket, self.number = socket, 0

    def hello(self, session: str | None = None, page: str = "page-0000") -> dict[str, Any]:
        """The welcome."""
        self.say({"type": "hello", "page": page, "session": session})
        welcome = self.hear("welcome")
        self.number = welcome["last"]
        return welcome

    def say(self, message: Any) -> None:
        """Send this as it is."""
        self.socket.send(message if isinstance(message, str) else json.dumps(message))

    def do(self, kind: str, **fields: Any) -> int:
        """An operation with the next number."""
        self.number += 1
        self.say({"type": kind, "number": self.number, **fields})
        return self.number

    def draw(self, points: list[Point], batch: int = 50) -> None:
        """A stroke."""
        self.do("begin")
        for k in range(0, len(points), batch):
            self.do("points", points=points[k : k + batch])
        self.do("lift")

    def hear(self, *kinds: str) -> dict[str, Any]:
        """The next message of one of these kinds."""
        while True:
            message: dict[str, Any] = json.loads(self.socket.recv(timeout=PATIENCE))
            if message["type"] in kinds:
                return message

    def answer(self, stage: str) -> dict[str, Any]:
        """The next answer of that stage; a full one to all that was done, not to an empty sheet before it."""
        while True:
            found = self.hear("answer")
            if found["stage"] == stage and (stage != "full" or found["number"] == self.number):
                return found

    def done(self, number: int | None = None) -> dict[str, Any]:
        """That all until ``number`` (default: the last) is done."""
        wanted = self.number if number is None else number
        while True:
            message = self.hear("done")
            if message["number"] >= wanted:
                return message


@dataclass(frozen=True)
class Reply:
    """Of a request; names of headers in small letters."""

    status_code: int
    headers: dict[str, str]
    content: bytes


@dataclass(frozen=True)
class Server:
    """One that listens on a port of this machine; ``name`` is what it takes for its own address."""

    port: int
    name: str = LOOPBACK

    @property
    def address(self) -> str:
        """Origin of its page."""
        return f"http://{LOOPBACK}:{self.port}"

    def get(self, path: str, **headers: str) -> Reply:
        """What stands at a path."""
        named = {name.replace("_", "-"): value for name, value in headers.items()}
        connection = http.client.HTTPConnection(LOOPBACK, self.port, timeout=PATIENCE)
        try:
            connection.request("GET", quote(path, safe="/%"), headers=named)
            answer = connection.getresponse()
            told = {name.lower(): value for name, value in answer.getheaders()}
            return Reply(answer.status, told, answer.read())
        finally:
            connection.close()

    @contextmanager
    def connected(
        self, path: str = f"/{TOKEN}/live", *, origin: str | None = "", host: str | None = None
    ) -> Iterator[Page]:
        """A page that has said nothing yet; ``origin`` is its own unless told otherwise."""
        line = socket.create_connection((LOOPBACK, self.port))
        host = host or f"{LOOPBACK}:{self.port}"
        origin = f"http://{host}" if origin == "" else origin
        with connect(f"ws://{host}{path}", sock=line, origin=origin, proxy=None, max_size=None) as opened:  # type: ignore[arg-type]
            yield Page(opened)

    @contextmanager
    def opened(self, page: str = "page-0000") -> Iterator[Page]:
        """A page with a new session."""
        with self.connected() as made:
            made.hello(None, page)
            yield made


@contextmanager
def served(out: Path, limits: Limits | None = None, name: str = LOOPBACK) -> Iterator[Server]:
    """A server in a thread."""
    listening = bound(LOOPBACK, 0)
    port = listening.getsockname()[1]
    limits = limits or Limits()
    server = uvicorn.Server(settings(make_app(token=TOKEN, host=name, port=port, out=out, limits=limits), limits))
    thread = threading.Thread(target=server.run, kwargs={"sockets": [listening]}, daemon=True)
    thread.start()
    try:
        while not server.started:
            time.sleep(0.005)
        yield Server(port, name)
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        listening.close()
