"""The three-dimensional scene: which axes share a scale, that all is in it, and the names beside it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from subgoal.answers.segments import segments
from subgoal.answers.subgoals import subgoals
from subgoal.demonstrations.metric import Metric
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.scene import scene_figure
from subgoal.reporting.tables import subgoal_table
from tests.plots.example import example

LETTERS = ("x", "y", "z")


def measured(units: str = "", weights: Any = (1, 1, 1), period: Any = (np.inf,) * 3, stretch: Any = 1) -> Posterior:
    """The example in three dimensions with another unit and metric, its places stretched."""
    posterior, _, _ = example(3)
    demos = posterior.demonstrations
    demos = replace(demos, units=units, states=np.asarray(demos.states) * stretch,
                    final_states=np.asarray(demos.final_states) * stretch)  # fmt: skip
    places = replace(posterior.candidates, points=posterior.candidates.points * stretch,
                     metric=Metric.of(3, weights, period))  # fmt: skip
    return replace(posterior, demonstrations=demos, candidates=places, likelihood=None)


def drawn(posterior: Posterior, **how: Any) -> tuple[dict[str, Any], list[dict[str, Any]], str]:
    """Scene, traces and note."""
    found = subgoals(posterior)
    figure, note = scene_figure(posterior, found, segments(posterior, found), **how)
    return figure["layout"]["scene"], figure["data"], note


def per_side(scene: dict[str, Any]) -> np.ndarray:
    """(3,) units of each axis on a side of length one."""
    return np.array([abs(np.diff(scene[f"{x}axis"]["range"])[0]) / scene["aspectratio"][x] for x in LETTERS])


@pytest.mark.parametrize("measure", [{}, {"units": "m"}, {"units": "m", "weights": (1, 2, 3)}])
def test_lengths_have_one_scale(measure) -> None:
    scene, _, note = drawn(measured(**measure, stretch=[1, 1, 4]))
    assert per_side(scene) == pytest.approx(per_side(scene)[0])
    assert "scale" not in note


def test_what_is_no_length_fills_its_side() -> None:
    scene, _, note = drawn(measured(weights=(1, 2, 0.1), stretch=[1, 1, 40]))
    assert len(set(scene["aspectratio"].values())) == 1
    assert note == "each axis has a scale of its own"


@pytest.mark.parametrize("units", ["", "m"])
def test_an_angle_fills_its_side_beside_lengths_of_one_scale(units) -> None:
    posterior = measured(units, weights=(1, 1, 0.5), period=(np.inf, np.inf, 2 * np.pi), stretch=[3, 1, 40])
    scene, _, note = drawn(posterior)
    across, up, turned = per_side(scene)
    assert across == pytest.approx(up)
    assert turned > 2 * across
    assert scene["aspectratio"]["z"] == max(scene["aspectratio"].values())
    assert "scale" in note


@pytest.mark.parametrize("measure", [{"units": "m"}, {"weights": (1, 2, 0.1)}])
@pytest.mark.parametrize("stretch", [[1, 1, 40], [1, 30, 1], [1, 1, 0]])
def test_all_is_within_the_box_and_the_box_within_view(measure, stretch) -> None:
    scene, data, _ = drawn(measured(**measure, stretch=stretch))
    for letter in LETTERS:
        low, high = scene[f"{letter}axis"]["range"]
        points = np.concatenate([trace[letter] for trace in data])
        margin = 0.04 * (np.nanmax(points) - np.nanmin(points))
        assert low < np.nanmin(points) - margin
        assert high > np.nanmax(points) + margin
    assert max(scene["aspectratio"].values()) <= 1.4
    assert np.linalg.norm(list(scene["aspectratio"].values())) <= 3**0.5 + 1e-9


def test_the_second_axis_may_point_down() -> None:
    plain, _, _ = drawn(measured("m"))
    turned, _, _ = drawn(measured("m"), y_down=True)
    assert turned["yaxis"]["range"] == plain["yaxis"]["range"][::-1]
    assert turned["zaxis"] == plain["zaxis"]


def test_positions_name_their_dimensions_and_the_unit_where_there_is_one() -> None:
    for units, heads in (("", ("Position (vx, vy, r)", "Radius")), ("m", ("Position (vx, vy, r) [m]", "Radius [m]"))):
        posterior = measured(units)
        posterior = replace(posterior, demonstrations=replace(posterior.demonstrations, names=("vx", "vy", "r")))
        page = subgoal_table(posterior, subgoals(posterior))
        assert all(f"<th>{head}</th>" in page for head in heads)
