"""A run killed at any moment goes on from its checkpoint and gives the draws of an unbroken one."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import warnings
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import subgoal
from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior import checkpoint as checkpoints
from subgoal.posterior import rounds
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.errors import InputError, StorageError, SubgoalError
from subgoal.storage.archive import previous
from tests.posterior.worlds import assert_same_posterior, corner_likelihood, quiet_sample, table
from tests.robustness.resume_child import RUN

ROOT = Path(__file__).parents[2]
DRAWS = 3000


def child(path: Path, out: Path, how: str, draws: int = DRAWS) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "tests.robustness.resume_child", str(path), str(out), how, str(draws)]
    return subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)


@lru_cache
def unbroken_run(draws: int) -> Posterior:
    return quiet_sample(table(), draws=draws, **RUN)


def resumed_as_unbroken(path: Path, out: Path, draws: int = DRAWS) -> None:
    """Resume in a fresh process and compare every number with the unbroken run, made here."""
    assert child(path, out, "resume", draws).wait(60) == 0
    unbroken = unbroken_run(draws)
    wanted = {"assignments": unbroken.assignments, "joint": unbroken.log_joint, "best": unbroken.best_assignment,
              "shares": unbroken.shares.toarray(), **unbroken.traces}  # fmt: skip
    with np.load(out) as got:
        for name, array in wanted.items():
            np.testing.assert_array_equal(got[name], array, err_msg=name)
    assert not list(path.parent.glob(f"{path.name}*"))


@pytest.mark.parametrize("how", ["kill:1:half", "kill:3:half", "kill:1:second", "kill:3:first", "kill:4:second"])
def test_killed_inside_a_write(how: str, tmp_path: Path) -> None:
    """Half of the temporary file, before the old file is set aside, and between the two renames."""
    path, out = tmp_path / "run.npz", tmp_path / "out.npz"
    assert child(path, out, how).wait(60) == -signal.SIGKILL
    assert not out.exists()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        resumed_as_unbroken(path, out)


def killed_at(delay: float, path: Path, out: Path, draws: int) -> int:
    process = child(path, out, "run", draws)
    assert process.stdout is not None
    assert process.stdout.readline() == "go\n"
    time.sleep(delay)
    process.kill()
    return process.wait(60)


def test_killed_at_a_random_moment(tmp_path: Path) -> None:
    path, out = tmp_path / "run.npz", tmp_path / "out.npz"
    assert killed_at(0.5, path, out, 5_000) == -signal.SIGKILL
    resumed_as_unbroken(path, out, 5_000)


@pytest.mark.t2
@pytest.mark.parametrize("moment", range(30))
def test_killed_at_thirty_random_moments(moment: int, tmp_path: Path) -> None:
    """Moments spread over a run of about a second; a run that ends before its moment has nothing to resume."""
    path, out, draws = tmp_path / "run.npz", tmp_path / "out.npz", 5_000
    delay = float(np.random.default_rng(moment).uniform(0.0, 1.5))
    if killed_at(delay, path, out, draws) == 0:
        assert out.exists()
        assert not path.exists()
    resumed_as_unbroken(path, out, draws)


@pytest.fixture(autouse=True)
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short rounds and a checkpoint after each."""
    monkeypatch.setattr(checkpoints, "EVERY", 0.0)
    monkeypatch.setattr(checkpoints, "LARGEST_COST", 1e9)
    monkeypatch.setitem(rounds.ROUND_SECONDS, "threading", 0.01)


@pytest.fixture
def stopped(tmp_path: Path) -> Path:
    """The checkpoint of a run that stopped half-way, and the one before it."""
    return stop_after(0.4, tmp_path / "run.npz", table())


def stop_after(share: float, path: Path, likelihood: LogLikelihood, **settings: Any) -> Path:
    """Run, and be interrupted when this share of the sweeps is done."""

    class Stop:
        def __enter__(self) -> Stop:
            self.sent = False
            return self

        def __exit__(self, *failure: Any) -> None:
            return None

        def update(self, done: int, total: int, note: str = "") -> None:
            if done >= share * total and not self.sent:
                self.sent = True
                os.kill(os.getpid(), signal.SIGINT)

    stopped = quiet_sample(likelihood, **{"draws": DRAWS, **RUN, "progress": Stop(), "checkpoint": path, **settings})
    assert stopped.n_draws < stopped.settings.draws
    return path


def again(path: Path, likelihood: LogLikelihood | None = None, **settings: Any):
    settings = {"draws": DRAWS, **RUN, **settings}
    return quiet_sample(likelihood or table(), checkpoint=path, resume=True, **settings)


@pytest.mark.parametrize("sampler", [subgoal.samplers.collapsed_blocks, subgoal.samplers.alg4_corrected])
def test_resuming_in_the_same_process(sampler, tmp_path: Path) -> None:
    path = stop_after(0.4, tmp_path / "run.npz", table(), sampler=sampler)
    assert_same_posterior(again(path, sampler=sampler), quiet_sample(table(), draws=DRAWS, sampler=sampler, **RUN))


@pytest.mark.parametrize(
    ("name", "settings"),
    [("seed", {"seed": 6}), ("concentration", {"concentration": 2.0}), ("draws", {"draws": 3001}),
     ("chains", {"chains": 3}), ("warmup", {"warmup": 21}), ("thin", {"thin": 2}),
     ("sampler", {"sampler": subgoal.samplers.alg4_corrected})],
)  # fmt: skip
def test_other_settings_are_refused_by_name(name: str, settings: dict[str, Any], stopped: Path) -> None:
    with pytest.raises(StorageError, match=f"setting '{name}'"):
        again(stopped, **settings)


def test_another_version_is_refused_by_name(stopped: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("subgoal.posterior.sample.VERSION", "0.0.0")
    with pytest.raises(StorageError, match="setting 'version'"):
        again(stopped)


@pytest.mark.parametrize("change", ["first row", "last row", "columns", "prior", "points"])
def test_other_numbers_are_refused(change: str, stopped: Path) -> None:
    likelihood = table()
    values, candidates = likelihood.dense.copy(), likelihood.candidates  # type: ignore[union-attr]
    if change == "columns":
        values = values[:, ::-1]
    elif change.endswith("row"):
        values[0 if change == "first row" else -1, 0] += 1e-9
    else:
        points, prior = candidates.points.copy(), candidates.log_prior.copy()
        points[0, 0] += 1e-9 if change == "points" else 0.0
        prior[0] += 1e-9 if change == "prior" else 0.0
        candidates = Candidates(points, prior)
    with pytest.raises(StorageError, match="setting 'data'"):
        again(stopped, LogLikelihood.from_table(values, candidates=candidates))


def test_other_demonstrations_or_metrics_are_refused(tmp_path: Path) -> None:
    likelihood = corner_likelihood()
    path = stop_after(0.4, tmp_path / "run.npz", likelihood)
    metric = subgoal.Metric.of(2, period=[np.inf, 40.0])
    wrapped = Candidates(likelihood.candidates.points, radius=likelihood.candidates.radius, metric=metric)
    with pytest.raises(StorageError, match="setting 'data'"):
        again(path, subgoal.action_comparison(likelihood.demonstrations, wrapped, confidence=4.0))
    with pytest.raises(StorageError, match="setting 'confidence'"):
        again(path, likelihood.at(4.1))


def tear(path: Path) -> None:
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def test_torn_newest_checkpoint_gives_way_to_the_one_before(stopped: Path) -> None:
    tear(stopped)
    with pytest.warns(UserWarning, match="The checkpoint before it was used"):
        resumed = subgoal.sample(table(), draws=DRAWS, checkpoint=stopped, resume=True, workers=1, **RUN)
    assert_same_posterior(resumed, unbroken_run(DRAWS))


def test_torn_only_checkpoint(stopped: Path) -> None:
    previous(stopped).unlink()
    tear(stopped)
    with pytest.raises(StorageError, match="torn or foreign"):
        again(stopped)


def test_both_torn(stopped: Path) -> None:
    tear(previous(stopped))
    tear(stopped)
    with pytest.raises(StorageError, match="torn or foreign"):
        again(stopped)


def test_nothing_to_resume_from(tmp_path: Path) -> None:
    with pytest.raises(StorageError, match="no such file"):
        again(tmp_path / "none.npz")
    with pytest.raises(InputError, match="resume: found no checkpoint"):
        subgoal.sample(table(), resume=True)


def test_another_memory_budget_never_gives_half_of_the_draws(tmp_path: Path) -> None:
    """Draws not held by the first run cannot be given by the second; counts and shares are whole."""
    small = 1_000_000
    path = stop_after(0.4, tmp_path / "run.npz", table(), memory_budget=small)
    resumed, unbroken = again(path), quiet_sample(table(), draws=DRAWS, memory_budget=small, **RUN)
    assert unbroken.assignments is None
    assert_same_posterior(resumed, unbroken)


@pytest.mark.parametrize("chains", [1, 4])
def test_interrupted_runs_keep_their_checkpoint(chains: int, tmp_path: Path) -> None:
    path = stop_after(0.4, tmp_path / "run.npz", table(), chains=chains)
    unbroken = quiet_sample(table(), draws=DRAWS, **{**RUN, "chains": chains})
    assert_same_posterior(again(path, chains=chains), unbroken)


def test_interrupted_in_the_warm_up_keeps_its_checkpoint(tmp_path: Path) -> None:
    path = tmp_path / "run.npz"
    with pytest.raises(SubgoalError, match="warm-up"):
        stop_after(0.0, path, table(), warmup=500)
    assert_same_posterior(again(path, warmup=500), quiet_sample(table(), draws=DRAWS, **{**RUN, "warmup": 500}))
