"""Real recordings with known goals, at the default settings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import subgoal
from experiments.common import find_data

CORNERS = {"Line": [(0, 0)], "Angle": [(-25, 39), (0, 0)], "Zshape": [(-3, 40), (-40, 5), (0, 0)]}
TURNING_PLACES = [
    (1.08, 0.64, 1.34), (1.42, 0.64, 1.76), (1.29, 0.95, 1.58),
    (1.25, 0.29, 1.57), (1.02, 0.59, 1.66), (1.44, 0.56, 1.41),
]  # fmt: skip


def folder_of(name: str) -> Path:
    folder, reason = find_data(name, None)
    if folder is None:
        pytest.skip(str(reason))
    return folder


def learn(demos: subgoal.Demonstrations) -> tuple[subgoal.Posterior, np.ndarray]:
    """Posterior and places with at least 5 %."""
    posterior = subgoal.sample(subgoal.action_comparison(demos, subgoal.epsilon_net(demos)))
    return posterior, np.array([goal.position for goal in subgoal.subgoals(posterior) if goal.share >= 0.05])


def farthest(wanted: list[tuple[float, ...]], places: np.ndarray) -> float:
    """Largest distance from a wanted place to the place nearest to it."""
    return float(np.linalg.norm(np.array(wanted)[:, None] - places[None], axis=2).min(axis=1).max())


@pytest.mark.parametrize("shape", CORNERS)
def test_pen_strokes_have_their_corners_and_their_end(shape: str) -> None:
    demos = subgoal.read(folder_of("lasa_handwriting") / f"{shape}.mat", every=20)
    posterior, places = learn(demos)
    assert posterior.status is subgoal.Status.CONVERGED
    assert len(places) == len(CORNERS[shape])
    assert farthest(CORNERS[shape], places) <= 0.1 * demos.extent


def test_a_hand_that_goes_to_and_fro_turns_at_six_places() -> None:
    path = folder_of("tum_rgbd_handheld") / "freiburg1_xyz-groundtruth.txt"
    posterior, places = learn(subgoal.read(path, rate=20))
    assert posterior.status is subgoal.Status.CONVERGED
    assert len(places) <= 8
    assert farthest(TURNING_PLACES, places) <= 0.12
