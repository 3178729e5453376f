"""``subgoal follow``: what it prints while a recording is written, and what it leaves at the end."""

from __future__ import annotations

import io
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import subgoal as library
from subgoal.cli.display import Display, line_of, table_of
from subgoal.streaming import Stream
from tests.cli.conftest import QUICK

MODEL = ("--epsilon", "0.3", "--rate", "0")
SHORT = ("--draws", "60", "--wait", "0")
STILL = "x,y,t\n" + "".join(f"1,1,{k}\n" for k in range(6))


def process(*words: object, **options: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "subgoal.cli.main", "follow", *map(str, words)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)  # type: ignore[call-overload]


def test_it_leaves_the_folder_that_learn_leaves(subgoal, corner: Path, tmp_path: Path) -> None:
    followed = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a")
    learned = subgoal("learn", corner, "-i", "id", "--epsilon", "0.3", *QUICK, "--out", tmp_path / "b")
    assert followed.code == learned.code == 0
    assert sorted(f.name for f in (tmp_path / "a").iterdir()) == sorted(f.name for f in (tmp_path / "b").iterdir())
    assert "2 subgoals with at least 5 % of 82 observations in 2 trajectories" in followed.out
    assert (tmp_path / "a" / "segments.csv").read_text().count("\na,") == 2
    headings = [library.load(tmp_path / name / "posterior.npz").demonstrations.source.name for name in "ab"]
    assert headings == [corner.name] * 2


def test_lines_tell_the_subgoals_that_appear(subgoal, corner: Path, tmp_path: Path) -> None:
    told = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a").out
    assert "82 pairs: 2 subgoals, (10.0" in told or "82 pairs: 2 subgoals, (10.2" in told


def test_quiet_prints_nothing(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "-q", "--out", tmp_path / "a")
    assert (answer.code, answer.out, answer.err) == (0, "", "")


def test_bad_lines_are_told_and_left_out(subgoal, corner: Path, tmp_path: Path) -> None:
    lines = corner.read_text().splitlines()
    worse = [*lines[:5], "9,9,soon,a", "1,2", *lines[5:9], "9,9,0,a", "# a remark", "", *lines[9:], "1,1,99,a"]
    corner.write_text("\n".join(worse) + "\n")
    answer = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a")
    assert answer.code == 0
    assert "line 6 is left out: line: found could not convert string to float: 'soon'" in answer.err
    assert "line 7 is left out: line: found 2 fields, wanted 4, as the header has" in answer.err
    assert "line 12 is left out: time: found 0 after 3.5, wanted a later one" in answer.err
    assert f"line {len(worse)} is left out: trajectory: found 'a' again" in answer.err
    assert "82 observations in 2 trajectories" in answer.out


def test_many_bad_lines_are_counted(subgoal, corner: Path, tmp_path: Path) -> None:
    corner.write_text(corner.read_text() + "x,x,x,b\n" * 9)
    told = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a").err
    assert told.count("is left out") == 5
    assert "9 lines left out in all" in told


BAD = {
    "a column that is not there": (("-p", "x,z"), "columns x, z, t"),
    "no radius": (("--epsilon", "0"), "radius"),
    "a radius that is not a number": (("--epsilon", "nan"), "radius"),
    "no draws": (("--draws", "0"), "draws"),
    "no sweeps between draws": (("--thin", "0"), "thin"),
    "patience below zero": (("--wait", "-1"), "wait"),
    "one weight": (("--weights", "1"), "weights"),
    "one period": (("--period", "1"), "period"),
    "no window": (("--window", "1"), "window"),
    "no gap": (("--max-gap", "0"), "max_gap"),
    "no confidence": (("--confidence", "0"), "confidence"),
}


@pytest.mark.parametrize(("words", "named"), BAD.values(), ids=BAD)
def test_bad_options_leave_nothing(subgoal, corner: Path, tmp_path: Path, words: tuple[str, ...], named: str) -> None:
    answer = subgoal("follow", corner, *MODEL, *SHORT, "--out", tmp_path / "out", *words)
    assert answer.code == 2
    assert named in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "named"), [("", "no line"), ("x,y,t\n", "no line with numbers"), (STILL, "x, y that change")]
)
def test_bad_files_leave_nothing(subgoal, tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "bad.csv").write_text(text)
    answer = subgoal("follow", tmp_path / "bad.csv", *MODEL, *SHORT, "--out", tmp_path / "out")
    assert answer.code == 2
    assert named in answer.err
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_not_there_is_told(subgoal, tmp_path: Path) -> None:
    answer = subgoal("follow", tmp_path / "nowhere.csv", *MODEL, "--out", tmp_path / "out")
    assert answer.code == 2
    assert "nowhere.csv" in answer.err


def test_standard_input_ends_with_its_last_line(corner: Path, tmp_path: Path) -> None:
    run = process("-", "-i", "id", *MODEL, "--draws", 60, "--out", tmp_path / "out", stdin=subprocess.PIPE)
    told, problems = run.communicate(corner.read_text().rstrip("\n"), timeout=100)
    assert (run.returncode, problems) == (0, "")
    assert "82 observations in 2 trajectories" in told
    assert (tmp_path / "out" / "report.html").exists()


def test_a_growing_file_is_followed_until_it_is_stopped(corner: Path, tmp_path: Path) -> None:
    """Half of the lines first and the last of these cut in two; the rest when the first are told; then Ctrl-C."""
    text = corner.read_text()
    growing, half = tmp_path / "growing.csv", len(text) // 2 + 3
    growing.write_text(text[:half])
    run = process(growing, "-i", "id", *MODEL, "--draws", 60, "--out", tmp_path / "out")
    assert "pairs: " in run.stdout.readline()
    with growing.open("a") as stream:
        stream.write(text[half:] + "the end of it\n")
    assert "line 84 is left out" in run.stderr.readline()
    run.send_signal(signal.SIGINT)
    told, problems = run.communicate(timeout=100)
    assert (run.returncode, problems) == (0, "")
    assert "82 observations in 2 trajectories" in told
    assert (tmp_path / "out" / "report.html").exists()


def test_sigterm_writes_what_ctrl_c_writes_and_waiting_is_told(corner: Path, tmp_path: Path) -> None:
    run = process(corner, "-i", "id", *MODEL, "--draws", 60, "--out", tmp_path / "out")
    told = ""
    while "waiting for more lines; Ctrl-C ends and writes" not in told and run.poll() is None:
        told = run.stdout.readline()
    run.terminate()
    run.communicate(timeout=100)
    assert run.returncode == 0
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize("worse", ["1,\r2,3", "1," + "0" * 200_000 + ",3"])
def test_lines_that_are_no_table_are_told_and_left_out(subgoal, corner: Path, tmp_path: Path, worse: str) -> None:
    lines = corner.read_text().splitlines()
    corner.write_bytes("\n".join([*lines[:5], worse, *lines[5:]]).encode())
    answer = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a")
    assert answer.code == 0
    assert "line 6 is left out" in answer.err
    assert "82 observations in 2 trajectories" in answer.out


def test_times_that_go_back_suggest_a_column_of_trajectories(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal("follow", corner, *MODEL, *SHORT, "--out", tmp_path / "a")
    assert "the time goes back. If there is more than one trajectory, --trajectory" in answer.err


def test_a_long_gap_is_told(subgoal, corner: Path, tmp_path: Path) -> None:
    corner.write_text("x,y,t\n" + "".join(f"{k / 10},0,{k / 10 + 20 * (k > 20)}\n" for k in range(40)))
    answer = subgoal("follow", corner, "--epsilon", "0.3", *SHORT, "--out", tmp_path / "a")
    assert "warning: line 23 comes 20.1 after the one before: 402 samples are made up" in answer.err


def test_gaps_are_cut_as_learn_cuts_them(subgoal, tmp_path: Path) -> None:
    clock = [k / 10 + 20 * (k > 20) + 200 * (k > 30) for k in range(40)]
    (tmp_path / "gaps.csv").write_text("x,y,t\n" + "".join(f"{k / 10},0,{t}\n" for k, t in enumerate(clock)))
    words = (tmp_path / "gaps.csv", "--epsilon", "0.3", "--rate", "20", "--max-gap", "1")
    followed = subgoal("follow", *words, *SHORT, "--out", tmp_path / "a")
    learned = subgoal("learn", *words, *QUICK, "--out", tmp_path / "b")
    assert (followed.code, followed.err, learned.code) == (0, "", 0)
    streamed, whole = (library.load(tmp_path / name / "posterior.npz").demonstrations for name in "ab")
    assert streamed.trajectory_names == whole.trajectory_names == ("T0/0", "T0/1", "T0/2")
    np.testing.assert_array_equal(streamed.states, whole.states)


def test_draws_are_made_as_asked(subgoal, corner: Path, tmp_path: Path) -> None:
    answer = subgoal(
        "follow", corner, "-i", "id", *MODEL, *SHORT, "--warmup", "7", "--thin", "3", "--out", tmp_path / "a"
    )
    assert answer.code == 0
    made = library.load(tmp_path / "a" / "posterior.npz").settings
    assert (made.draws, made.warmup, made.thin) == (60, 7, 3)


def test_a_table_with_decimal_commas_is_followed(subgoal, corner: Path, tmp_path: Path) -> None:
    corner.write_text(corner.read_text().replace(",", ";").replace(".", ","))
    answer = subgoal("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a")
    assert (answer.code, answer.err) == (0, "")
    assert "82 observations in 2 trajectories" in answer.out


@pytest.mark.parametrize("words", [("-p", "x,x"), ("-p", "x,t"), ("-p", "x,y", "-i", "y")])
def test_a_column_is_asked_for_once(subgoal, corner: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    answer = subgoal("follow", corner, *MODEL, *SHORT, "--out", tmp_path / "a", *words)
    assert answer.code == 2
    assert "more than once" in answer.err


@pytest.mark.parametrize(("name", "told"), [("nowhere.csv", "no such file"), ("", "a folder")])
def test_what_is_no_file_is_told_in_words(subgoal, tmp_path: Path, name: str, told: str) -> None:
    answer = subgoal("follow", tmp_path / name, *MODEL, "--out", tmp_path / "out")
    assert answer.code == 2
    assert f"found {told}" in answer.err


def test_results_that_are_replaced_are_told_before(subgoal, corner: Path, tmp_path: Path) -> None:
    words = ("follow", corner, "-i", "id", *MODEL, *SHORT, "--out", tmp_path / "a")
    assert "replaces the results" not in subgoal(*words).out
    assert subgoal(*words).out.startswith("replaces the results in")


def told_corner() -> Stream:
    stream = Stream(names=("x", "y"), radius=0.3, rate=None)
    leg = np.linspace(0, 10, 21)
    for k, place in enumerate([*zip(leg, 0 * leg, strict=True), *zip(0 * leg[1:] + 10, leg[1:], strict=True)]):
        stream.add(k, place)
    return stream


def test_a_terminal_has_a_table_that_stays_in_its_place() -> None:
    page = io.StringIO()
    with Display(quiet=False, console=Console(file=page, force_terminal=True, width=80)) as display:
        display.look(Stream(2, radius=1.0))
        display.look(told_corner(), last=True)
    told = page.getvalue()
    assert "0 pairs, 0 subgoals" in told
    assert "40 pairs, 2 subgoals" in told
    assert "\x1b[" in told


def test_lines_come_when_something_changed() -> None:
    page, stream = io.StringIO(), told_corner()
    display = Display(quiet=False, console=Console(file=page, width=200))
    for again in (stream, stream, stream):
        display._looked = -time.monotonic()
        display.look(again)
    assert page.getvalue().count("40 pairs: 2 subgoals") == 1
    display.look(stream)
    display.look(stream, last=True)
    assert page.getvalue().count("40 pairs: 2 subgoals") == 2


def test_a_subgoal_that_moves_is_told() -> None:
    page, stream = io.StringIO(), told_corner()
    display = Display(quiet=False, merge_radius=0.0, console=Console(file=page, width=200))
    display.look(stream)
    stream.retune(confidence=0.2)
    display._looked = -np.inf
    display.look(stream)
    assert page.getvalue().count("pairs: ") == 2


def test_rows_of_the_table_are_the_subgoals_with_one_percent() -> None:
    stream = told_corner()
    found = stream.subgoals()
    assert table_of(stream, found).row_count == len(found)
    assert line_of(stream, found).count("%") == found.n_subgoals == 2


def test_help_has_an_example(subgoal) -> None:
    answer = subgoal("follow", "--help")
    assert answer.code == 0
    assert "subgoal follow track.csv --position x,y --time t --epsilon 0.05" in answer.out
