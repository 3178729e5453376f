"""Tests run in a process of their own that begins with the libraries imported: importing costs more than most tests."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
FORKED = multiprocessing.get_context("forkserver")
FORKED.set_forkserver_preload([
    "numpy", "scipy.optimize", "scipy.stats", "scipy.sparse.linalg", "scipy.signal", "scipy.spatial.transform", "numba",
    "pandas", "pyarrow", "matplotlib.figure", "sklearn.gaussian_process", "sklearn.neighbors", "hypothesis.strategies",
    "joblib", "pytest",
])  # fmt: skip
STOPPED, ELSEWHERE = -1, 99


class Outcome(NamedTuple):
    """pytest's exit status, or one of those above: it was stopped, or the package came from another place."""

    status: int | None
    printed: str


def run_tests(folder: Path, loops: Path, log: Path, *tests: str, longest: float, compiled: bool = True) -> Outcome:
    """pytest on the package in ``folder``; ``loops`` keeps what is compiled, ``log`` what is printed.

    After ``longest`` seconds the run is stopped.
    """
    process = FORKED.Process(target=_pytest, args=(folder, loops, log, tests, compiled))
    process.start()
    process.join(longest)
    if process.is_alive():
        process.kill()
        process.join()
        return Outcome(STOPPED, log.read_text())
    return Outcome(process.exitcode, log.read_text())


def _pytest(folder: Path, loops: Path, log: Path, tests: tuple[str, ...], compiled: bool) -> None:
    """The child: it knows the libraries but has not yet imported the package, which it finds in ``folder``.

    It takes itself for a process of its own, not for somebody's worker, which would leave Ctrl-C to others.
    """
    stream = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for each in (1, 2):
        os.dup2(stream, each)
    multiprocessing.process._parent_process = None
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.chdir(ROOT)
    os.environ |= {
        "PYTHONPATH": str(folder / "src"), "NUMBA_CACHE_DIR": str(loops), "PYTHONDONTWRITEBYTECODE": "1",
        "NUMBA_DISABLE_JIT": str(int(not compiled)),
    }  # fmt: skip
    sys.path.insert(0, str(folder / "src"))
    sys.dont_write_bytecode = True
    import numba
    import pytest

    import subgoal

    if not Path(subgoal.__file__).is_relative_to(folder):
        sys.exit(ELSEWHERE)
    numba.config.reload_config()
    command = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not t2"]
    sys.exit(int(pytest.main([*command, *(f"tests/{test}" for test in tests)])))
