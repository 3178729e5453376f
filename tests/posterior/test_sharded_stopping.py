"""Sampling shards that is stopped by Ctrl-C, and goes on from its checkpoint."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior import checkpoint as checkpoints
from subgoal.posterior import sharded
from subgoal.runtime.errors import StoppedError, StorageError
from subgoal.runtime.progress import Silent
from subgoal.sharded import write_shards
from subgoal.storage.shards import BLOCK
from tests.posterior.test_sharded import RUN, assert_same, quiet
from tests.posterior.worlds import table


class CtrlC(Silent):
    """Presses Ctrl-C when so many sweeps of all chains are done."""

    def __init__(self, at: int) -> None:
        self.at = at

    def update(self, done: int, total: int, note: str = "") -> None:
        if done == self.at:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)


def test_ctrl_c_gives_the_draws_so_far_and_resuming_the_rest(tmp_path: Path) -> None:
    shards, run = write_shards(table(), tmp_path / "s"), {"draws": 40, "warmup": 10, "thin": 2}
    whole, path = quiet(shards, **run), tmp_path / "run.npz"
    part = quiet(shards, progress=CtrlC(4 * 40), checkpoint=path, **run)
    assert part.status.name == "INTERRUPTED"
    assert part.n_draws == 15
    np.testing.assert_array_equal(part.log_joint, whole.log_joint[:, :15])
    assert_same(quiet(shards, checkpoint=path, resume=True, **run), whole)
    assert not list(tmp_path.glob("run*"))


def test_ctrl_c_before_the_first_draw_is_told_and_kept(tmp_path: Path) -> None:
    shards, path = write_shards(table(), tmp_path / "s"), tmp_path / "run.npz"
    with pytest.raises(StoppedError):
        quiet(shards, progress=CtrlC(8), checkpoint=path, draws=5, warmup=5)
    assert_same(quiet(shards, checkpoint=path, resume=True, draws=5, warmup=5), quiet(shards, draws=5, warmup=5))


def test_a_run_resumes_over_other_files_and_never_over_other_numbers(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    likelihood = LogLikelihood.from_table(np.random.default_rng(0).normal(size=(2 * BLOCK + 9, 3)))
    one, three = (write_shards(likelihood, tmp_path / str(rows), rows=rows) for rows in (4 * BLOCK, BLOCK))
    assert (len(one.files.files), len(three.files.files)) == (1, 3)
    monkeypatch.setattr(checkpoints, "EVERY", 0.0)
    path = tmp_path / "run.npz"
    quiet(one, checkpoint=path, progress=CtrlC(4), **RUN)
    assert_same(quiet(three, checkpoint=path, resume=True, **RUN), quiet(one, **RUN))
    quiet(one, checkpoint=path, progress=CtrlC(4), **RUN)
    other = write_shards(table(), tmp_path / "other")
    with pytest.raises(StorageError, match="checkpoint setting 'data'"):
        quiet(other, checkpoint=path, resume=True, **RUN)
    with pytest.raises(StorageError, match="checkpoint setting 'seed'"):
        quiet(one, checkpoint=path, resume=True, **{**RUN, "seed": 7})


def test_a_sweep_that_fails_leaves_the_chains_as_they_were(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Streams of the weights too: Ctrl-C that ends worker processes loses the sweep and nothing else."""
    shards, path, run = write_shards(table(), tmp_path / "s"), tmp_path / "run.npz", {"draws": 10, "warmup": 0}
    whole, usual, calls = quiet(shards, **run), sharded.run_all, []

    def breaks(*arguments: Any, **settings: Any) -> list[Any]:
        calls.append(1)
        if len(calls) == 4:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.05)
            raise sharded.BrokenExecutor
        return usual(*arguments, **settings)

    monkeypatch.setattr(sharded, "run_all", breaks)
    assert quiet(shards, checkpoint=path, **run).n_draws == 3
    monkeypatch.setattr(sharded, "run_all", usual)
    assert_same(quiet(shards, checkpoint=path, resume=True, **run), whole)
