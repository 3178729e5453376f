"""What ``learn`` and ``inspect`` say of a recording sampled more finely than subgoals need."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.conftest import QUICK

HINT = "60 samples a second: --rate 20 makes segments fewer and longer"


@pytest.mark.parametrize(
    ("per_second", "words", "told"), [(60, (), True), (30, (), False), (60, ("--rate", "20"), False)]
)
def test_fine_sampling_is_told(subgoal, tmp_path: Path, per_second: int, words: tuple[str, ...], told: bool) -> None:
    path = tmp_path / "fine.csv"
    path.write_text("x,y,t\n" + "".join(f"{k / 10},0,{k / per_second}\n" for k in range(40)))
    answer = subgoal("inspect", path, "--position", "x,y", "--time", "t", "--out", tmp_path / "out", *words)
    assert answer.code == 0
    assert (HINT in answer.out) == told


@pytest.mark.parametrize(
    ("words", "told"),
    [((), ""), (("--every", "40"), "warning: learned from 1 pair of state and action only: --every may be too large"),
     (("--rate", "6"), "warning: learned from 5 pairs of state and action only\n")],
)  # fmt: skip
def test_hardly_any_pairs_are_told(subgoal, tmp_path: Path, words: tuple[str, ...], told: str) -> None:
    path = tmp_path / "few.csv"
    path.write_text("x,y,t\n" + "".join(f"{k / 10},0,{k / 60}\n" for k in range(40)))
    answer = subgoal("learn", path, "--epsilon", "1", *QUICK, "--out", tmp_path / "out", *words)
    assert answer.code == 0
    assert answer.err.startswith(told) if told else "pairs of state" not in answer.err
