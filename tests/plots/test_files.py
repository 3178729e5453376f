"""Figures on disk: both files, the same bytes twice, and never half a file."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from subgoal.plots import plot_trajectories, save_figure
from tests.plots.example import example


def test_same_bytes_twice(tmp_path: Path) -> None:
    first, second = (
        [path.read_bytes() for path in save_figure(plot_trajectories(*example(2)), tmp_path / name, "main")]
        for name in ("a", "b")
    )
    assert first == second
    assert first[0].startswith(b"\x89PNG")
    assert b"<svg" in first[1]
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["main.png", "main.svg"]


def test_a_failure_leaves_the_old_file_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "main.png").write_bytes(b"old")
    figure = plot_trajectories(*example(2))

    def torn(self: Figure, path: Path, **options: object) -> None:
        Path(path).write_bytes(b"half a")
        raise OSError("disk full")

    monkeypatch.setattr(Figure, "savefig", torn)
    with pytest.raises(OSError, match="disk full"):
        save_figure(figure, tmp_path, "main")
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("main.png", b"old")]


def test_global_state_of_matplotlib_is_left_alone(tmp_path: Path) -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    save_figure(plot_trajectories(*example(2, named=True)), tmp_path, "main")
    assert dict(matplotlib.rcParams) == before
