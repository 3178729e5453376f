"""Figure 7-9: what learned options of the model car come to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments import fig_7_9
from experiments.car_execution import Skills, at_full_rate, finely, longest, option_page, placed, settled
from experiments.car_study import CONDITIONS, Run
from experiments.common import Options, figure_style
from experiments.fig_7_9 import HARD, cell, learned, pooled, summed
from subgoal.dynamics.driver import path
from subgoal.options import execute

DRIVER = fig_7_9.DRIVERS[0]


@pytest.fixture(scope="module")
def given() -> Run:
    return CONDITIONS[HARD].run(DRIVER)


@pytest.fixture(scope="module")
def skills(given: Run) -> Skills:
    return learned(given, DRIVER)


@pytest.fixture(scope="module")
def row() -> dict:
    return cell(HARD, DRIVER, quick=True)


def test_each_manoeuvre_has_an_option_near_its_steady_state(given: Run, skills: Skills) -> None:
    assert set(skills) == set(given.driven.places)
    assert len({skill.candidate for skill, _ in skills.values()}) == 6
    for name, (skill, shown) in skills.items():
        assert skill.distance(given.driven.places[name].state[None])[0] < 1
        assert (np.diff(shown.offset) >= fig_7_9.SHORTEST).all()


def test_every_option_holds_its_goal_and_unrefined_drifts_are_lost(row: dict) -> None:
    assert all(all(each) for each in row["held"].values())
    assert all(part["none"] < 4 == part["from 4, four times"] for part in row["refined"].values())
    told = summed([row, row])
    assert (told["grip_held"], told["grip_tried"], told["drift_held"], told["drift_tried"]) == (32, 32, 16, 16)
    assert told["by_manoeuvre"]["left drift"] == [8, 8, 8]


def test_a_manoeuvre_that_was_not_found_counts_as_not_held(row: dict) -> None:
    lost = {**row, "held": {**row["held"], "right drift": [False] * 4}, "near": {**row["near"], "left": [False] * 4}}
    for part in ("whole", "half", "own"):
        lost[part] = {what: each for what, each in row[part].items() if what != "right drift"}
    told = summed([lost])
    assert (told["drift_held"], told["drift_tried"], told["grip_held"]) == (4, 8, 16)
    assert told["by_manoeuvre"]["left"] == [4, 0, 4]
    assert np.isnan(told["rmse_by_manoeuvre"]["right drift"]["vx"])
    assert np.isfinite(list(told["rmse"].values())).all()


def test_errors_are_pooled_over_stretches() -> None:
    parts = [np.array([[3.0, 0, 0, 1], [4, 0, 0, 1]]), np.array([[0.0, 2, 0, 1]])]
    wanted = [np.sqrt(25 / 3), np.sqrt(4 / 3), 0, 1]
    np.testing.assert_allclose(list(pooled(parts).values()), wanted)


def test_a_path_is_moved_to_where_it_begins() -> None:
    np.testing.assert_allclose(placed(np.array([[0.0, 0], [1, 0]]), np.array([5, 6, np.pi / 2])), [[5, 6], [5, 7]])


def test_executions_are_drawn_finely_and_pass_through_their_decisions(given: Run, skills: Skills) -> None:
    skill, shown = skills["left drift"]
    times, states = finely(skill, shown, given.model, 0, 1.0)
    assert times.size == len(states) == 51
    np.testing.assert_allclose(np.diff(times), 0.02)
    done = execute(skill, given.model, start=shown.states[0], duration=1.0, hold=True)
    np.testing.assert_allclose(states[::5], [*done.states, *done.final_states])
    np.testing.assert_allclose(states[7], given.model(done.states[1:2], done.actions[1:2], 0.04)[0])
    first, last = longest(shown)
    clock, seen = at_full_rate(given, shown, first, last)
    assert clock.size == 20 * (last - first)
    np.testing.assert_array_equal(seen[0], shown.states[first])
    assert np.abs(path(seen, clock)).max() < 20
    begin = settled(skill, shown)
    assert (skill.distance(np.asarray(shown.states)[begin:last]) <= 1).all()
    assert skill.distance(np.asarray(shown.states)[begin - 1 : begin])[0] > 1


def test_the_page_shows_paths_states_and_counts(given: Run, skills: Skills, row: dict) -> None:
    table = {name: summed([row]) for name in (HARD, "AWD n1")}
    with figure_style():
        figure = option_page(given, skills, table)
    titles = [axis.get_title(loc="left") for axis in figure.axes]
    for name in ("Left: ", "Right: ", "Left drift: "):
        assert any(title.startswith(name) for title in titles)
    assert sum(text.get_text() == "4/4" for axis in figure.axes for text in axis.texts) == 12


def test_a_quick_run_has_the_numbers_of_a_whole_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, row: dict) -> None:
    monkeypatch.setattr(fig_7_9, "cell", lambda *job: row)
    with figure_style():
        headline, _ = fig_7_9.experiment(Options(tmp_path, quick=True))
    assert headline["drivers"] == [DRIVER]
    assert headline["drift_grows_per_second"] > 5
    assert (headline["drift_held"], headline["grip_held"]) == (8, 16)
    assert set(headline["rmse"]) == {"vx", "vy", "r", "w"}
    assert set(headline["conditions"]) == {HARD, "AWD n1"}
