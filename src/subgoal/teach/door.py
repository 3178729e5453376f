"""Who may come in: the token, the Host and the Origin of every request, and the headers of every answer."""

from __future__ import annotations

import hmac
import ipaddress
import logging
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self' ws://{host}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}

LOG = logging.getLogger("subgoal.teach")


class Door:
    """Lets in what carries the token in its path, names this very server as its Host, and comes from no other origin.

    The Host must be the address that is listened on (or any loopback name for a loopback address, any address for all
    addresses): a name that somebody else makes point here (DNS rebinding) is none of these.
    """

    def __init__(self, app: ASGIApp, *, token: str, host: str, port: int) -> None:
        self._app, self._token, self._host, self._port = app, token, host, port
        self._logged: set[str] = set()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on or refuse."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        status, why = self._refusal(scope, headers)
        if why and why not in self._logged:
            self._logged.add(why)
            LOG.warning("refused a request with %s; others like it are not logged", why)
        if status == 0:
            await self._app(scope, receive, _with_headers(send, headers["host"]))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            await PlainTextResponse("Not here.", status)(scope, receive, _with_headers(send, "none"))

    def _refusal(self, scope: Scope, headers: Headers) -> tuple[int, str]:
        """0, or the status of the refusal, and why."""
        hosts, origins = headers.getlist("host"), headers.getlist("origin")
        if len(hosts) != 1 or not self._knows(hosts[0]):
            return 403, "another Host than this server's"
        if scope["type"] == "websocket" and len(origins) != 1:
            return 403, "no Origin"
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return 403, "another Origin than this server's"
        if headers.get("sec-fetch-site", "none") not in ("none", "same-origin") and (
            headers.get("sec-fetch-mode") != "navigate"
        ):
            return 403, "a page of another site behind it"
        token = scope["path"].split("/")[1] if scope["path"].startswith("/") else ""
        if hmac.compare_digest(token.encode("utf-8", "replace"), self._token.encode()):
            return 0, ""
        return 404, "another token than this server's"

    def _knows(self, host: str) -> bool:
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port or 80
        except ValueError:
            return False
        if port != self._port or parts.username is not None or parts.netloc != host:
            return False
        if name == self._host.lower():
            return True
        own, found = _address(self._host), _address(name)
        if own is not None and own.is_unspecified:
            return found is not None or name == "localhost"
        loopback = self._host == "localhost" or (own is not None and own.is_loopback)
        return loopback and (name == "localhost" or (found is not None and found.is_loopback))


def _address(name: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(name)
    except ValueError:
        return None


def _with_headers(send: Send, host: str) -> Send:
    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            headers.update({**HEADERS, "Content-Security-Policy": POLICY.format(host=host)})
        await send(message)

    return sent
