"""The server: warmed up, listening, and its address told."""

from __future__ import annotations

import errno
import importlib.util
import logging
import secrets
import socket
import tempfile
import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from subgoal.posterior.sample import ConvergenceWarning
from subgoal.runtime.checks import whole
from subgoal.runtime.errors import InputError, MissingExtraError
from subgoal.teach.limits import Limits

if TYPE_CHECKING:
    import uvicorn
    from starlette.applications import Starlette

NEEDED = ("starlette", "uvicorn", "websockets")
LOOPBACK = "127.0.0.1"
TOKEN_BYTES = 24
CONNECTIONS = 8
"""At once, for each session that there may be; a request beyond them is answered with 503."""
SPARE = 4096
"""Bytes of a message beside the file in it."""


def serve(
    out: str | Path = "out/teach", *, host: str = LOOPBACK, port: int = 0, open: bool = False,
    limits: Limits | None = None,
) -> None:  # fmt: skip
    """Serve the page until Ctrl-C; prints its address, which holds a secret token.

    The page shows whether a posterior has converged; ``ConvergenceWarning`` is silenced in this process.

    Parameters
    ----------
    out:
        Folder in which projects are saved.
    host, port:
        Where to listen; port 0 is any that is free. Everybody who can reach another host than a loopback one, and
        sees the address, can use the page: nothing is encrypted.
    open:
        Open the page in the browser.

    Raises
    ------
    MissingExtraError
        The extra ``teach`` is not installed.
    InputError
        The address cannot be listened on, or nothing can be written in ``out``.
    """
    limits = limits or Limits()
    for package in NEEDED:
        if importlib.util.find_spec(package) is None:
            raise MissingExtraError(package, "teach")
    import uvicorn

    from subgoal.teach.app import make_app
    from subgoal.teach.line import Once

    writable(Path(out))
    listening = bound(host, port)
    print("Starting; for the first time this takes some seconds.", flush=True)
    port, token = listening.getsockname()[1], secrets.token_urlsafe(TOKEN_BYTES)
    app = make_app(token=token, host=host, port=port, out=Path(out), limits=limits)
    warnings.simplefilter("ignore", ConvergenceWarning)
    warm_up()
    _tell(f"http://{f'[{host}]' if ':' in host else host}:{port}/{token}/", Path(out), open)
    server = uvicorn.Server(settings(app, limits))
    logging.getLogger("uvicorn.error").addFilter(Once())
    server.run(sockets=[listening])


def _tell(address: str, out: Path, open: bool) -> None:
    print(f"Teach at {address}\nProjects are saved in {out}. Ctrl-C ends.", flush=True)
    if open:
        import webbrowser

        webbrowser.open(address)


def settings(app: Starlette, limits: Limits) -> uvicorn.Config:
    """Of the server: it writes no address to any log, and takes no message larger than a file."""
    import uvicorn

    from subgoal.teach.line import PatientProtocol

    return uvicorn.Config(
        app, http=PatientProtocol, limit_concurrency=CONNECTIONS * limits.sessions, log_level="warning",
        access_log=False, server_header=False, ws="websockets-sansio", ws_max_size=limits.file_bytes + SPARE,
        ws_per_message_deflate=False, timeout_graceful_shutdown=1,
    )  # fmt: skip


def writable(out: Path) -> None:
    """Make the folder, and raise ``InputError`` where nothing can be written in it."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".teaching-", dir=out):
            pass
    except OSError as problem:
        raise InputError("out", found=f"{out} ({problem.strerror})", wanted="a folder that can be written in",
                         hint="another folder") from None  # fmt: skip


def bound(host: str, port: int) -> socket.socket:
    """A socket that listens there."""
    if whole("port", port, least=0) > 65_535:
        raise InputError("port", found=port, wanted="at most 65535")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family)
    except OSError as problem:
        raise _not_bound(host, port, problem) from None


def _not_bound(host: str, port: int, problem: OSError) -> InputError:
    if isinstance(problem, socket.gaierror) or problem.errno == errno.EADDRNOTAVAIL:
        return InputError("host", found=host, wanted="a name or an address of this machine",
                          hint=f"{LOOPBACK}, or 0.0.0.0 for all its addresses")  # fmt: skip
    if problem.errno == errno.EADDRINUSE:
        return InputError("port", found=f"{port}, which is taken", wanted="a port that is free", hint="port 0")
    return InputError("port", found=f"{host}:{port} ({problem.strerror})", wanted="a port that may be listened on",
                      hint="port 0")  # fmt: skip


def warm_up() -> None:
    """Learn from a small drawing, so that everything is loaded and compiled before anybody waits for it."""
    from subgoal.teach.drawing import Drawing
    from subgoal.teach.learning import SETTLED, Tuning, demonstrations_of, learn
    from subgoal.teach.live import Live

    drawing = Drawing(Limits())
    drawing.begin()
    drawing.add(tuple((0.05 * k, 0.04 * min(k, 20), 0.5 + 0.04 * max(k - 20, 0)) for k in range(41)))
    Live().answer(drawing.sheet(), Tuning())
    drawing.lift()
    learn(demonstrations_of(drawing.sheet().recording()), Tuning(), SETTLED)
