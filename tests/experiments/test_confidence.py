"""Figures 7-7 and 7-8 and the expertise of drivers: claims from made numbers, and quick runs."""

from __future__ import annotations

import numpy as np
import pytest

from experiments import expertise, fig_7_7, fig_7_8
from experiments.common import Options, plain
from experiments.turn_study import LEVELS, METHODS, Turns, as_sweep, last_draws, of_plateau
from subgoal.continuous import confidence_sweep
from subgoal.dynamics.driver import turns
from subgoal.runtime.progress import Silent


def row(mean, v=0.9, most=1) -> dict:
    swept = as_sweep(np.array([[m] for m in mean]))
    return {
        "temporal": {"mean": swept.mean, "most": np.full(LEVELS.size, most), "v_measure": np.full(LEVELS.size, v),
                     "plateau_of_three": fig_7_8.plateau(swept)},
    }  # fmt: skip


SHAPED = np.array([1, 1, 1, 2, 2, 3, 3, 3, 3, 3, 3, 5, 8])


def verdicts(first: dict, second: dict) -> list[str]:
    return [claim["verdict"] for claim in fig_7_8.claims({"noise 0.5": first, "noise 1": second})]


def test_claims_hold_for_the_shape_of_the_thesis_and_for_no_other() -> None:
    assert verdicts(row(SHAPED), row(SHAPED)) == ["holds"] * 6
    broken = {0: row(SHAPED, most=2), 2: row(SHAPED, v=0.79), 3: row(np.minimum(SHAPED, 3))}
    for claim, wrong in broken.items():
        found = verdicts(row(SHAPED), wrong)
        assert found[claim] == "does not hold" and found.count("holds") == 5
    assert verdicts(row(SHAPED), row(np.where(SHAPED == 3, 4, SHAPED)))[1] == "does not hold"
    narrow = np.where(LEVELS > 30, 4, SHAPED)
    assert verdicts(row(narrow), row(narrow))[4:] == ["does not hold", "holds"]
    assert of_plateau(LEVELS).tolist() == [15, 20]


def test_chains_are_those_of_the_sweep() -> None:
    drive = Turns(1.0, 3)
    table = drive.table()
    level = int(np.flatnonzero(LEVELS == 7)[0])
    mine = [drive.run.judged(draw).subgoals for draw in last_draws(table, METHODS["temporal"], level, 2, seed=5)]
    found = confidence_sweep(table, LEVELS[: level + 1], trials=2, sweeps=300, seed=5, progress=Silent())
    assert found.counts[level].tolist() == mine


def test_the_first_drives_are_those_of_a_shorter_recording() -> None:
    whole = turns(fig_7_8.Turns(1.0, 0).run.model, duration=6.0, trajectories=3, seed=2)
    two = turns(fig_7_8.Turns(1.0, 0).run.model, duration=6.0, trajectories=2, seed=2)
    some = fig_7_7.first(whole, 2)
    np.testing.assert_array_equal(some.demonstrations.states, two.demonstrations.states)
    np.testing.assert_array_equal(some.labels, two.labels)


def test_ranks_are_uniform_and_as_correlated_as_asked() -> None:
    from scipy.stats import kstest, norm

    alone, series = (expertise.ranks(20_000, c, np.random.default_rng(0)) for c in (0.0, 0.8))
    assert kstest(alone, "uniform").pvalue > 0.001
    value = norm.ppf(series)
    assert np.corrcoef(value[1:], value[:-1])[0, 1] == pytest.approx(0.8, abs=0.02)
    assert series.mean() == pytest.approx(0.5, abs=0.02)


def test_the_slope_leaves_out_what_is_open() -> None:
    noises = np.array([1.0, 2.0, 4.0])
    median = np.array([[7.0, 25.0, 6.25]])
    assert expertise.slope(noises, median, np.array([[True, False, False]])) == pytest.approx(-2)


@pytest.mark.t2
@pytest.mark.parametrize("experiment", [fig_7_7, fig_7_8, expertise])
def test_quick_runs_hold_and_can_be_written(experiment, tmp_path) -> None:
    headline, figure = experiment.experiment(Options(tmp_path, quick=True))
    assert plain(headline)["claims"] and len(figure.axes) >= 2
    assert all(claim["verdict"] in ("holds", "does not hold") for claim in headline["claims"])
