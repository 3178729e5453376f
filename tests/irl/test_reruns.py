"""Reruns of a posterior: what is run, what is told of it, and Ctrl-C."""

from __future__ import annotations

import os
import signal
import warnings
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from subgoal import models
from subgoal.answers.subgoals import subgoals
from subgoal.irl import sensitivity as rooms
from subgoal.irl.reruns import Sensitivity
from subgoal.irl.sensitivity import sensitivity
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.progress import Silent
from tests.posterior.worlds import corner_likelihood, quiet_sample

LENGTH = {"chains": 2, "draws": 12, "warmup": 8, "thin": 1}


@cache
def learned() -> Posterior:
    table = corner_likelihood(2.0).weighted(0.5)
    return quiet_sample(
        table, model=models.Persistent(), concentration=models.Gamma(), confidence=models.NoiseLevels((1.0, 8.0)),
        **LENGTH, seed=4,
    )  # fmt: skip


@cache
def analysed() -> Sensitivity:
    return sensitivity(learned(), progress=Silent(), workers=1, seed=4, **LENGTH)


def test_the_posterior_itself_comes_first_and_the_same_run_gives_the_same_answer() -> None:
    base, again = analysed().rows[:2]
    assert (base.kind, again.kind) == ("as sampled", "again")
    for row in (base, again):
        assert row.moved.tolist() == [0.0] * len(analysed().top)
        assert np.abs(row.change).max() < 1e-12
        assert row.persistence == learned().parameters["persistence"].mean()
        assert row.concentration == learned().parameters["concentration"].mean()
        assert (row.n_observations, row.worth, row.status) == (80, 40.0, learned().status)
        assert row.rhat == max(each.rhat for each in learned().diagnostics.values())


def test_every_setting_is_run_with_what_it_changes() -> None:
    table = analysed()
    assert len(table.rows) == 10
    assert table.left_out == ()
    rates = [row for row in table.rows if row.kind == "rate"]
    assert [(row.every, row.n_observations) for row in rates] == [(2, 40), (4, 20)]
    assert [row.worth for row in table.rows if row.kind == "weight"] == [20.0, 80.0]
    low, high = (row.concentration for row in table.rows if "rate" in row.setting)
    assert low > high
    assert all(row.persistence == row.persistence for row in table.rows)
    share = np.array([goal.share for goal in table.top])
    assert max(row.largest_change for row in table.rows) > 0.01
    for row in table.rows:
        assert row.shares - row.change == pytest.approx(share)


def test_the_weight_is_learned_anew_by_learn_and_only_then(monkeypatch: pytest.MonkeyPatch) -> None:
    called = []

    def learn(likelihood: LogLikelihood, **options: Any) -> Posterior:
        called.append((likelihood.n_observations, likelihood.weight, options["confidence"]))
        return quiet_sample(likelihood.weighted(0.25), **{**options, "progress": None})

    monkeypatch.setattr(rooms, "learn", learn)
    found = sensitivity(learned(), progress=Silent(), workers=1, **LENGTH)
    assert called == [(40, None, models.NoiseLevels((1.0, 8.0))), (20, None, models.NoiseLevels((1.0, 8.0)))]
    assert [row.worth for row in found.rows if row.kind == "rate"] == [10.0, 5.0]
    assert len(sensitivity(learned(), reweigh=False, progress=Silent(), workers=1, **LENGTH).rows) == 10
    assert len(called) == 2


class Stopper(Silent):
    """Sends Ctrl-C once so many sweeps are done, and keeps what it was told."""

    def __init__(self, at: int) -> None:
        self.at, self.told, self.sent = at, [], False

    def update(self, done: int, total: int, note: str = "") -> None:
        self.told.append((done, total, note))
        if done >= self.at and not self.sent:
            self.sent = True
            os.kill(os.getpid(), signal.SIGINT)


def test_ctrl_c_gives_what_is_finished_and_names_the_rest() -> None:
    """In the middle of the third rerun."""
    posterior = quiet_sample(corner_likelihood(4.0), **LENGTH)
    one = 6000
    stopper = Stopper(2 * one + 1)
    found = sensitivity(posterior, progress=stopper, workers=1, chains=2, draws=3000, warmup=0, thin=1)
    assert [row.setting for row in found.rows[1:]] == ["the same again", "concentration halved, 0.5"]
    assert found.left_out[0] == "concentration doubled, 2"
    assert len(found.rows) - 1 + len(found.left_out) == 7
    assert {total for _, total, _ in stopper.told} == {7 * one}
    assert stopper.told[-1][2] == "concentration doubled, 2"
    assert f"{found.left_out[-1]}  not run" in str(found)


def test_ctrl_c_in_a_warm_up_gives_what_is_finished_too() -> None:
    posterior = quiet_sample(corner_likelihood(4.0), **LENGTH)
    stopper = Stopper(2 * 12_000 + 1)
    found = sensitivity(posterior, progress=stopper, workers=1, chains=2, draws=1, warmup=5999, thin=1)
    assert len(found.rows) == 3
    assert len(found.left_out) == 5


def test_the_draws_of_the_user_are_those_of_sample() -> None:
    posterior = quiet_sample(corner_likelihood(4.0), **LENGTH)
    found = sensitivity(posterior, progress=Silent(), workers=1, seed=9, **LENGTH)
    direct = quiet_sample(corner_likelihood(4.0), concentration=0.5, seed=9, **LENGTH)
    row = next(row for row in found.rows if row.setting == "concentration halved, 0.5")
    assert row.n_subgoals == subgoals(direct).n_subgoals
    assert row.rhat == max(each.rhat for each in direct.diagnostics.values())


def test_given_subgoals_are_the_ones_that_are_followed() -> None:
    posterior = quiet_sample(corner_likelihood(4.0), **LENGTH)
    apart = subgoals(posterior, merge_radius=0.0)
    assert apart.n_subgoals > subgoals(posterior).n_subgoals
    found = sensitivity(posterior, found=apart, progress=Silent(), workers=1, seed=0, **LENGTH)
    assert len(found.top) == found.rows[0].n_subgoals == found.rows[1].n_subgoals == apart.n_subgoals
    assert all(np.nanmax(np.append(each.moved, 0)) == 0 for each in found.rows)


def test_no_warning_of_short_runs() -> None:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sensitivity(replace(learned()), progress=Silent(), workers=1, **LENGTH)
    assert [str(each.message) for each in told] == []
