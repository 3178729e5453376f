"""The how-to sections on how sure answers are run as printed, on a small recording."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import subgoal
from benchmarks.common import walkers
from tests.posterior.worlds import quiet_sample

PAGE = Path(__file__).parents[2] / "docs" / "how-to.md"
NAMES = (
    "See where one goal ends and the next begins",
    "Take the posterior to ArviZ",
    "Say the goal while the recording is still going on",
    "Say how sure the partition is",
    "Know how far the best draw is from the best there is",
    "Compare two models on trajectories they have not seen",
    "Set nothing by hand",
    "Compare animals, drivers or days",
    "See what hangs on the settings",
)


def python_of(name: str) -> str:
    """The Python of the section of that name."""
    section = PAGE.read_text(encoding="utf-8").split(f"## {name}\n")[1].split("\n## ")[0]
    return re.findall(r"```python\n(.*?)```", section, re.DOTALL)[0]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("name", NAMES)
def test_python_runs_as_printed(
    name: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    states, actions = walkers(60)
    demos = subgoal.Demonstrations.from_arrays(states, actions, np.arange(0, 61, 10))
    likelihood = subgoal.action_comparison(demos, subgoal.epsilon_net(demos), confidence=3)
    posterior = quiet_sample(likelihood, chains=4, draws=50, warmup=50, thin=1)
    exec(compile(python_of(name), name, "exec"), {"subgoal": subgoal, "demos": demos, "posterior": posterior})
    printed = capsys.readouterr().out
    assert printed.strip()


def test_every_room_can_be_entered() -> None:
    for room, names in {
        "certainty": ("best_draw", "boundaries", "credible_ball", "variation_of_information"),
        "online": ("OnlineFilter",),
        "validation": ("cross_validate", "leave_one_out"),
    }.items():
        assert all(callable(getattr(getattr(subgoal, room), name)) for name in names)
        assert room in dir(subgoal)


def test_nothing_heavy_loads_with_the_package() -> None:
    code = "import sys, subgoal; print([m for m in ('numba', 'arviz_base', 'xarray', 'scipy') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"
