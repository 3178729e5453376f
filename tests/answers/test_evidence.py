"""What a recording is worth: the autocorrelation time of errors that are known, and learning under it."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import subgoal
from subgoal.answers.evidence import evidence, scores
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.learn import learn
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.models import Gamma, NoiseLevels, OwnConfidence, Persistent
from subgoal.runtime.errors import InputError
from tests.posterior.worlds import quiet_sample, table

CORNERS = np.array([[0.0, 0.0], [60.0, 0.0], [30.0, 52.0]])
STEP = 1.0
SHORT = {"chains": 2, "draws": 20, "warmup": 20, "thin": 1, "seed": 1}


def turned(n: int, r: float, spread: float, generator: np.random.Generator) -> np.ndarray:
    """(n,) stationary AR(1) angles."""
    angle = np.empty(n)
    angle[0] = spread * generator.normal()
    for t in range(1, n):
        angle[t] = r * angle[t - 1] + spread * math.sqrt(1 - r * r) * generator.normal()
    return angle


def flipped(n: int, r: float, spread: float, generator: np.random.Generator) -> np.ndarray:
    """(n,) independent sizes with a Markov chain of signs: signs k apart have correlation r^k."""
    change = np.where(generator.random(n) < (1 - r) / 2, -1, 1)
    change[0] = generator.choice([-1, 1])
    return np.cumprod(change) * np.abs(spread * generator.normal(size=n))


def walkers(errors: list[np.ndarray]) -> Demonstrations:
    """From corner to corner, turned from the straight way to the next one by the errors given."""
    states, actions, offset = [], [], [0]
    for k, turn in enumerate(errors):
        at, goal = CORNERS[k % 3] + 0.5, (k + 1) % 3
        for angle in turn:
            if np.linalg.norm(CORNERS[goal] - at) < 3 * STEP:
                goal = (goal + 1) % 3
            way = CORNERS[goal] - at
            heading = math.atan2(way[1], way[0]) + angle
            step = STEP * np.array([math.cos(heading), math.sin(heading)])
            states.append(at)
            actions.append(step)
            at = at + step
        offset.append(len(states))
    return Demonstrations.from_arrays(np.array(states), np.array(actions), offset)


def time_of_signs(r: float) -> float:
    """Of the signs of a Gaussian AR(1) process, whose correlation is (2/π)·arcsin r^k."""
    return 1 + 2 * float((2 / math.pi * np.arcsin(r ** np.arange(1, 400))).sum())


def known(errors: list[np.ndarray], confidence: float = 6.0) -> LogLikelihood:
    """Directions against the three corners."""
    return subgoal.action_comparison(walkers(errors), Candidates(CORNERS, radius=1.0), confidence=confidence)


@pytest.mark.parametrize("r", [0.0, 0.5, 0.8])
@pytest.mark.parametrize("form", [flipped, turned])
def test_the_time_is_that_of_the_errors(r: float, form) -> None:
    """4,000 observations, known goals: within 25 %. The score of a direction is all but the sign of its error.

    Signs that are a Markov chain have τ = (1 + r)/(1 − r); the signs of Gaussian errors with that τ have a shorter one.
    """
    generator = np.random.default_rng(10)
    errors = [form(1000, r, 0.25, generator) for _ in range(4)]
    found = evidence(quiet_sample(known(errors), model=Persistent(), **SHORT))
    wanted = (1 + r) / (1 - r) if form is flipped else time_of_signs(r)
    assert abs(found.time / wanted - 1) <= 0.25
    assert found.weight == pytest.approx(min(1.0, 1 / found.time))
    assert found.correlation[0] == 1
    assert found.time == pytest.approx(2 * found.correlation.sum() - 1)
    if r:
        lag_one = r if form is flipped else 2 / math.pi * math.asin(r)
        assert abs(found.correlation[1] - lag_one) <= 0.08


def test_chance_takes_no_evidence_from_short_recordings() -> None:
    """Of 40 recordings of 40 independent errors, at least 31 keep all their weight.

    If one in thirty is taken for correlated, ten or more of 40 have probability 1.3e-6. Without the rule, half are.
    """
    generator = np.random.default_rng(12)
    weights = [
        evidence(quiet_sample(known([0.3 * generator.normal(size=40)]), model=Persistent(), **SHORT)).weight
        for _ in range(40)
    ]
    assert sum(weight == 1.0 for weight in weights) >= 31


def test_errors_that_alternate_count_as_independent() -> None:
    """τ is below one and not asked for: the weight is at most 1."""
    found = evidence(quiet_sample(known([flipped(1000, -0.7, 0.25, np.random.default_rng(2))]), **SHORT))
    assert (found.time, found.weight, found.correlation.tolist()) == (1.0, 1.0, [1.0])


def test_trajectories_are_apart() -> None:
    """Of trajectories of two steps with equal errors only lag one has pairs: τ = 3 at most.

    Less, since some are taken to go to another corner.
    """
    generator = np.random.default_rng(4)
    likelihood = known([np.repeat(0.3 * generator.choice([-1, 1]), 2) for _ in range(300)])
    found = evidence(quiet_sample(likelihood, **SHORT))
    assert found.correlation.size == 3
    assert found.correlation[2] == 0
    assert 0.8 <= found.correlation[1] <= 1.0
    demos = likelihood.demonstrations
    single = replace(likelihood, demonstrations=Demonstrations.from_arrays(demos.states, demos.actions, np.arange(601)))
    assert evidence(quiet_sample(single, **SHORT)).time == 1.0


@pytest.mark.parametrize("r", [0.8])
def test_levels_and_backgrounds_have_scores_too(r: float) -> None:
    """A law of the confidence: the score is that of the mixture; background has none; so has what is at its goal."""
    generator = np.random.default_rng(3)
    plain = known([flipped(1000, r, 0.25, generator) for _ in range(2)])
    theta = generator.integers(-1, 3, plain.n_observations)
    levels = np.array([1.0, 8.0])
    mixed = plain.at(Levels(levels, np.array([0.3, 0.7])))
    score, spoken = scores(mixed, theta)
    told = plain.source.assigned(np.maximum(theta, 0))
    density = np.array([0.3, 0.7])[:, None] * np.exp([told.log_density(a) for a in levels])
    wanted = sum(
        (d / density.sum(axis=0))[:, None] * told.score(float(a)) for d, a in zip(density, levels, strict=True)
    )
    np.testing.assert_allclose(score[theta >= 0], wanted[theta >= 0], rtol=1e-10, atol=1e-12)
    assert not score[theta < 0].any()
    assert not spoken[theta < 0].any()
    own = plain.at(np.array([1.0, 4.0, 9.0]))
    each, _ = scores(own, theta)
    alone, _ = scores(plain.at(9.0), theta)
    np.testing.assert_array_equal(each[theta == 2], alone[theta == 2])
    assert abs(each[theta == 0]).max() <= 1.0


def test_times_do_not_hang_on_the_confidence_or_the_model_of_noise() -> None:
    """Signs are signs: at α from 2 to 20, and with everything learned, τ = 4 within 25 %, alike within 15 %."""
    generator = np.random.default_rng(6)
    likelihood = known([flipped(800, 0.6, 0.3, generator) for _ in range(3)])
    learned = {"concentration": Gamma(), "model": Persistent()}
    found = [
        evidence(quiet_sample(likelihood.at(alpha), model=Persistent(), **SHORT)).time for alpha in (2.0, 6.0, 20.0)
    ]
    for noise in (NoiseLevels(), OwnConfidence()):
        wide = likelihood.with_background(0.02)
        found.append(evidence(quiet_sample(wide, confidence=noise, **learned, **SHORT)).time)
    assert abs(np.array(found) / 4.0 - 1).max() <= 0.25
    assert max(found) / min(found) <= 1.15


def test_what_has_no_scores_is_refused() -> None:
    with pytest.raises(InputError, match="table of given numbers"):
        evidence(quiet_sample(table(), **SHORT))
    with pytest.raises(InputError, match="plain table"):
        learn(table())
    posterior = quiet_sample(known([np.full(20, 0.1)]), **SHORT)
    for lacking in ({"assignments": None}, {"likelihood": None}):
        with pytest.raises(InputError, match="posterior"):
            evidence(replace(posterior, **lacking))
    with pytest.raises(InputError, match="draws"):
        evidence(posterior, draws=0)


def quiet_learn(likelihood: LogLikelihood, **settings):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return learn(likelihood, workers=1, draws=60, warmup=150, thin=2, chains=2, **settings)


@pytest.mark.t2
def test_learn_finds_three_corners_and_what_the_recording_is_worth() -> None:
    """1,200 observations with errors of τ = 4 against a net: three subgoals at the corners, a weight near 1/4."""
    generator = np.random.default_rng(8)
    demos = walkers([flipped(400, 0.6, 0.25, generator) for _ in range(3)])
    posterior = quiet_learn(subgoal.action_comparison(demos, subgoal.epsilon_net(demos, 4.0)), seed=5)
    weight = posterior.likelihood.weight
    assert (weight == weight[0]).all()
    assert 0.7 / 4 <= weight[0] <= 1.4 / 4
    large = np.argsort(posterior.expected_shares)[::-1]
    places = posterior.candidates.points
    near = np.linalg.norm(places[:, None] - CORNERS[None], axis=2)
    share = [posterior.expected_shares[near[:, k] <= 8.0].sum() for k in range(3)]
    assert min(share) >= 0.2
    assert sum(share) >= 0.9
    assert {int(near[g].argmin()) for g in large[:3]} == {0, 1, 2}
    found = subgoal.subgoals(posterior)
    assert found is not None
    assert posterior.parameters.keys() == {"concentration", "persistence", "noise levels"}


def test_weights_that_are_given_stay() -> None:
    generator = np.random.default_rng(8)
    likelihood = known([flipped(150, 0.6, 0.25, generator)]).weighted(0.37)
    posterior = quiet_learn(likelihood, seed=5)
    assert (posterior.likelihood.weight == 0.37).all()
    fixed = quiet_learn(likelihood, seed=5, model=None, concentration=2.0, confidence=None)
    assert fixed.parameters == {}
    assert fixed.settings.concentration == 2.0
