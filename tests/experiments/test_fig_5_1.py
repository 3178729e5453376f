"""Figure 5-1: what each form of real-time dynamic programming says of a world with a shortcut."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments import fig_5_1
from experiments.common import Headline, Options, figure_style
from experiments.fig_5_1 import GAP, Planned, log_policy, numbers, picture, plan


@pytest.fixture(scope="module")
def planned() -> Planned:
    return plan(0)


@pytest.fixture(scope="module")
def headline(planned: Planned) -> Headline:
    return numbers(planned, 0)


def test_the_printed_form_never_meets_the_gap_and_the_bounded_form_does(planned: Planned) -> None:
    gap = planned.grid.state(*GAP)
    assert gap not in planned.literal.stages[-1].states
    assert gap in planned.bounded.envelope.states[planned.bounded.envelope.inside]
    sizes = [stage.states.size for stage in planned.literal.stages]
    assert sizes == sorted(set(sizes))
    assert planned.literal.ended


def test_errors_are_told_and_only_one_of_them_is_certified(headline: Headline) -> None:
    error = headline["largest_error"]
    assert error["bounded"] <= headline["certified_bound"] <= 0.01 / 20
    assert error["thesis"] > 5
    assert headline["best_action_at_the_start"] == {"exact": "SE", "bounded": "SE", "thesis": "NE"}
    assert headline["largest_error_of_a_log_probability"]["bounded"] <= 0.01
    assert headline["log_likelihood"]["thesis"] > headline["log_likelihood"]["exact"] + 50
    assert headline["thesis_with_a_simulation_from_every_state"]["largest_error"] > 5
    assert headline["states_inside"]["thesis"] < headline["states_inside"]["bounded"] < headline["states"]


def test_log_policy_is_a_softmax_of_ten_times_the_values() -> None:
    values = np.array([[0.0, 0.1, -np.inf], [5.0, 5.0, 5.0]])
    wanted: Any = [[1 / (1 + np.e), np.e / (1 + np.e), 0], [1 / 3] * 3]
    np.testing.assert_allclose(np.exp(log_policy(values)), wanted)


def test_the_picture_shows_three_stages_the_bounded_form_and_the_actions(planned: Planned, headline: Headline) -> None:
    with figure_style():
        figure = picture(planned, headline)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    stages = headline["stages"]
    for k, number in enumerate((0, len(stages) // 2, len(stages) - 1)):
        assert f"stage: {stages[number]} states" in titles[k]
    assert "of 1079 states" in titles[3]
    assert len(figure.axes) == 6


def test_a_quick_run_is_the_whole_run(tmp_path: Path, headline: Headline) -> None:
    assert fig_5_1.experiment(Options(tmp_path, quick=True))[0] == headline
