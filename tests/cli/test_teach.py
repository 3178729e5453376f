"""The command that serves the page."""

from __future__ import annotations

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import pytest


def test_help_has_an_example(subgoal) -> None:
    answer = subgoal("teach", "--help")
    assert answer.code == 0
    assert "subgoal teach --out taught/" in answer.out


def test_it_serves_the_page_at_the_address_it_prints_and_ends_with_ctrl_c(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "subgoal.cli.main", "teach", "--no-open", "--out", str(tmp_path / "taught")]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        line = next((each for each in process.stdout if "http://" in each), "")
        address = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", line)
        assert address, line
        with urlopen(address[0], timeout=20) as page:
            assert b"Teach by drawing" in page.read()
    finally:
        os.kill(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=20)
    assert process.returncode in (0, 130)
    assert "Traceback" not in err
    assert address[0] not in out + err


def test_a_port_that_is_taken_is_told(subgoal, tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        answer = subgoal("teach", "--no-open", "--port", port, "--out", tmp_path)
    assert answer.code == 2
    assert f"found {port}, which is taken" in answer.err
    assert "Try: port 0" in answer.err


@pytest.mark.parametrize("port", ["-1", "70000"])
def test_a_port_that_is_none_is_refused(port: str, subgoal, tmp_path: Path) -> None:
    answer = subgoal("teach", "--no-open", "--port", port, "--out", tmp_path)
    assert answer.code == 2
    assert "port" in answer.err
