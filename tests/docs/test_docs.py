"""The Python of README and tutorial runs as printed; every relative link leads somewhere."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.common import walkers
from subgoal.dynamics import ALL_DRIVE, drive

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def python_of(page: Path) -> str:
    return "\n".join(re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL))


def write_drive(path: Path) -> None:
    """Thirty seconds of the model car, its samples uneven in time."""
    driven = drive(ALL_DRIVE, seed=0).demonstrations
    rows = np.flatnonzero(np.random.default_rng(0).random(driven.n_observations) < 0.3)
    table = np.column_stack([driven.times, np.asarray(driven.states)[:, [0, 2]], driven.actions])[rows]
    np.savetxt(path, table, delimiter=",", header="t,speed,yaw_rate,steering,throttle", comments="")


@pytest.fixture
def tracks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a small tracks.csv and a drive.csv, made current."""
    states, _ = walkers(60)
    lines = ["x,y,t,id", *(f"{x},{y},{k % 10},{k // 10}" for k, (x, y) in enumerate(states))]
    (tmp_path / "tracks.csv").write_text("\n".join(lines))
    write_drive(tmp_path / "drive.csv")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(
    "name", ["README.md", "docs/how-to.md", "docs/tutorial.md", "docs/worlds.md", "docs/continuous.md"]
)
def test_python_runs_as_printed(name: str, tracks: Path) -> None:
    exec(compile(python_of(ROOT / name), name, "exec"), {})
    assert (tracks / "report.html").stat().st_size > 1_000_000


@pytest.mark.filterwarnings("ignore")
def test_single_rewards_run_as_printed(tracks: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = "docs/single-reward.md"
    exec(compile(python_of(ROOT / name), name, "exec"), {})
    assert "SingleReward(" in capsys.readouterr().out


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_relative_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if "://" not in link and not (page.parent / link).exists()]
    assert not missing
