"""Nobody comes in without the token, by another name, or from another origin."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from pathlib import Path

import pytest
from websockets.exceptions import InvalidStatus

from subgoal.teach.app import page_files
from tests.teach.made import TOKEN, Server, served

PARTS = ["", *sorted(page_files())]
OTHERS = [
    "http://evil.example",
    "null",
    "https://127.0.0.1:PORT",
    "http://127.0.0.1:9",
    "http://127.0.0.1",
    "http://localhost:PORT",
]
HOSTS = ["evil.example", "evil.example:PORT", "127.0.0.1", "127.0.0.1:9", "127.0.0.1.evil.example:PORT",
         "192.168.0.7:PORT", "user@127.0.0.1:PORT", "127.0.0.1:PORT/x", "127.0.0.1:PORT?x",
         "127.0.0.1:PORT#x", "[", "127.0.0.1:x"]  # fmt: skip


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    with served(tmp_path_factory.mktemp("out")) as made:
        yield made


def refusal(server: Server, path: str = f"/{TOKEN}/live", **how: str | None) -> int:
    """Status with which a socket is refused, 0 where it is not."""
    try:
        with server.connected(path, **how):
            return 0
    except InvalidStatus as problem:
        return problem.response.status_code


@pytest.mark.parametrize("part", PARTS)
def test_every_part_of_the_page_is_served_with_the_token(part: str, server: Server) -> None:
    answer = server.get(f"/{TOKEN}/{part}", origin=server.address)
    assert answer.status_code == 200
    assert answer.content


@pytest.mark.parametrize("part", ["", "main.js"])
@pytest.mark.parametrize("token", ["wrong", "t0ke", "t0ken2", "T0KEN", "é", ""])
def test_without_the_token_nothing_is_there(part: str, token: str, server: Server) -> None:
    assert server.get(f"/{token}/{part}").status_code == 404


@pytest.mark.parametrize("path", ["/t0ken/nothing.js", "/t0ken/..%2f__init__.py", "/favicon.ico", "/t0ken/live"])
def test_nothing_else_is_there(path: str, server: Server) -> None:
    assert server.get(path).status_code == 404


@pytest.mark.parametrize("part", ["", "main.js"])
@pytest.mark.parametrize("origin", OTHERS)
def test_other_origins_get_neither_page_nor_parts(part: str, origin: str, server: Server) -> None:
    origin = origin.replace("PORT", str(server.port))
    assert server.get(f"/{TOKEN}/{part}", origin=origin).status_code == 403


@pytest.mark.parametrize("part", ["", "main.js"])
@pytest.mark.parametrize("host", HOSTS)
def test_other_names_for_this_machine_are_refused(part: str, host: str, server: Server) -> None:
    answer = server.get(f"/{TOKEN}/{part}", host=host.replace("PORT", str(server.port)))
    assert answer.status_code in (400, 403)


def test_parts_are_no_parts_of_other_pages(server: Server) -> None:
    asked = server.get(f"/{TOKEN}/main.js", sec_fetch_site="cross-site", sec_fetch_mode="no-cors")
    assert asked.status_code == 403


def test_a_link_to_the_page_may_be_followed(server: Server) -> None:
    followed = server.get(f"/{TOKEN}/", sec_fetch_site="cross-site", sec_fetch_mode="navigate")
    assert followed.status_code == 200


def test_the_socket_opens_for_the_page_itself(server: Server) -> None:
    assert refusal(server) == 0


def test_the_socket_needs_the_token(server: Server) -> None:
    assert refusal(server, "/wrong/live") == 403


@pytest.mark.parametrize("origin", [*OTHERS, None])
def test_the_socket_is_closed_to_other_origins_and_to_none(origin: str | None, server: Server) -> None:
    origin = origin.replace("PORT", str(server.port)) if origin else None
    assert refusal(server, origin=origin) == 403


def test_the_socket_is_closed_to_a_name_that_was_made_to_point_here(server: Server) -> None:
    assert refusal(server, host=f"evil.example:{server.port}") == 403


@pytest.mark.parametrize(("name", "known", "unknown"), [
    ("127.0.0.1", "localhost:PORT", "10.0.0.1:PORT"),
    ("::1", "[::1]:PORT", "[::2]:PORT"),
    ("localhost", "127.0.0.1:PORT", "other:PORT"),
    ("0.0.0.0", "192.168.1.7:PORT", "evil.example:PORT"),
    ("192.168.1.7", "192.168.1.7:PORT", "192.168.1.8:PORT"),
    ("lab.local", "lab.local:PORT", "127.0.0.1:PORT"),
])  # fmt: skip
def test_which_names_a_server_has(name: str, known: str, unknown: str, tmp_path: Path) -> None:
    with served(tmp_path, name=name) as server:
        for host, status in ((known, 200), (unknown, 403)):
            assert server.get(f"/{TOKEN}/", host=host.replace("PORT", str(server.port))).status_code == status


def test_each_kind_of_refusal_is_logged_once_without_what_was_asked(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.WARNING, "subgoal.teach"), served(tmp_path) as server:
        for k in range(3):
            server.get(f"/guess{k}/")
            server.get(f"/{TOKEN}/", origin="http://evil.example")
            server.get(f"/{TOKEN}/", host="evil.example")
    told = [record.getMessage() for record in caplog.records if record.name == "subgoal.teach"]
    assert sorted(text.split(" with ")[1].split(" than")[0] for text in told) == [
        "another Host", "another Origin", "another token",
    ]  # fmt: skip
    assert not any(word in text for text in told for word in ("guess", "evil", TOKEN))


@pytest.mark.parametrize("part", ["", "main.js", "nothing"])
def test_headers_keep_the_page_to_itself(part: str, server: Server) -> None:
    headers = server.get(f"/{TOKEN}/{part}").headers
    policy = headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert headers["cache-control"] == "no-store"
    assert headers["referrer-policy"] == "no-referrer"
    assert headers["x-content-type-options"] == "nosniff"


def test_the_page_asks_nobody_else_for_anything() -> None:
    for name, (content, _) in page_files().items():
        text = content.decode().replace("http://www.w3.org/2000/svg", "")
        assert "http://" not in text, name
        assert "https://" not in text, name
        assert "//cdn" not in text, name
