"""What the page finds is what ``subgoal learn`` finds in the same path."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import subgoal
from subgoal.demonstrations.records import Recording
from subgoal.runtime.errors import InputError
from subgoal.teach.files import planar
from subgoal.teach.learning import FULL, SETTLED, Tuning, demonstrations_of, learn
from tests.demonstrations.valid_bags import pose, write_bag
from tests.teach.made import CORNERS, served, square

pytestmark = pytest.mark.filterwarnings("ignore::subgoal.posterior.sample.ConvergenceWarning")


def positions(found: Any) -> np.ndarray:
    return np.array([goal.position for goal in found])


def default_run(demos: subgoal.Demonstrations) -> Any:
    likelihood = subgoal.action_comparison(demos, subgoal.epsilon_net(demos), confidence=3.0)
    return subgoal.subgoals(subgoal.sample(likelihood, concentration=1.0, seed=0))


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a square that was drawn on the page."""
    out = tmp_path_factory.mktemp("out")
    with served(out) as server, server.opened() as page:
        page.draw(square())
        page.do("save")
        return Path(page.hear("saved")["folder"])


def rows_of(folder: Path) -> list[dict[str, str]]:
    with (folder / "recording.csv").open() as stream:
        return list(csv.DictReader(stream))


def test_every_point_is_saved_as_it_was_drawn(saved: Path) -> None:
    rows = [(float(row["time"]), float(row["y"]), float(row["z"])) for row in rows_of(saved)]
    assert rows == square()
    assert {row["stroke"] for row in rows_of(saved)} == {"stroke 1"}


def test_the_saved_subgoals_are_the_corners(saved: Path) -> None:
    found = [goal for goal in json.loads((saved / "summary.json").read_text())["subgoals"] if goal["counted"]]
    assert len(found) == 4
    gaps = np.linalg.norm(np.array([goal["position"] for goal in found])[:, None] - CORNERS[None], axis=2)
    assert gaps.min(axis=1).max() < 0.1
    assert sorted(gaps.argmin(axis=1)) == [0, 1, 2, 3]


def test_the_same_path_by_csv_has_the_same_subgoals(saved: Path) -> None:
    demos = subgoal.read(saved / "recording.csv", position=["y", "z"], trajectory="stroke", rate=20.0)
    found = default_run(demos)
    kept = subgoal.subgoals(subgoal.load(saved / "posterior.npz"))
    np.testing.assert_array_equal(positions(found), positions(kept))
    assert [goal.share for goal in found] == [goal.share for goal in kept]


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_the_same_path_by_a_bag_of_ros_2_has_the_same_subgoals(kind: str, saved: Path, tmp_path: Path) -> None:
    pytest.importorskip("rosbags", reason="the ros extra is not installed")
    messages = []
    for row in rows_of(saved):
        stamp = 10**9 + round(float(row["time"]) * 1e6) * 1000
        messages.append((stamp, pose(stamp, [0, float(row["y"]), float(row["z"]), 0, 0, 0, 1])))
    bag = write_bag(tmp_path, kind, {"/hand": messages})
    found = default_run(demonstrations_of(planar(subgoal.read_recording(bag))))
    kept = subgoal.subgoals(subgoal.load(saved / "posterior.npz"))
    np.testing.assert_allclose(positions(found), positions(kept), atol=1e-6)
    whole = default_run(subgoal.read(bag, rate=20.0))
    gaps = np.linalg.norm(positions(whole)[:4, None, 1:] - positions(kept)[None, :4], axis=2)
    assert gaps.min(axis=1).max() < 0.1


def test_the_quick_answer_is_that_of_the_default_run() -> None:
    rows = np.array(square())
    demos = demonstrations_of(Recording(rows[:, 1:], rows[:, 0], np.array([0, len(rows)]), ("y", "z"),
                                        trajectory_names=("stroke 1",)))  # fmt: skip
    quick, full = (learn(demos, Tuning(), stage) for stage in (SETTLED, FULL))
    assert quick.found.n_subgoals == full.found.n_subgoals == 4
    ours, theirs = positions(quick.found)[:4], positions(full.found)[:4]
    assert np.linalg.norm(ours[:, None] - theirs[None], axis=2).min(axis=1).max() < 0.1
    assert quick.status is not None


def test_learning_is_with_the_parameters_given() -> None:
    rows = np.array(square())
    demos = demonstrations_of(Recording(rows[:, 1:], rows[:, 0], np.array([0, len(rows)]), ("y", "z"),
                                        trajectory_names=("stroke 1",)))  # fmt: skip
    posterior = learn(demos, Tuning(7.0, 0.25), SETTLED).posterior
    assert posterior is not None
    assert (posterior.confidence, posterior.concentration, posterior.settings.seed) == (7.0, 0.25, 0)


def test_what_has_no_seconds_is_not_resampled() -> None:
    rows = np.array(square())[::10]
    recording = Recording(rows[:, 1:], np.arange(len(rows)), np.array([0, len(rows)]), ("y", "z"), time_unit="frame")
    assert demonstrations_of(recording).n_observations == len(rows)
    assert demonstrations_of(replace(recording, time_unit="s")).n_observations == 20 * (len(rows) - 1) + 1


def test_too_many_pairs_are_refused() -> None:
    rows = np.array(square())
    recording = Recording(rows[:, 1:], rows[:, 0], np.array([0, len(rows)]), ("y", "z"))
    with pytest.raises(InputError, match="at most 100"):
        demonstrations_of(recording, 100)
