"""The same plan for any number of workers, from threads, processes, a cluster and a disk; dead workers do no harm."""

from __future__ import annotations

import logging
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from subgoal.mdp.grids.grid import THESIS_SLIP, GridWorld
from subgoal.mdp.grids.implicit_grid import ImplicitGrid
from subgoal.mdp.planners import precompute
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.rtdp import rtdp_subgoals
from subgoal.mdp.planners.subgoal_plan import SubgoalPlan
from subgoal.runtime.cluster import connect
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Silent

WORLD = ImplicitGrid(5_000, 5_000, 0.9, slip=THESIS_SLIP)
CELLS = np.array([[2_000 + k, 2_000 + k // 2] for k in range(25)])
GOALS, STATES = WORLD.states(CELLS), WORLD.states(CELLS[::3])


def planned(**how: Any) -> SubgoalPlan:
    return rtdp_subgoals(how.pop("world", WORLD), GOALS, states=STATES, tolerance=1e-4, **how)


@pytest.fixture(scope="module")
def plain() -> SubgoalPlan:
    return planned(workers=1)


def assert_same(ours: SubgoalPlan, theirs: SubgoalPlan) -> None:
    np.testing.assert_array_equal(ours.action_values, theirs.action_values)
    np.testing.assert_array_equal(ours.half_gap, theirs.half_gap)
    assert (ours.status, ours.sweeps, ours.n_inside) == (theirs.status, theirs.sweeps, theirs.n_inside)


@dataclass(frozen=True, eq=False)
class Deadly:
    """A world that kills the process that first looks at the row of one state, once."""

    inside: ImplicitGrid
    state: int
    mark: Path

    def __getattr__(self, name: str) -> Any:
        return getattr(object.__getattribute__(self, "inside"), name)

    def __reduce__(self) -> Any:
        return Deadly, (self.inside, self.state, self.mark)

    def rows(self, states: np.ndarray) -> Any:
        if self.state in states and not self.mark.exists():
            self.mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return self.inside.rows(states)


@pytest.mark.parametrize("how", [{"workers": 2}, {"workers": 3}, {"workers": 2, "backend": "loky"}], ids=str)
def test_the_plan_does_not_depend_on_who_made_it(plain: SubgoalPlan, how: dict) -> None:
    assert_same(planned(**how), plain)


def test_a_process_that_dies_is_replaced_and_nothing_is_lost(plain: SubgoalPlan, tmp_path: Path) -> None:
    deadly = Deadly(WORLD, int(GOALS[12]), tmp_path / "dead")
    assert_same(planned(world=deadly, workers=2, backend="loky"), plain)
    assert deadly.mark.exists()


def test_work_that_kills_every_process_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(precompute, "ATTEMPTS", 1)
    deadly = Deadly(WORLD, int(GOALS[12]), tmp_path / "dead")
    with pytest.raises(Exception, match=r"terminated|abruptly"):
        planned(world=deadly, workers=2, backend="loky")


def exactly(**how: Any) -> SubgoalPlan:
    grid = GridWorld(np.random.default_rng(0).random((40, 40)) > 0.2, 0.95, slip=THESIS_SLIP)
    states = np.arange(0, grid.n_states, 7)
    return plan_subgoals(grid.mdp, states, states=states, **how)


@pytest.mark.parametrize("how", [{"workers": 2}, {"workers": 2, "backend": "loky"}], ids=str)
def test_an_exact_plan_does_not_depend_on_who_made_it(how: dict) -> None:
    plain, ours = exactly(workers=1), exactly(**how)
    np.testing.assert_array_equal(ours.action_values, plain.action_values)
    np.testing.assert_array_equal(ours.value, plain.value)
    assert ours.error_bound == plain.error_bound


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed", reason="the dask extra is not installed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs=logging.CRITICAL
        ) as started,
        connect(started.scheduler_address, timeout=9) as client,
    ):
        yield client


def test_a_cluster_gives_the_same_plan(plain: SubgoalPlan, cluster: Any) -> None:
    assert_same(planned(backend="dask"), plain)
    np.testing.assert_array_equal(exactly(backend="dask").action_values, exactly().action_values)


def test_a_worker_of_a_cluster_that_is_killed_changes_nothing(plain: SubgoalPlan, cluster: Any, tmp_path: Path) -> None:
    before = set(cluster.run(os.getpid).values())
    deadly = Deadly(WORLD, int(GOALS[12]), tmp_path / "dead")
    assert_same(planned(world=deadly, backend="dask"), plain)
    assert deadly.mark.exists()
    assert set(cluster.run(os.getpid).values()) != before


def test_a_second_run_reads_what_the_first_kept(
    plain: SubgoalPlan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_same(planned(cache=tmp_path), plain)
    files = sorted(tmp_path.iterdir())
    assert len(files) == 3
    files[1].unlink()
    made: list[Any] = []
    keep = precompute._keep
    monkeypatch.setattr(precompute, "_keep", lambda path, bounds: (made.append(path), keep(path, bounds)))
    assert_same(planned(cache=tmp_path), plain)
    assert made == [files[1]]


def test_a_run_that_was_stopped_goes_on(plain: SubgoalPlan, tmp_path: Path) -> None:
    class Stopped(Silent):
        def update(self, done: int, total: int, note: str = "") -> None:
            if done == 20:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        planned(cache=tmp_path, workers=1, progress=Stopped())
    assert len(list(tmp_path.iterdir())) == 2
    assert_same(planned(cache=tmp_path), plain)


def test_a_torn_file_is_made_again(plain: SubgoalPlan, tmp_path: Path) -> None:
    planned(cache=tmp_path)
    first = sorted(tmp_path.iterdir())[0]
    first.write_bytes(first.read_bytes()[:100])
    assert_same(planned(cache=tmp_path), plain)
    assert first.stat().st_size > 100


@pytest.mark.parametrize(
    "other",
    [
        {"tolerance": 1e-3},
        {"convention": "absorbing"},
        {"most_states": 10_000},
        {"states": STATES[1:]},
        {"world": ImplicitGrid(5_000, 5_000, 0.91, slip=THESIS_SLIP)},
        {"world": ImplicitGrid(5_000, 5_000, 0.9, slip=THESIS_SLIP, cut_corners=False)},
        {"world": ImplicitGrid(5_000, 5_000, 0.9, slip=THESIS_SLIP, free=lambda x, y: x >= 0, name="open")},
    ],
    ids=["tolerance", "convention", "budget", "states", "discount", "corners", "walls"],
)
def test_nothing_is_taken_for_something_else(tmp_path: Path, other: dict) -> None:
    planned(cache=tmp_path)
    arguments: dict[str, Any] = {"world": WORLD, "states": STATES, "tolerance": 1e-4, "cache": tmp_path} | other
    rtdp_subgoals(arguments.pop("world"), GOALS, **arguments)
    assert len(list(tmp_path.iterdir())) == 6


def test_a_world_without_a_name_is_not_kept(tmp_path: Path) -> None:
    nameless = ImplicitGrid(100, 100, 0.9, free=lambda x, y: x >= 0)
    with pytest.raises(InputError, match=r"cache: found ImplicitGrid.*told by a function, wanted one that is known"):
        rtdp_subgoals(nameless, [5], states=[7], cache=tmp_path)


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"cache: found .*wanted a folder"):
        planned(cache=tmp_path / "file")


def test_progress_is_told_the_goals() -> None:
    told: list[tuple[int, int]] = []

    class Heard(Silent):
        def update(self, done: int, total: int, note: str = "") -> None:
            told.append((done, total))

    planned(progress=Heard(), workers=1)
    assert told == [(0, 25), (10, 25), (20, 25), (25, 25)]
