"""Connections that send half a request, or none."""

from __future__ import annotations

import logging
import socket
import time
from pathlib import Path

import pytest

from subgoal.teach.line import INVALID, Once, PatientProtocol
from tests.teach.made import LOOPBACK, TOKEN, served


def closed(port: int, *pieces: bytes) -> bool:
    """Whether the server closes a connection that sends these, one after the other, and then waits."""
    with socket.create_connection((LOOPBACK, port), timeout=3) as line:
        for piece in pieces:
            line.sendall(piece)
            time.sleep(0.05)
        try:
            while line.recv(65536):
                pass
        except TimeoutError:
            return False
        return True


def test_half_a_request_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PatientProtocol, "head_seconds", 0.2)
    with served(tmp_path) as server:
        assert closed(server.port, b"GET / HTTP/1.1\r\n", b"Host: a")


def test_half_a_second_request_is_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PatientProtocol, "head_seconds", 0.2)
    with served(tmp_path) as server:
        whole = f"GET /{TOKEN}/ HTTP/1.1\r\nHost: {LOOPBACK}:{server.port}\r\n\r\n".encode()
        assert closed(server.port, whole, b"GET / HTTP/1.1\r\n")


def test_a_page_that_speaks_is_not_left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PatientProtocol, "head_seconds", 0.1)
    with served(tmp_path) as server, server.opened() as page:
        time.sleep(0.4)
        page.do("begin")
        assert page.done()["number"] == 1


def test_what_is_no_request_is_logged_once() -> None:
    once = Once()
    records = [logging.LogRecord("n", logging.WARNING, "", 0, text, (), None) for text in (INVALID, INVALID, "else")]
    assert [once.filter(record) for record in records] == [True, False, True]
