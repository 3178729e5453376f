"""The command run in this process, and a small recording to run it on."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from subgoal.cli.main import main

QUICK = ("--draws", "60", "--warmup", "40", "--thin", "1", "--chains", "4")


@dataclass(frozen=True)
class Answer:
    code: int
    out: str
    err: str


@pytest.fixture
def subgoal(monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]) -> Callable[..., Answer]:
    """``subgoal("learn", path, ...)`` gives exit code and output."""

    def run(*words: object) -> Answer:
        monkeypatch.setattr(sys, "argv", ["subgoal", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            main()
        caught = capfd.readouterr()
        return Answer(int(end.value.code or 0), caught.out, caught.err)

    return run


@pytest.fixture
def corner(tmp_path: Path) -> Path:
    """A CSV of two tracks around a corner: (0, 0) to (10, 0) to (10, 10)."""
    leg = np.linspace(0, 10, 21)
    path = np.vstack([np.column_stack([leg, 0 * leg]), np.column_stack([0 * leg + 10, leg])[1:]])
    lines = ["x,y,t,id"]
    for name, shift in (("a", 0.0), ("b", 0.2)):
        lines += [f"{x + shift},{y + shift},{0.5 * k},{name}" for k, (x, y) in enumerate(path)]
    file = tmp_path / "corner.csv"
    file.write_text("\n".join(lines) + "\n")
    return file
