"""What planning knows of each subgoal: values, and where the best action leads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import subgoal
from subgoal.answers.portraits import MOST_ROWS, _clearest, portraits
from subgoal.plots import plot_portraits
from subgoal.reporting.portraits import portrait_figure
from tests.likelihood.point_mass import STEP, plane, there_and_back
from tests.posterior.worlds import corner_likelihood, quiet_sample

DEMOS, _, CORNERS = there_and_back()


@pytest.fixture(scope="module")
def found():
    with pytest.warns():
        made = subgoal.gpsrl(DEMOS, plane(), radius=0.3, confidence=40.0, seed=1, chains=2, warmup=50, draws=50, thin=1)
    return made, subgoal.subgoals(made)


def test_values_are_those_of_the_best_test_action(found):
    posterior, merged = found
    seen = portraits(posterior, merged)
    source = posterior.likelihood.source
    for k, goal in enumerate(merged.listed):
        wanted = source.tested(0, DEMOS.n_observations)[seen.rows, :, goal.candidate].max(axis=1)
        np.testing.assert_allclose(seen.values[:, k], wanted)


def test_motion_is_towards_the_subgoal_at_the_speed_there_is(found):
    posterior, merged = found
    seen = portraits(posterior, merged)
    for k, goal in enumerate(merged.listed):
        way = goal.position - seen.states
        far = np.linalg.norm(way, axis=1) > 1.5
        assert (np.sum(way * seen.moved[:, k], axis=1)[far] > 0).all()
        assert (np.abs(seen.moved[:, k]) <= STEP + 1e-12).all()


def test_a_held_subgoal_is_worth_almost_the_whole_future(found):
    seen = portraits(*found)
    assert ((seen.held > 0.6) & (seen.held <= 1)).all()


def test_long_recordings_are_looked_at_here_and_there(found, monkeypatch):
    monkeypatch.setattr("subgoal.answers.portraits.MOST_ROWS", 10)
    seen = portraits(*found)
    assert MOST_ROWS > seen.rows.size == 10
    assert seen.rows[[0, -1]].tolist() == [0, DEMOS.n_observations - 1]


def test_the_dimensions_shown_are_those_that_tell_subgoals_apart(found):
    """A third dimension that hardly changes is not shown."""
    posterior, merged = found
    flat = [replace(goal, position=np.append(goal.position, 0.01 * k)) for k, goal in enumerate(merged.items)]
    metric = subgoal.Metric.euclidean(3)
    places = posterior.candidates
    points = np.column_stack([places.points, np.zeros(places.n_candidates)])
    wide = replace(posterior, candidates=replace(places, points=points, metric=metric))
    assert _clearest(wide, replace(merged, items=tuple(flat))) == (0, 1)


def test_other_likelihoods_have_none():
    posterior = quiet_sample(corner_likelihood(), chains=2, draws=20, warmup=20, thin=1)
    assert portraits(posterior, subgoal.subgoals(posterior)) is None
    assert portraits(replace(posterior, likelihood=None), subgoal.subgoals(posterior)) is None


def test_a_panel_for_each_listed_subgoal(found):
    posterior, merged = found
    figure = plot_portraits(posterior, merged, portraits(posterior, merged))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert sum("held" in title for title in titles) == len(merged.listed)


def test_the_page_shows_one_subgoal_at_a_time(found):
    posterior, merged = found
    figure = portrait_figure(posterior, merged, portraits(posterior, merged))
    assert [trace["visible"] for trace in figure["data"][:4]] == [True, True, True, False]
    buttons = figure["layout"]["updatemenus"][0]["buttons"]
    assert len(buttons) == len(merged.listed)
    assert buttons[1]["args"][0]["visible"][3:6] == [True] * 3
    assert sum(buttons[1]["args"][0]["visible"]) == 3
