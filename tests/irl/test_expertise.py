"""How exactly a demonstrator acts: the posterior of α against quadrature, weights, coverage, and its honest limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import norm

from subgoal import LogLikelihood
from subgoal.irl.expertise import compare_expertise, expertise
from subgoal.irl.expertise_record import ExpertiseTable
from subgoal.likelihood.gp_values import steps_between
from subgoal.runtime.errors import InputError
from tests.irl.energies import Bell, Energies, drawn, table

PRIOR = np.log([0.2, 0.3, 0.5])


def by_quadrature(source: Energies, weight=1.0, prior=PRIOR, chances=(0.05, 0.5, 0.95)) -> list[float]:
    """Quantiles of α on a fine grid of log α, flat: the goal summed out."""
    levels = np.exp(np.linspace(np.log(0.01), np.log(1e4), 4001))
    n = len(source.actions)
    log_joint = []
    for alpha in levels:
        above = alpha * source.values
        above = above - above.max(axis=1, keepdims=True)
        rows = above[np.arange(n), source.actions] - np.log(np.exp(above).sum(axis=1))
        log_joint.append(logsumexp(prior + (np.broadcast_to(weight, n)[:, None] * rows).sum(axis=0)))
    law = np.exp(np.array(log_joint) - np.max(log_joint))
    return [float(x) for x in np.exp(np.interp(chances, law.cumsum() / law.sum(), np.log(levels)))]


def drawn_well(seed: int) -> Energies:
    return drawn(80, confidence=6.0, seed=seed)


@pytest.mark.parametrize("seed", range(4))
def test_median_and_interval_are_those_of_the_posterior(seed: int) -> None:
    source = drawn_well(seed)
    found = expertise(table(source, prior=PRIOR), weight=1.0)
    low, middle, high = by_quadrature(source)
    assert found.interval == pytest.approx((low, high), rel=5e-3)
    assert found.confidence == pytest.approx(middle, rel=5e-3)
    assert (
        np.trapezoid(found.density, np.log(found.confidences)) == pytest.approx(1)
        and found.goal == 0
        and found.worth == 80
    )
    half = expertise(table(source, prior=PRIOR), weight=1.0, level=0.5)
    assert half.interval == pytest.approx(by_quadrature(source, chances=(0.25, 0.75)), rel=5e-3)


def test_the_goal_is_summed_out_under_its_prior() -> None:
    """Ten observations leave it open which goal it was."""
    source = drawn(10, confidence=6.0, seed=1)
    for prior in (np.log([0.01, 0.01, 0.98]), np.log([0.98, 0.01, 0.01])):
        found = expertise(table(source, prior=prior), weight=1.0)
        low, middle, high = by_quadrature(source, prior=prior)
        assert (found.interval[0], found.confidence, found.interval[1]) == pytest.approx((low, middle, high), rel=2e-2)
    assert 0 < found.goal_probability < 1


def test_weights_are_powers_of_the_likelihood() -> None:
    source = drawn_well(2)
    each = np.linspace(0.2, 1.0, 80)
    weighed = table(source, prior=PRIOR, weight=each)
    found = expertise(weighed)
    assert found.interval == pytest.approx(by_quadrature(source, each)[::2], rel=5e-3)
    assert found.worth == pytest.approx(each.sum())
    told = expertise(weighed, weight=0.25)
    assert told.interval == pytest.approx(by_quadrature(source, 0.25)[::2], rel=5e-3)
    assert told.worth == pytest.approx(20)


def test_an_action_that_is_repeated_counts_once() -> None:
    once = drawn(150, seed=3)
    six = Energies(np.repeat(once.values, 6, axis=0), np.repeat(once.actions, 6))
    found, alone = expertise(table(six)), expertise(table(once))
    assert 90 <= found.worth <= 250 and alone.worth > 100
    assert expertise(table(six), weight=1.0).worth == 900
    assert found.confidence == pytest.approx(alone.confidence, rel=0.05)


@pytest.mark.parametrize("repeats", [1, 5])
def test_intervals_cover_the_confidence_that_actions_were_drawn_with(repeats: int) -> None:
    covered = 0
    for seed in range(100):
        made = drawn(60, confidence=4.0, seed=seed)
        source = Energies(np.repeat(made.values, repeats, axis=0), np.repeat(made.actions, repeats))
        low, high = expertise(table(source)).interval
        covered += low <= 4.0 <= high
    # 90 of 100 with a standard deviation of 3.
    assert covered >= 81


def test_groups_are_demonstrators_and_get_what_each_would_get_alone() -> None:
    parts = [drawn(40, confidence=alpha, seed=k) for k, alpha in enumerate((1.5, 6.0))]
    both = Energies(np.concatenate([p.values for p in parts]), np.concatenate([p.actions for p in parts]))
    found = compare_expertise(table(both, np.array([0, 25, 40, 80]), ("novice", "novice", "expert")))
    alone = compare_expertise({"novice": table(parts[0], np.array([0, 25, 40])), "expert": table(parts[1])})
    assert list(found.of) == ["expert", "novice"]
    for name, each in found.of.items():
        assert each.interval == pytest.approx(alone.of[name].interval, rel=1e-6)
        assert each.worth == pytest.approx(alone.of[name].worth)
    assert str(found).startswith("expert  confidence") and "more expert than novice with probability" in str(found)


def test_the_probability_that_one_is_more_expert_is_that_of_independent_draws() -> None:
    of = {
        str(alpha): expertise(table(drawn(40, confidence=alpha, seed=7)), weight=0.5) for alpha in (2.0, 2.5, 3.0, 40.0)
    }
    found = ExpertiseTable(of)
    generator = np.random.default_rng(0)
    draws = {
        name: generator.choice(np.log(each.confidences), p=each.density / each.density.sum(), size=200_000)
        + np.diff(np.log(each.confidences))[0] * (generator.random(200_000) - 0.5)
        for name, each in of.items()
    }  # fmt: skip
    names = list(of)
    for i, one in enumerate(names):
        for j, other in enumerate(names):
            wanted = 0.5 if i == j else np.mean(draws[one] > draws[other])
            assert found.more_expert[i, j] == pytest.approx(wanted, abs=0.01)
    assert found.more("40.0", "2.0") > 0.99 > found.more("2.5", "2.0") > 0.5


def bell(tests: int, alpha: float = 100.0, n: int = 300) -> LogLikelihood:
    """Actions N(goal, 1/α) in −2..2, seen through so many test actions."""
    actions = norm(0.1, alpha**-0.5).rvs(n, random_state=0)
    return table(Bell(actions, np.linspace(-2, 2, tests), np.array([0.1, 1.0])))


def test_fine_test_actions_tell_the_confidence_and_say_nothing_more() -> None:
    found = expertise(bell(161))
    assert found.interval[0] < 100 < found.interval[1] and found.confidence == pytest.approx(100, rel=0.15)
    assert found.warning == "" and not found.open_above and not found.open_below


def test_test_actions_too_far_apart_are_noticed_with_the_way_out() -> None:
    """17 actions are 0.25 apart: half of it is the deviation at α = 64."""
    found = expertise(bell(17))
    assert found.open_above and not found.fine_enough
    assert found.searched[1] == pytest.approx(64, rel=0.25)
    assert "test actions are too far apart" in found.warning and "larger n" in str(found)
    coarse = expertise(bell(17, alpha=9.0))
    assert coarse.warning == "" and coarse.confidence == pytest.approx(9, rel=0.2)
    with pytest.raises(InputError, match="too few to tell any confidence"):
        expertise(table(Bell(np.zeros(9), np.array([0.0, 100.0]), np.array([0.0]))))


def test_one_who_is_always_right_or_never_is_told_by_an_end() -> None:
    made = drawn(30)
    right = expertise(table(Energies(made.values, made.values[:, :, 0].argmax(axis=1))))
    assert right.open_above and not right.open_below and right.warning == "no upper end: the range ends at 1e+04"
    wrong = expertise(table(Energies(made.values[:, :, :1], made.values[:, :, 0].argmin(axis=1))), weight=1.0)
    assert wrong.open_below and not wrong.open_above and "random" in wrong.warning and wrong.warning in str(wrong)


def test_steps_between_test_actions() -> None:
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 5), np.linspace(0, 3, 4)), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(steps_between(grid), [0.25, 1.0])
    scattered = np.random.default_rng(0).random((400, 2))
    np.testing.assert_allclose(steps_between(scattered), [1 / 19, 1 / 19], rtol=0.02)


def test_a_bell_of_half_a_step_is_half_a_step_wide() -> None:
    source = bell(161).source
    told = source.assigned(np.zeros(300, int))
    assert told.steps_wide(1 / 0.0125**2).mean() == pytest.approx(0.5, abs=0.05)
    np.testing.assert_allclose(told.steps_wide(1 / 0.1**2), 4.0, rtol=1e-3)


@pytest.mark.parametrize("wrong", [{"level": 0.0}, {"level": 1.0}, {"level": np.nan}, {"weight": 0.0}, {"weight": -1}])
def test_settings_out_of_range_are_refused(wrong) -> None:
    for ask in (expertise, compare_expertise):
        with pytest.raises(InputError):
            ask(table(drawn(20), groups=("a",)), **wrong)


def test_what_cannot_be_told_of_is_refused() -> None:
    with pytest.raises(InputError, match="OneConfidence"):
        expertise(np.zeros((3, 2)))
    with pytest.raises(InputError, match="background"):
        expertise(table(drawn(20), background=0.1))
    with pytest.raises(InputError, match="groups"):
        compare_expertise(table(drawn(20)))
    with pytest.raises(InputError, match="found none"):
        compare_expertise({})
    with pytest.raises(InputError, match="given numbers"):
        expertise(LogLikelihood.from_table(np.zeros((3, 2))))
    made = drawn(20)
    never = Energies(
        np.where(np.arange(5)[None, :, None] == made.actions[:, None, None], -np.inf, made.values), made.actions
    )
    with pytest.raises(InputError, match="no candidate that allows all observations"):
        expertise(table(never))
