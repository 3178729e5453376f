"""``subgoal learn --likelihood grid``: positions in cells, planned for."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import subgoal.likelihood.planners as planners
from tests.cli.conftest import QUICK
from tests.cli.test_learn import table

CELLS = ("--likelihood", "grid", "--cell", "1", "-p", "x,y", "-t", "t", "-i", "id")


def test_the_corner_is_found_in_cells(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = subgoal("learn", corner, *CELLS, "--out", out, *QUICK)
    assert answer.code == 0, answer.err
    assert "planned by exact, for the whole world" in answer.out
    goals = table(out / "subgoals.csv")
    places = np.array([[float(row["x"]), float(row["y"])] for row in goals[:2]])
    for wanted in ((10, 0), (10, 10)):
        assert np.linalg.norm(places - wanted, axis=1).min() <= 2.0
    summary = json.loads((out / "summary.json").read_text())
    assert summary["settings"]["planner"].startswith("exact")
    assert "exact, for the whole world" in (out / "report.html").read_text()
    assert not (out / ".plans").exists()


def test_a_large_world_is_planned_for_in_envelopes_that_are_kept(
    subgoal, corner: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(planners, "SMALL_GRID", 50)
    out = tmp_path / "out"
    answer = subgoal("learn", corner, *CELLS, "--out", out, *QUICK)
    assert answer.code == 0, answer.err
    assert "real-time dynamic programming in envelopes of up to" in answer.out
    assert "log probabilities are wrong by at most" in (out / "report.html").read_text()
    kept = sorted((out / ".plans").iterdir())
    assert kept
    before = [path.stat().st_mtime_ns for path in kept]
    subgoal("learn", corner, *CELLS, "--out", out, *QUICK)
    assert [path.stat().st_mtime_ns for path in sorted((out / ".plans").iterdir())] == before


def test_a_map_says_where_one_can_be(subgoal, corner: Path, tmp_path: Path) -> None:
    picture = tmp_path / "map.png"
    Image.fromarray(np.full((40, 40), 255, np.uint8)).save(picture)
    told = ("--map", picture, "--map-corner", "-10,-10")
    answer = subgoal("learn", corner, *CELLS, *told, "--out", tmp_path / "out", *QUICK)
    assert answer.code == 0, answer.err
    assert "1,600 cells" in answer.out
    Image.fromarray(np.pad(np.full((20, 20), 255, np.uint8), 10)).save(picture)
    answer = subgoal("learn", corner, *CELLS, "--map", picture, "--map-corner", "-30,-30", "--out", tmp_path / "o2")
    assert answer.code == 2
    assert "wall" in answer.err or "map" in answer.err


def test_what_lies_in_walls_can_be_left_out(subgoal, corner: Path, tmp_path: Path) -> None:
    picture = tmp_path / "map.png"
    walls = np.full((40, 40), 255, np.uint8)
    walls[20:, 12:14] = 0
    Image.fromarray(walls).save(picture)
    told = ("--map", picture, "--map-corner", "-10,-10", "--outside")
    assert subgoal("learn", corner, *CELLS, *told, "raise", "--out", tmp_path / "a", *QUICK).code == 2
    answer = subgoal("learn", corner, *CELLS, *told, "drop", "--out", tmp_path / "b", *QUICK)
    assert answer.code == 0, answer.err
    assert "map: x of -10 to 30, y of -10 to 30" in answer.out


def test_a_report_of_cells_is_made_again(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, *CELLS, "--out", out, *QUICK)
    before = (out / "subgoals.csv").read_text()
    (out / "report.html").unlink()
    answer = subgoal("report", out)
    assert answer.code == 0, answer.err
    assert (out / "report.html").exists()
    assert (out / "subgoals.csv").read_text() == before


def test_planning_that_is_stopped_says_how_to_go_on(
    subgoal, corner: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*told: object, **how: object) -> None:
        (tmp_path / "out" / ".plans").mkdir()
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("subgoal.cli.gridding.planned_likelihood", stopped)
        answer = subgoal("learn", corner, *CELLS, "--out", tmp_path / "out", *QUICK)
    assert answer.code == 130
    assert "stopped while planning; what was planned is kept in" in answer.err
    again = subgoal("learn", corner, *CELLS, "--resume", "--out", tmp_path / "out", *QUICK)
    assert again.code == 0, again.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--likelihood", "grid", "--gain", "2"), "--gain: found given, wanted none of them beside --likelihood grid"),
        (("--likelihood", "grid", "--every", "3"), "--every: found given"),
        (("--likelihood", "grid", "--controller", "proportional"), "--controller"),
        (("--likelihood", "grid", "--discount", "1"), "--discount: found 1.0, wanted at least 0 and below 1"),
        (("--likelihood", "grid", "--cell", "-1"), "--cell"),
        (("--likelihood", "grid", "--moves", "5"), "moves"),
        (("--likelihood", "grid", "--map", "nowhere.png", "--cell", "1"), "nowhere.png"),
        (("--likelihood", "grid", "--map", "floor.png"), "--cell: found none, wanted the side of a pixel of --map"),
        (("--likelihood", "grid", "--map-corner=-1,2"), "--map-corner: found given, wanted --map beside it"),
        (("--likelihood", "grid", "--outside", "keep"), "--outside: found 'keep', wanted raise or drop"),
        (("--likelihood", "grid", "--cell", "0.0001"), "larger cells: 10,000,000 at most"),
        (("--cell", "1"), "--cell: found given, wanted --likelihood grid beside it"),
        (("--map", "floor.png"), "--map: found given, wanted --likelihood grid beside it"),
        (("--scheduler", "tcp://127.0.0.1:1"), "--scheduler: found tcp://127.0.0.1:1, wanted --backend dask beside it"),
        (("--scheduler", "tcp://127.0.0.1:1", "--backend", "dask"), "Dask scheduler"),
    ],
)
def test_what_does_not_go_together_is_refused(
    subgoal, corner: Path, tmp_path: Path, words: tuple[str, ...], told: str
) -> None:
    answer = subgoal("learn", corner, "-p", "x,y", "-t", "t", "-i", "id", *words, "--out", tmp_path / "out")
    assert answer.code == 2
    assert told in answer.err
    assert not (tmp_path / "out").exists()
