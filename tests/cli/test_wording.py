"""Messages on the command line speak of its options, not of Python's arguments."""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest

from subgoal.cli.inspect import inspect
from subgoal.cli.learn import learn
from subgoal.cli.wording import as_typed


@pytest.mark.parametrize(
    ("python", "typed"),
    [
        ("Try: position=['px', 'py'] (the columns)", "Try: --position px,py (the columns)"),
        ("Try: position=['X in m', 'b']", "Try: --position 'X in m,b'"),
        ("clock='sort' orders the rows", "--clock sort orders the rows"),
        ("tells trajectories apart with trajectory=.", "tells trajectories apart with --trajectory."),
        ("found min_likelihood=, wanted", "found --min-likelihood, wanted"),
        ("resample with rate=2.5, split", "resample with --rate 2.5, split"),
        ("for example with thin=, or", "for example with --thin-radius, or"),
        ("Try: quiet=True (--quiet), or more", "Try: --quiet, or more"),
        ("a larger window= (--window), or", "a larger --window, or"),
        ("or model=None, the exchangeable model", "or no --learn-all, the exchangeable model"),
        ("load(path, mdp=mdp)", "load(path, mdp=mdp)"),
        ("a value of colour='red'", "a value of colour='red'"),
    ],
)
def test_arguments_become_options(python: str, typed: str) -> None:
    assert as_typed(python, learn) == typed


def test_options_of_the_other_command_are_told_with_its_name() -> None:
    told = as_typed("units= names it; a wider window= smooths them", inspect, learn)
    assert told == "--units names it; a wider --window of subgoal learn smooths them"


@pytest.mark.parametrize(
    ("text", "words", "told"),
    [
        ("px,py,t\n1,2,0\n2,3,1\n", (), "--position px,py (the columns"),
        ("t,place,height\n0,2,0\n1,3,1\n", (), "--position place,height (the columns"),
        ("t,speed,p_x,p_y\n0,9,2,0\n1,9,3,1\n", (), "--position p_x,p_y (the columns"),
        ("x,y,t\n", (), "found no row of data, wanted at least one"),
        ("x,y,t,id,g\n0,0,0,a,u\n1,1,1,a,v\n", ("--group", "g"), "Try: --trajectory with the column"),
        ("x,y,t\n0,0,0\n1,q,2\n", (), "column 'y', data row 2, counted from 1: found 'q'"),
        ("x,y,t\n0,0,0\n1,1,1\n", ("--bodypart", "nose"), "found --bodypart, wanted those of 'csv' files"),
    ],
)
@pytest.mark.parametrize("command", ["learn", "inspect"])
def test_bad_files_are_told_in_options(subgoal, tmp_path: Path, command: str, text: str, words, told: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    answer = subgoal(command, tmp_path / "a.csv", *words, "--out", tmp_path / "out")
    assert answer.code == 2
    assert told in answer.err


@pytest.mark.parametrize(
    ("scale", "told"), [((), "taken as seconds (--time-scale 0.001"), (("--time-scale", 1), "in s")]
)
def test_the_unit_of_the_times_is_told(subgoal, corner: Path, tmp_path: Path, scale, told: str) -> None:
    answer = subgoal("inspect", corner, "-i", "id", *scale, "--out", tmp_path)
    assert f"times: {told}" in answer.out
    assert "the unit of the positions is unknown; --units names it" in answer.out


def test_inspect_counts_the_trajectories_of_groups(subgoal, tmp_path: Path) -> None:
    rows = [f"{x},{x},{x},{walk},{walk[0]}" for walk, x in itertools.product(("a1", "a2", "b1"), range(6))]
    (tmp_path / "a.csv").write_text("\n".join(["x,y,t,id,animal", *rows]) + "\n")
    answer = subgoal("inspect", tmp_path / "a.csv", "--group", "animal", "-i", "id", "--out", tmp_path)
    assert "trajectories of groups: a 2, b 1" in answer.out
