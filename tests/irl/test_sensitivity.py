"""The answer under other settings: which settings, what of them is compared, and what is said of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from subgoal import models, samplers
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.as_sampled import AsSampled
from subgoal.irl.reruns import Rerun, Sensitivity
from subgoal.irl.sensitivity import matched
from subgoal.irl.variations import Variation, every_one_of, some_rows, variations
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from tests.answers.made import posterior_of
from tests.posterior.worlds import corner_likelihood

LENGTH = {"chains": 2, "draws": 12, "warmup": 8, "thin": 1}


def used(likelihood: LogLikelihood, concentration: Any = 2.0, confidence: Any = None, model: Any = None) -> AsSampled:
    return AsSampled(likelihood, concentration, confidence, model, samplers.collapsed_blocks)


def settings(found: list[Variation]) -> list[str]:
    return [variation.setting for variation in found]


def test_numbers_set_by_hand_are_halved_and_doubled() -> None:
    table = corner_likelihood(2.0, confidence=4.0)
    found = variations(used(table), reweigh=True)
    assert settings(found) == [
        "the same again", "concentration halved, 1", "concentration doubled, 4", "confidence halved, 2",
        "confidence doubled, 8", "every 2nd observation", "every 4th observation",
    ]  # fmt: skip
    assert [v.arguments["concentration"] for v in found] == [2.0, 1.0, 4.0, 2.0, 2.0, 2.0, 2.0]
    assert [v.likelihood.confidence for v in found] == [4.0, 4.0, 4.0, 2.0, 8.0, 4.0, 4.0]
    assert [v.likelihood.n_observations for v in found] == [80, 80, 80, 80, 80, 40, 20]
    assert [v.every for v in found] == [1, 1, 1, 1, 1, 2, 4]
    assert not any(v.reweighed for v in found)


def test_shape_and_rate_of_a_prior_are_halved_and_doubled() -> None:
    found = variations(used(corner_likelihood(2.0), models.Gamma(3.0, 1.0), models.NoiseLevels()), reweigh=True)
    priors = [v.arguments["concentration"] for v in found if v.kind == "concentration"]
    assert {(prior.shape, prior.rate) for prior in priors} == {(1.5, 1.0), (6.0, 1.0), (3.0, 0.5), (3.0, 2.0)}
    assert "concentration: shape halved, Gamma(1.5, 1)" in settings(found)
    assert not any(v.kind == "confidence" for v in found)


def test_one_weight_for_all_is_changed_and_estimated_anew_at_another_rate() -> None:
    found = variations(used(corner_likelihood(2.0).weighted(0.4)), reweigh=True)
    changed = [v for v in found if v.kind == "weight"]
    assert [v.setting[-11:] for v in changed] == ["halved, 0.2", "oubled, 0.8"]
    assert [v.likelihood.weight[0] for v in changed] == pytest.approx([0.2, 0.8])
    for v in found:
        assert v.reweighed == (v.kind == "rate")
        assert (v.likelihood.weight is None) == (v.kind == "rate")


def test_weights_that_differ_or_are_to_be_kept_are_thinned_along() -> None:
    weight = np.linspace(0.1, 1, 80)
    found = variations(used(corner_likelihood(2.0).weighted(weight)), reweigh=True)
    assert found[-1].likelihood.weight == pytest.approx(weight[::4])
    kept = variations(used(corner_likelihood(2.0).weighted(0.4)), reweigh=False)
    assert kept[-1].likelihood.weight == pytest.approx(np.full(20, 0.4))
    assert not any(v.reweighed for v in (*found, *kept))


def test_a_table_of_numbers_is_thinned_and_its_noise_left_alone() -> None:
    values = np.random.default_rng(0).normal(size=(9, 3))
    demos = Demonstrations.from_arrays(np.arange(9.0), np.ones(9), [0, 5, 9])
    table = LogLikelihood.from_table(values, demonstrations=demos).weighted(0.5)
    found = variations(used(table), reweigh=True)
    assert {v.kind for v in found} == {"again", "concentration", "weight", "rate"}
    assert found[-2].likelihood.rows(0, 5) == pytest.approx(0.5 * values[[0, 2, 4, 5, 7]])
    assert not found[-1].reweighed


def test_unordered_observations_have_no_rate() -> None:
    table = LogLikelihood.from_table(np.zeros((4, 2)))
    assert table.demonstrations.n_trajectories == 4
    assert {v.kind for v in variations(used(table), reweigh=True)} == {"again", "concentration"}


def test_rates_that_leave_no_trajectory_two_observations_are_left_out() -> None:
    demos = Demonstrations.from_arrays(np.arange(7.0), np.ones(7), [0, 4, 7])
    table = LogLikelihood.from_table(np.zeros((7, 2)), demonstrations=demos)
    assert [v.every for v in variations(used(table), reweigh=True) if v.kind == "rate"] == [2]


def test_every_other_observation_from_the_first_of_each_trajectory() -> None:
    demos = Demonstrations.from_arrays(np.arange(10.0), np.ones(10), [0, 5, 6, 10], times=np.arange(10.0))
    assert every_one_of(demos, 2).tolist() == [0, 2, 4, 5, 6, 8]
    assert every_one_of(demos, 4).tolist() == [0, 4, 5, 6]
    table = LogLikelihood.from_table(np.arange(20.0).reshape(10, 2), demonstrations=demos)
    fewer = some_rows(table, every_one_of(demos, 2)).demonstrations
    assert fewer.offset.tolist() == [0, 3, 4, 6]
    assert fewer.times.tolist() == [0, 2, 4, 5, 6, 8]
    assert fewer.final_states.tolist() == demos.final_states.tolist()


def test_rows_of_a_thinned_recording_are_rows_of_the_whole_one() -> None:
    table = corner_likelihood(2.0).with_background(0.2)
    rows = every_one_of(table.demonstrations, 4)
    assert some_rows(table, rows).rows(0, 20) == pytest.approx(table.rows(0, 80)[rows], abs=1e-12)


PLACES = Candidates(np.array([[0.0], [1.0], [10.0], [11.5], [30.0]]), radius=0.5)
"""Merged within 2.5: the first two, the next two, the last."""


def made(*counts: int) -> tuple[Posterior, Subgoals]:
    posterior = posterior_of(np.repeat(np.arange(5), counts)[None], PLACES)
    return posterior, subgoals(posterior)


def test_places_are_the_same_within_a_reach_and_most_of_the_shares_is_matched() -> None:
    _, base = made(50, 0, 30, 0, 20)
    top = tuple(base.items)
    again, found = made(0, 60, 0, 40, 0)
    places, shares, moved = matched(top, found, again, 5.0)
    assert places[:2].ravel().tolist() == [1.0, 11.5]
    assert moved[:2].tolist() == [1.0, 1.5]
    assert shares.tolist() == [0.6, 0.4, 0.0]
    assert np.isnan(moved[2])
    near, _, short = matched(top, found, again, 1.2)
    assert near[0] == 1.0
    assert np.isnan(short[1:]).all()


def test_each_place_is_that_of_one_subgoal_at_most_and_the_nearer_of_two_is_taken() -> None:
    """A fifth of all at 0 moves to 1; with a reach of 12 the place at 10 is within reach of both."""
    again, found = made(0, 20, 80, 0, 0)
    top = tuple(made(20, 0, 80, 0, 0)[1].items)
    places, shares, moved = matched(top, found, again, 12.0)
    assert places.ravel().tolist() == [10.0, 1.0]
    assert (shares.tolist(), moved.tolist()) == ([0.8, 0.2], [0.0, 1.0])


def test_a_large_share_farther_off_goes_before_a_small_one_that_is_near() -> None:
    again, found = made(2, 0, 198, 0, 0)
    places, shares, _ = matched(tuple(made(60, 0, 0, 0, 0)[1].items), found, again, 12.0)
    assert (places.ravel().tolist(), shares.tolist()) == ([10.0], [0.99])


def test_of_two_that_match_as_much_the_nearer_is_taken() -> None:
    again, found = made(35, 0, 0, 0, 65)
    top = tuple(item for item in made(0, 0, 30, 0, 70)[1].items if item.share == 0.3)
    assert matched(top, found, again, 31.0)[0].ravel().tolist() == [0.0]


def test_without_a_radius_only_the_place_itself_is_the_same() -> None:
    again, found = made(40, 0, 60, 0, 0)
    top = tuple(made(50, 0, 0, 50, 0)[1].items)
    _, shares, _ = matched(top, found, again, 0.0)
    assert sorted(shares.tolist()) == [0.0, 0.4]


def test_nothing_to_match() -> None:
    again, found = made(100, 0, 0, 0, 0)
    places, shares, moved = matched((), found, again, 1.0)
    assert (places.shape, shares.shape, moved.shape) == ((0, 1), (0,), (0,))


def row(setting: str, kind: str, n: int = 2, moved: Any = (0.0, 0.0), change: Any = (0.0, 0.0), **other: Any) -> Rerun:
    fields: dict[str, Any] = {
        "every": 1, "n_observations": 100, "worth": 50.0, "places": np.zeros((2, 1)), "shares": np.zeros(2),
        "persistence": float("nan"), "concentration": 1.0, "rhat": 1.0, "status": Status.CONVERGED,
    } | other  # fmt: skip
    return Rerun(setting, kind, n_subgoals=n, moved=np.array(moved), change=np.array(change), **fields)


def table_of(*rows: Rerun, left_out: tuple[str, ...] = ()) -> Sensitivity:
    return Sensitivity(tuple(made(50, 0, 50, 0, 0)[1].items), (row("as sampled", "as sampled"), *rows), left_out, "m")


def test_what_is_said_when_all_stays() -> None:
    table = table_of(
        row("the same again", "again", n=5, moved=(9, 9), change=(0.02, -0.04)),
        row("A", "concentration", moved=(0.5, 1.25), change=(0.01, -0.07)),
        row("B", "rate", moved=(0.5, 0), change=(0.03, 0.0)),
    )
    assert table.verdict == (
        "Under 2 other settings the number of subgoals stays 2, and 5 by chance in a mere repetition. Places move by "
        "at most 1.25 m, shares by at most 7.0 percentage points (A; 4.0 points are chance)."
    )
    assert [each.setting for each in table.reruns] == ["A", "B"]


def test_what_is_said_when_it_does_not() -> None:
    table = table_of(
        row("A", "concentration", n=1, moved=(0.5, np.nan), change=(0.01, -0.3), rhat=1.051),
        row("B", "rate", n=4, moved=(np.nan, np.nan), change=(-0.6, -0.3), rhat=1.05),
    )
    assert table.verdict == (
        "Under 2 other settings the number of subgoals is 2 here and 1 to 4 elsewhere; a subgoal is missing under 2 of "
        "them. Places move by at most 0.5 m, shares by at most 60.0 percentage points (B). 1 of these short reruns "
        "has not settled (R-hat above 1.05)."
    )
    assert [each.lost for each in table.rows] == [0, 1, 2]
    assert table_of().verdict == "No other setting was tried."
    loose = replace(table, rows=(replace(table.rows[0], rhat=np.inf), *table.rows[1:]))
    assert loose.verdict == table.verdict + " The posterior itself has not settled."


def test_printed_table() -> None:
    table = table_of(row("A", "rate", n=3, moved=(0.5, np.nan), change=(0.01, -0.3), persistence=0.9), left_out=("C",))
    _, heads, base, a, c = str(table).splitlines()
    assert heads.split()[:4] == ["setting", "subgoals", "lost", "moved"]
    assert base.split() == ["as", "sampled", "2", "–", "0", "0.0", "%", "1", "50", "1.00"]
    assert a.split() == ["A", "3", "1", "0.5", "30.0", "%", "0.900", "1", "50", "1.00"]
    assert c == "C  not run"
    assert repr(table) == "Sensitivity(1 reruns, 2 subgoals)"
    assert repr(table.rows[1]) == "Rerun('A', 3 subgoals)"
