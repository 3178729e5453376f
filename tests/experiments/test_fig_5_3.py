"""Figure 5-3: worlds of any size, demonstrations in them, methods that are timed, and what is said of their times."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments import fig_5_3
from experiments.common import Headline, Options, figure_style
from experiments.fig_5_3 import by_the_clock, crossover, mean, ratios
from experiments.large_grids import CONFIDENCE, FARTHEST, SIDE, Case, draw, free_cells, layouts, window
from experiments.large_methods import (
    ABBEEL,
    ABBEEL_RTDP,
    EXACT,
    METHODS,
    PARALLEL,
    RTDP,
    SWEEPS,
    TOLERANCE,
    Measured,
    assigned_loss,
    candidates_of,
    plain,
)
from experiments.large_picture import picture
from subgoal.answers.scores import assignment_loss
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp import GridWorld, ImplicitGrid, plan_subgoals


def test_every_block_has_one_of_the_layouts_and_the_walls_do_not_hang_on_how_they_are_asked_for() -> None:
    part = window(3, 7 * SIDE, 11 * SIDE, SIDE, SIDE)
    assert (part.free == layouts()).all(axis=(1, 2)).any()
    free = free_cells(3)
    x, y = np.random.default_rng(0).integers(0, 10_000, (2, 20_000))
    np.testing.assert_array_equal(free(x, y), np.array([free(a, b) for a, b in zip(x[:50], y[:50], strict=True)] +
                                                       free(x[50:], y[50:]).tolist()))  # fmt: skip
    assert 0.06 < 1 - free(x, y).mean() < 0.09
    used = {window(3, SIDE * k, SIDE * k * k, SIDE, SIDE).free.tobytes() for k in range(40)}
    assert len(used) > 20
    upwards = {window(3, 0, SIDE * k, SIDE, SIDE).free.tobytes() for k in range(40)}
    assert len(upwards) > 20
    assert (free(x, y) != free_cells(4)(x, y)).any()


@pytest.mark.parametrize("power", [3, 9])
def test_demonstrations_go_step_by_step_to_a_goal_that_is_not_too_far(power: int) -> None:
    case = draw(power, 5)
    world = case.world()
    assert isinstance(world, GridWorld if power == 3 else ImplicitGrid)
    steps = np.diff(case.cells, axis=0)
    assert np.abs(steps).max() == 1
    assert np.abs(case.cells[-1] - case.cells[0]).max() <= FARTHEST
    assert case.actions[-1] == world.n_actions - 1
    assert (case.actions[:-1] < world.n_actions - 1).all()
    demos = case.demonstrations(world)
    np.testing.assert_array_equal(demos.states, world.states(case.cells))
    assert case.n_states == pytest.approx(10**power, rel=0.1)
    np.testing.assert_array_equal(draw(power, 5).cells, case.cells)


@pytest.fixture(scope="module")
def case() -> Case:
    return draw(3, 1)


@pytest.fixture(scope="module")
def measured(case: Case) -> dict[str, Measured]:
    return {name: method(case, None) for name, method in METHODS.items()}


def test_plain_value_iteration_is_within_what_it_was_asked_for(case: Case) -> None:
    mdp: Any = case.world()
    mdp = mdp.mdp
    states = np.arange(0, mdp.n_states, 50)
    goals = [np.array([3]), np.array([400])]
    found = plain(mdp, goals, states=states, tolerance=0.01)
    exact = plan_subgoals(mdp, goals, states=states)
    assert np.abs(found.action_values - exact.action_values).max() <= 0.01
    assert found.error_bound <= 0.01


def test_all_methods_are_timed_and_scored(measured: dict[str, Measured]) -> None:
    candidates = {each.candidates for each in measured.values()}
    assert len(candidates) == 1
    for name in (SWEEPS, EXACT, RTDP, PARALLEL):
        each = measured[name]
        assert each.gap is not None
        assert each.gap <= 2 * CONFIDENCE * TOLERANCE
        assert each.planning_seconds is not None
        assert 0 < each.planning_seconds < each.seconds
    assert measured[SWEEPS].loss == pytest.approx(measured[EXACT].loss, abs=0.05)
    assert measured[RTDP].loss == measured[PARALLEL].loss
    assert measured[RTDP].loss_of_the_middle == pytest.approx(measured[EXACT].loss, abs=1e-9)
    for name in (ABBEEL, ABBEEL_RTDP):
        assert measured[name].loss < 0.5
        assert measured[name].gap is None
    assert measured[ABBEEL_RTDP].value_bound is not None


def test_the_loss_is_that_of_the_assignment(case: Case) -> None:
    world: Any = case.world()
    demos = case.demonstrations(world)
    likelihood = planned_actions(demos, candidates_of(demos.states, 5), world.mdp, planner=plan_subgoals)
    assigned = np.arange(demos.n_observations) % 3
    wanted = assignment_loss(likelihood, assigned) / assigned.size
    assert assigned_loss(likelihood.source, assigned) == pytest.approx(wanted)  # type: ignore[arg-type]


def test_value_iteration_on_a_few_candidates_is_scaled_up_and_has_no_loss(case: Case) -> None:
    few = METHODS[SWEEPS](case, 2)
    assert (few.scaled_from, few.loss) == (2, None)
    assert few.candidates > 2
    assert METHODS[SWEEPS](case, few.candidates).scaled_from is None


def test_a_few_candidates_hold_the_end_of_the_way() -> None:
    states = np.array([9, 1, 7, 5, 3, 2, 8, 4])
    sets: Any = candidates_of(states, 4).goal_sets
    assert len(sets) == 4
    assert 4 in np.concatenate(sets)
    every: Any = candidates_of(states, None).goal_sets
    assert np.concatenate(every).tolist() == sorted(states)


def row(method: str, cells: int, seconds: list[float], wall: float = 1.0, loss: float | None = 0.1) -> Headline:
    return {
        "method": method, "cells": cells, "states": 0.9 * cells, "seconds_of_each": seconds, "draws": len(seconds),
        "wall_seconds": wall, "seconds": float(np.mean(seconds)), "loss": loss, "scaled_from_candidates": None,
        "loss_of_the_middle": loss,
    }  # fmt: skip


ROWS = [
    row(EXACT, 100, [1.0, 1.0, 148.0, 9.0]), row(RTDP, 100, [2.0, 6.0, 592.0], 3.0), row(PARALLEL, 100, [1.0], 2.0),
    row(EXACT, 10_000, [16.0]), row(RTDP, 10_000, [2.0, 9.0], 4.0), row(PARALLEL, 10_000, [1.0], 1.0),
]  # fmt: skip


def test_ratios_are_of_the_draws_that_both_have() -> None:
    assert ratios(ROWS, EXACT) == [(90, 0.25), (9000, 8.0)]
    assert ratios(ROWS, SWEEPS) == []
    assert by_the_clock(ROWS) == [(90, 1.5), (9000, 4.0)]


def test_the_crossover_lies_between_the_sizes_where_the_ratio_passes_one() -> None:
    assert crossover(ROWS) == pytest.approx(90 * 100**0.4)
    assert crossover(ROWS[:3]) is None


def test_a_mean_of_what_is_not_known_is_not_known() -> None:
    assert mean([1.0, 3.0]) == 2
    assert mean([1.0, None]) is None


def test_the_picture_names_its_lines_and_says_where_they_cross() -> None:
    headline = {
        "rows": ROWS, "value_iteration_over_rtdp": [(9000.0, 77.0)], "crossover_with_first_passage_in_states": 900.0,
    }  # fmt: skip
    with figure_style():
        figure = picture(headline)
    cost, fit = figure.axes
    assert {EXACT, RTDP} <= {text.get_text() for text in cost.texts}
    assert any(text.get_text().startswith(PARALLEL) for text in cost.texts)
    assert any("9,000 states: 77" in text.get_text() for text in cost.texts)
    assert any("from about 900 states" in text.get_text() for text in cost.texts)
    assert {EXACT, RTDP} <= {text.get_text() for text in fit.texts}


@pytest.mark.t2
def test_a_quick_run_has_a_small_row_of_every_method_and_a_million_cells(tmp_path: Path) -> None:
    headline, _ = fig_5_3.experiment(Options(tmp_path, quick=True))
    assert {row["method"] for row in headline["rows"] if row["cells"] == 1000} == set(METHODS)
    large = [row for row in headline["rows"] if row["cells"] == 10**6]
    assert {row["method"] for row in large} == {RTDP, PARALLEL}
    assert all(row["candidates"] == 20 and row["gap"] <= 0.01 for row in large)
    assert len(headline["value_iteration_over_rtdp"]) == 1
