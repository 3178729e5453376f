"""Listening, and what is needed for it."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

from subgoal.runtime.errors import InputError, MissingExtraError
from subgoal.teach import serve
from subgoal.teach.server import bound, writable


@pytest.mark.parametrize("package", ["starlette", "uvicorn", "websockets"])
def test_without_the_extra_one_is_told_what_to_install(
    package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *more: None if name == package else find(name, *more))
    with pytest.raises(MissingExtraError, match=r"subgoal\[teach\]"):
        serve(tmp_path)


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_a_folder_that_cannot_be_written_in_is_refused_at_the_start(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("here")
    with pytest.raises(InputError, match=r"out: found .*wanted a folder that can be written in"):
        serve(tmp_path / name)


def test_a_folder_that_can_be_written_in_is_made_and_left_empty(tmp_path: Path) -> None:
    writable(tmp_path / "new" / "one")
    assert not any((tmp_path / "new" / "one").iterdir())


@pytest.mark.parametrize("host", ["no.such.host.invalid", "192.0.2.1"])
def test_a_host_that_is_not_this_machine_is_what_is_wrong(host: str) -> None:
    with pytest.raises(InputError, match=r"^host: .* of this machine"):
        bound(host, 0)


@pytest.mark.parametrize(("host", "port"), [("no.such.host.invalid", 0), ("127.0.0.1", 70_000), ("127.0.0.1", -1)])
def test_an_address_that_is_none_is_refused(host: str, port: int) -> None:
    with pytest.raises(InputError):
        bound(host, port)


def test_any_free_port_of_this_machine_alone() -> None:
    with bound("127.0.0.1", 0) as listening:
        host, port = listening.getsockname()
        assert (host, port > 1023) == ("127.0.0.1", True)
        with pytest.raises(InputError, match=r"^port: found .* taken, wanted a port that is free"):
            bound("127.0.0.1", port)
