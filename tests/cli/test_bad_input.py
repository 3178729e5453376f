"""Bad input: a clear message on standard error, exit code 2, nothing half-written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import QUICK

BAD_OPTIONS = [
    (("--confidence", "nan"), "confidence"),
    (("--confidence", "-1"), "confidence"),
    (("--concentration", "0"), "concentration"),
    (("--epsilon", "-2"), "radius"),
    (("--chains", "0"), "chains"),
    (("--draws", "0"), "draws"),
    (("--seed", "-1"), "seed"),
    (("--sampler", "gibbs"), "sampler"),
    (("--controller", "magic"), "controller"),
    (("--position", "x,z"), "z"),
    (("--time", "clock"), "clock"),
    (("--trajectory", "animal"), "animal"),
    (("--weights", "1"), "weights"),
    (("--weights", "1,b"), "weights"),
    (("--every", "0"), "every"),
    (("--rate", "nan"), "rate"),
    (("--velocity", "fast"), "velocity"),
    (("--start-within", "3"), "start-within"),
    (("--format", "word"), "format"),
    (("--grid", "0"), "spacing"),
    (("--grid", "1", "--epsilon", "1"), "one of"),
    (("--candidates", "nowhere.csv"), "nowhere.csv"),
    (("--merge-radius", "-1"), "merge_radius"),
    (("--resume",), "checkpoint"),
    (("--no-such-option",), "no-such-option"),
]

BAD_FILES = {
    "empty.csv": b"",
    "heads.csv": b"x,y,t\n",
    "one.csv": b"x,y,t\n1,2,3\n",
    "words.csv": b"x,y,t\nhere,there,now\nand,then,again\n",
    "huge.csv": b"x,y,t\n1e400,0,0\n1,1,1\n",
    "still.csv": b"x,y,t\n1,1,0\n1,1,1\n1,1,2\n",
    "back.csv": b"x,y,t\n0,0,0\n1,1,2\n2,2,1\n",
    "noise.npz": bytes(range(256)) * 4,
    "half.mat": b"MATLAB 5.0 MAT-file" + b"\0" * 40,
    "poses.txt": b"# nothing\n",
}


@pytest.mark.parametrize(
    ("words", "named"), BAD_OPTIONS, ids=lambda value: " ".join(value) if isinstance(value, tuple) else None
)
def test_bad_options(subgoal, corner: Path, tmp_path: Path, words: tuple[str, ...], named: str) -> None:
    out = tmp_path / "out"
    answer = subgoal("learn", corner, "-i", "id", *QUICK, "--out", out, *words)
    assert answer.code == 2
    assert named in answer.err
    assert "Traceback" not in answer.err
    assert not out.exists()


@pytest.mark.parametrize("name", BAD_FILES)
def test_bad_files(subgoal, tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(BAD_FILES[name])
    answer = subgoal("learn", tmp_path / name, "--out", tmp_path / "out", *QUICK)
    assert answer.code == 2
    assert answer.err.startswith("subgoal: ")
    assert "Traceback" not in answer.err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["learn", "inspect", "report"])
def test_nothing_there(subgoal, tmp_path: Path, command: str) -> None:
    answer = subgoal(command, tmp_path / "nowhere")
    assert answer.code == 2
    assert "nowhere" in answer.err


def test_output_folder_is_a_file(subgoal, corner: Path, tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    answer = subgoal("learn", corner, "--out", tmp_path / "taken", *QUICK)
    assert answer.code == 2
    assert (tmp_path / "taken").read_text() == "mine"


def test_old_results_stay_whole_when_a_later_step_fails(subgoal, corner: Path, tmp_path: Path, monkeypatch) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "-i", "id", "--out", out, "-q", *QUICK)
    before = {path.name: path.read_bytes() for path in out.iterdir()}

    def full_disk(*arguments: object, **options: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr("subgoal.reporting.results.report", full_disk)
    answer = subgoal("learn", corner, "-i", "id", "--out", out, "--confidence", "9", *QUICK)
    assert answer.code == 2
    assert "no space left" in answer.err
    assert {path.name: path.read_bytes() for path in out.iterdir()} == before


def test_a_torn_posterior_cannot_be_reported(subgoal, corner: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    subgoal("learn", corner, "-i", "id", "--out", out, "-q", *QUICK)
    whole = (out / "posterior.npz").read_bytes()
    (out / "posterior.npz").write_bytes(whole[: len(whole) // 2])
    answer = subgoal("report", out)
    assert answer.code == 2
    assert "posterior" in answer.err


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--group", "id", "-i", "id", "--sampler", "blocked"), "none beside --group"),
        (("--learn-all", "--sampler", "blocked"), "none beside --learn-all"),
        (("--group", "beast"), "column 'beast'"),
        (("--confidence", "0"), "confidence"),
        (("--learn-all", "--confidence", "0"), "confidence"),
    ],
)
def test_options_that_do_not_go_together(subgoal, corner: Path, tmp_path: Path, words, told: str) -> None:
    answer = subgoal("learn", corner, *words, "--out", tmp_path / "out")
    assert answer.code == 2
    assert told in answer.err
    assert not (tmp_path / "out").exists()
