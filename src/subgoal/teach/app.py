"""The page, its parts, and the socket over which it speaks."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from subgoal.plots.style import OTHER_COLOUR, PALETTE, ink_on
from subgoal.teach.door import Door
from subgoal.teach.limits import Limits
from subgoal.teach.messages import Hello, RefusedError, parse
from subgoal.teach.outbox import Outbox
from subgoal.teach.register import Register
from subgoal.teach.session import Session

KINDS = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
FIRST_PATIENCE = 10.0
"""Seconds within which a connection must say hello."""
FIRST_TRIES = 20
LAST_PATIENCE = 2.0
"""Seconds for what is still to be sent."""


def page_files() -> dict[str, tuple[bytes, str]]:
    """Content and media type of each file of the page, by name."""
    folder = resources.files("subgoal.teach") / "page"
    colours = {"palette": list(PALETTE), "inks": [ink_on(each) for each in PALETTE], "other": OTHER_COLOUR}
    made = {"colours.js": (f"export const COLOURS = {json.dumps(colours)};\n".encode(), KINDS["js"])}
    return made | {
        each.name: (each.read_bytes(), KINDS[each.name.rpartition(".")[2]])
        for each in folder.iterdir()
        if each.name.rpartition(".")[2] in KINDS
    }


def make_app(*, token: str, host: str, port: int, out: Path, limits: Limits | None = None) -> Starlette:
    """The application behind its door, for ``host:port``; projects are saved in ``out``."""
    limits = limits or Limits()
    files, register = page_files(), Register(limits, out)

    async def part(request: Request) -> Response:
        name = request.path_params.get("name", "index.html")
        if name not in files:
            return PlainTextResponse("Not here.", 404)
        content, kind = files[name]
        return Response(content, media_type=kind)

    async def live(socket: WebSocket) -> None:
        await _converse(socket, register, limits)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        yield
        register.close()

    return Starlette(
        routes=[
            Route("/{token}/", part), WebSocketRoute("/{token}/live", live), Route("/{token}/{name}", part),
        ],
        middleware=[Middleware(Door, token=token, host=host, port=port)],
        lifespan=lifespan,
    )  # fmt: skip


async def _converse(socket: WebSocket, register: Register, limits: Limits) -> None:
    """With one page, until it goes."""
    await socket.accept()
    outbox = Outbox()
    sending = asyncio.create_task(_send_all(socket, outbox))
    try:
        session = await _hello(socket, register, outbox, limits)
        await _listen(socket, session, outbox)
    except (WebSocketDisconnect, TimeoutError):
        pass
    finally:
        outbox.close()
        with suppress(TimeoutError, RuntimeError, WebSocketDisconnect):
            await asyncio.wait_for(sending, LAST_PATIENCE)
            await socket.close(1008)


async def _hello(socket: WebSocket, register: Register, outbox: Outbox, limits: Limits) -> Session:
    """The session of a page that has said hello; one that says other things too often is left."""
    for _ in range(FIRST_TRIES):
        message = await asyncio.wait_for(_receive(socket), FIRST_PATIENCE)
        try:
            hello = parse(message, limits)
            if not isinstance(hello, Hello):
                raise RefusedError("out-of-order", "hello comes first")
            return await register.welcome(hello, outbox)
        except RefusedError as problem:
            outbox.put({"type": "error", "code": problem.code, "text": problem.text})
    raise WebSocketDisconnect(1008)


async def _listen(socket: WebSocket, session: Session, outbox: Outbox) -> None:
    try:
        while True:
            session.receive(await _receive(socket), outbox)
    finally:
        session.detach(outbox)


async def _receive(socket: WebSocket) -> str | bytes:
    message: Any = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1005))
    text: str | bytes | None = message.get("text")
    return text if text is not None else message["bytes"]


async def _send_all(socket: WebSocket, outbox: Outbox) -> None:
    """Send what comes until the page has gone."""
    with suppress(WebSocketDisconnect, RuntimeError, OSError):
        while waiting := await outbox.take():
            for message in waiting:
                await socket.send_text(json.dumps(message, allow_nan=False))
