"""The page on flight runs as printed."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tests.docs.test_docs import ROOT, python_of
from tests.flight.made import RATE, flip_path, square_path

pytest.importorskip("rotorpy")
pytest.importorskip("rosbags")


@pytest.mark.filterwarnings("ignore")
def test_python_runs_as_printed(tmp_path, monkeypatch, capsys) -> None:
    for name, path, columns in (("square", square_path(), "yz"), ("flip", flip_path(), ["y", "z", "angle"])):
        table = pd.DataFrame(path, columns=list(columns)).assign(t=np.arange(len(path)) / RATE)
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    monkeypatch.chdir(tmp_path)
    exec(compile(python_of(ROOT / "docs/flight.md"), "docs/flight.md", "exec"), {})
    told = capsys.readouterr().out
    assert "flown: every waypoint was reached" in told
    assert "FLOWN Tracking(" in told
    assert {"waypoints.json", "waypoints.csv", "waypoints.mcap"} < {path.name for path in tmp_path.iterdir()}
