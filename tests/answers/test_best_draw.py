"""The best draw and its gap, against every assignment there is."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import subgoal
from subgoal import samplers
from subgoal.answers import best_draw as module
from subgoal.answers.best_draw import best_draw
from subgoal.models import Gamma, Grouped, OneConfidence, Persistent, StickyHMM
from subgoal.posterior.posterior import Posterior
from tests.answers.test_validation import PLACES, walks
from tests.oracles.finite_mixture import log_joint
from tests.posterior.worlds import corner_likelihood, quiet_sample

N, G, ETA = 6, 3, 0.4
SHORT = {"chains": 2, "draws": 2, "warmup": 0, "thin": 1, "concentration": ETA}


def small(background: float = 0.0, weight: float | None = None) -> subgoal.LogLikelihood:
    likelihood = subgoal.action_comparison(walks([N], seed=3), PLACES).with_background(background)
    return likelihood if weight is None else likelihood.weighted(weight)


def best_of_all(likelihood: subgoal.LogLikelihood) -> float:
    """max over θ of log p(θ, O), one after the other."""
    dense, prior = likelihood.dense, np.exp(likelihood.log_prior)
    every = itertools.product(range(prior.size), repeat=N)
    return max(log_joint(np.array(theta), dense, ETA, prior)[0] for theta in every)


def joint_of(theta: np.ndarray, likelihood: subgoal.LogLikelihood) -> float:
    columns = np.where(theta < 0, likelihood.n_candidates - 1, theta)
    return log_joint(columns, likelihood.dense, ETA, np.exp(likelihood.log_prior))[0]


@pytest.mark.parametrize("weight", [None, 0.4])
@pytest.mark.parametrize("background", [0.0, 0.3])
@pytest.mark.parametrize("seed", range(3))
def test_no_assignment_is_better_than_the_gap_says(background: float, weight: float | None, seed: int) -> None:
    likelihood = small(background, weight)
    posterior = quiet_sample(likelihood, **SHORT, seed=seed)
    found, best = best_draw(posterior), best_of_all(likelihood)
    assert found.log_joint == pytest.approx(joint_of(found.assignment, likelihood), abs=1e-10)
    assert found.log_joint == posterior.log_joint.max()
    assert found.upper_bound >= best - 1e-10
    assert found.gap == pytest.approx(found.upper_bound - found.log_joint)
    assert found.gap >= best - found.log_joint - 1e-10
    assert found.improved_log_joint == pytest.approx(joint_of(found.improved, likelihood), abs=1e-10)
    assert found.log_joint - 1e-10 <= found.improved_log_joint <= best + 1e-10
    assert found.improved_gap == pytest.approx(found.upper_bound - found.improved_log_joint, abs=1e-10)
    assert found.why_no_gap == ""


def test_the_gap_is_none_too_wide() -> None:
    """With one candidate far better for every observation, the bound is that of the best assignment."""
    dense = np.full((N, G), -20.0)
    dense[:, 1] = 0.0
    posterior = quiet_sample(subgoal.LogLikelihood.from_table(dense), **{**SHORT, "draws": 20})
    found = best_draw(posterior)
    assert found.assignment.tolist() == [1] * N
    assert found.gap == pytest.approx(0, abs=1e-8)
    assert repr(found) == f"BestDraw(log joint {found.log_joint:.6g}, at most {found.gap:.3g} nats below the best)"


def test_search_mends_a_bad_draw() -> None:
    posterior = quiet_sample(small(), **SHORT)
    bad = np.array([0, 1, 2, 0, 1, 2], np.int32)
    spoilt = replace(posterior, best_assignment=bad, log_joint=np.full((2, 2), joint_of(bad, small())))
    found = best_draw(spoilt)
    np.testing.assert_array_equal(found.assignment, bad)
    assert found.improved_log_joint > found.log_joint + 0.5
    assert found.improved_gap < found.gap - 0.5


def test_the_background_is_minus_one_before_and_after_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Actions that no candidate explains at a confidence of forty: the best assignment of all serves none."""
    demos = walks([N], seed=3)
    actions = np.column_stack([-demos.actions[:, 1], demos.actions[:, 0]])
    likelihood = subgoal.action_comparison(replace(demos, actions=actions), PLACES, confidence=40.0)
    likelihood = likelihood.with_background(0.9)
    posterior = quiet_sample(likelihood, **SHORT)
    begun: list[np.ndarray] = []
    search = module.map_partition
    monkeypatch.setattr(module, "map_partition", lambda *a, **b: begun.append(b["start"]) or search(*a, **b))
    for start in (np.full(N, -1, np.int32), np.array([-1, 0, -1, -1, -1, -1], np.int32)):
        value = joint_of(start, likelihood)
        found = best_draw(replace(posterior, best_assignment=start, log_joint=np.full((2, 2), value)))
        np.testing.assert_array_equal(found.assignment, start)
        np.testing.assert_array_equal(begun[-1], np.where(start < 0, G, start))
        assert found.improved.tolist() == [-1] * N
        assert found.improved_log_joint == pytest.approx(best_of_all(likelihood), abs=1e-10)
        assert found.gap >= found.improved_log_joint - value - 1e-10


@pytest.mark.parametrize("name", list(samplers.__all__))
def test_the_log_joint_is_the_same_quantity_whatever_the_sampler(name: str) -> None:
    posterior = quiet_sample(small(), **(SHORT | {"warmup": 80}), sampler=getattr(samplers, name))
    found = best_draw(posterior)
    assert found.log_joint == pytest.approx(joint_of(found.assignment, small()), abs=1e-10)
    assert found.gap >= best_of_all(small()) - found.log_joint - 1e-10


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"model": Persistent()}, "Persistent"),
        ({"model": StickyHMM()}, "StickyHMM"),
        ({"model": Grouped([0])}, "Grouped"),
        ({"concentration": Gamma()}, "concentration"),
        ({"confidence": OneConfidence()}, "confidence"),
    ],
)
def test_where_no_bound_is_known_there_is_no_gap(settings: dict, reason: str) -> None:
    posterior = quiet_sample(corner_likelihood(), **{**SHORT, **settings})
    assert_unknown(posterior, reason)


def test_without_the_likelihood_there_is_no_gap() -> None:
    assert_unknown(replace(quiet_sample(small(), **SHORT), likelihood=None), "likelihood")


def assert_unknown(posterior: Posterior, reason: str) -> None:
    found = best_draw(posterior)
    assert (found.gap, found.upper_bound, found.improved, found.improved_gap) == (None,) * 4
    assert reason in found.why_no_gap
    assert found.log_joint == posterior.log_joint.max()
    np.testing.assert_array_equal(found.assignment, posterior.best_assignment)
    assert "gap unknown" in repr(found)
    assert math.isfinite(found.log_joint)
