"""What the grid-world experiments share: demonstrators, layouts, and the measures they report."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import fig_4_1, fig_4_3, theorem_1
from experiments.common import Options
from experiments.grid_worlds import KEPT_FREE, cell, demonstrate, state, sweeps_to_minimum, world
from experiments.theorem_1 import best_so_far, corridor, posterior_by_enumeration, total_variation
from subgoal.mdp.planners.first_passage import plan_subgoals


@pytest.mark.parametrize("layout", [0, 1, 2, 77])
def test_layouts_keep_the_cells_of_the_thesis_free(layout: int) -> None:
    grid = world(layout)
    assert 300 < grid.n_states < 400
    for place in KEPT_FREE:
        assert cell(grid, state(grid, place)) == place


def test_the_first_layout_is_the_one_described() -> None:
    walls = {(int(x) + 1, int(y) + 1) for y, x in np.argwhere(~world(0).free)}
    wanted = {(6, y) for y in range(5, 16) if y != 10} | {(x, 14) for x in range(9, 18) if x != 13}
    assert walls == wanted | {(14, y) for y in range(3, 9)}


@pytest.mark.parametrize("stays", ["every", "last"])
def test_demonstrators_act_optimally_towards_each_subgoal_and_stay(stays: str) -> None:
    grid, setting = world(3), fig_4_3.SETTING
    shown = demonstrate(grid, setting.start, setting.subgoals, loops=2, stays=stays, seed=5)
    demos, stay = shown.demonstrations, grid.action("stay")
    goals = [state(grid, goal) for goal in setting.subgoals]
    for goal in goals:
        rows = np.flatnonzero(shown.served == goal)
        plan = plan_subgoals(grid.mdp, [goal], states=demos.states[rows])
        chosen = plan.action_values[np.arange(rows.size), demos.actions[rows], 0]
        assert (chosen >= plan.action_values[:, :, 0].max(axis=1) - 2 * plan.error_bound).all()
    stayed = demos.states[demos.actions == stay].tolist()
    assert stayed == (goals * 2 if stays == "every" else goals[-1:])
    order = shown.served[np.append(True, np.diff(shown.served) != 0)].tolist()
    assert order == goals * 2


def test_the_sweep_of_the_minimum() -> None:
    losses = np.tile([9.0, 6, 3, 1, 1, 1, 1, 1], (5, 1)) + np.arange(5)[:, None] * 1e-3
    assert sweeps_to_minimum(losses) == 4
    assert sweeps_to_minimum(np.ones((3, 10))) == 1


def test_a_quick_run_of_figure_4_1_finds_the_subgoals(tmp_path) -> None:
    headline, figure = fig_4_1.experiment(Options(tmp_path, quick=True))
    assert headline["runs_all_true_subgoals"] == headline["runs"]
    assert headline["sweeps_to_minimum_loss"] <= 40
    assert sorted(entry["cell"] for entry in headline["subgoals"][:3]) == [(2, 2), (2, 17), (10, 12)]
    assert len(figure.axes) == 4


def test_theorem_1_by_enumeration() -> None:
    exact = posterior_by_enumeration(corridor())
    assert exact.size == 5**5
    assert exact.sum() == pytest.approx(1, abs=1e-12)
    visits = np.array([[3, 1, 0], [2, 2, 2]])
    law = np.array([0.4, 0.3, 0.2, 0.1])
    np.testing.assert_allclose(best_so_far(law, visits), [[0.9, 0.7, 0.6], [0.8, 0.8, 0.8]])


def test_theorem_1_tells_the_printed_chain_from_the_right_one(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    headline, _ = theorem_1.experiment(Options(tmp_path, quick=True))
    variation = headline["total_variation"]
    assert variation["Algorithm 4 as printed"] > 0.3
    assert variation["Algorithm 4, corrected"] < 0.02
    assert variation["collapsed_blocks"] < 0.02
    for loss in headline["final_expected_loss"].values():
        assert loss == pytest.approx(headline["least_expected_loss"], abs=1e-9)
    monkeypatch.setattr(theorem_1, "SWEEPS", 10)
    even = np.tile(np.arange(4), 5).reshape(2, 10)
    assert total_variation(np.full(4, 0.25), even) == pytest.approx(0.5 * (2 * (5 / 18 - 0.25) + 2 * (0.25 - 4 / 18)))
