"""The page on streams runs as printed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.docs.test_docs import ROOT, python_of
from tests.streaming.test_stream import hand_held


@pytest.mark.filterwarnings("ignore")
def test_python_runs_as_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    times, places = hand_held(0)
    table = np.column_stack([times, places])
    np.savetxt(tmp_path / "track.csv", table, delimiter=",", header="t,x,y", comments="")
    monkeypatch.chdir(tmp_path)
    exec(compile(python_of(ROOT / "docs/streaming.md"), "docs/streaming.md", "exec"), {})
    told = capsys.readouterr().out
    assert "Subgoals(4 with at least 5 % of the observations" in told
    assert "found nan, wanted a finite number" in told
    assert {"posterior.npz", "report.html"} < {path.name for path in tmp_path.iterdir()}
