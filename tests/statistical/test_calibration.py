"""Simulation-based calibration: truth drawn from the prior is, among the posterior's draws, like one of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom, chi2

import subgoal
from subgoal import samplers
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.partition.protocol import Chain
from tests.oracles.finite_mixture import draw_assignment
from tests.posterior.worlds import quiet_sample
from tests.statistical.toy import NAMES, peaked

LEVEL = 3e-6
DRAWS = 127
BINS = 16
TOY = peaked(5, 4, 20, 1.0)
SHIPPED = [samplers.collapsed_blocks, samplers.alg4_corrected]
MORE = [samplers.blocked, samplers.collapsed, samplers.cluster_collapsed, samplers.split_merge, samplers.tempered]


def ranks(sampler, simulations: int, seed: int, *, thin: int = 8, shown=None) -> np.ndarray:
    """(simulations, statistics) rank of the truth among 127 draws, ties broken at random, 0 to 127."""
    rows = []
    for k in range(simulations):
        generator = np.random.default_rng([seed, k])
        theta = TOY.theta(generator)
        outcomes = TOY.outcomes(theta, generator)
        table = TOY.table(outcomes) if shown is None else shown(TOY.table(outcomes))
        keep = np.tile(np.arange(thin) == thin - 1, DRAWS + 8)
        stretch = sampler(Chain(table, TOY.eta, generator), keep)
        drawn = np.array([TOY.summaries(draw, outcomes) for draw in stretch.assignments[8:]])
        truth = np.array(TOY.summaries(theta, outcomes))
        # Equal up to rounding is a tie: the same assignment in another order of addition.
        tied = np.abs(drawn - truth) <= 1e-9
        below = ((drawn < truth) & ~tied).sum(axis=0)
        rows.append(below + generator.integers(0, tied.sum(axis=0) + 1))
    return np.array(rows)


def p_values(rank: np.ndarray) -> dict[str, float]:
    """Chi-square of the ranks over 16 equal bins, per statistic."""
    expected = len(rank) / BINS
    found = {}
    for k, name in enumerate(NAMES):
        observed = np.bincount(rank[:, k] * BINS // (DRAWS + 1), minlength=BINS)
        found[name] = float(chi2.sf(((observed - expected) ** 2 / expected).sum(), BINS - 1))
    return found


@pytest.mark.t2
@pytest.mark.parametrize("sampler", [*SHIPPED, *MORE], ids=lambda s: s.__name__)
def test_ranks_are_uniform(sampler) -> None:
    """1,000 simulations of 127 draws, level 3e-6 over five statistics; notices L to the power 0.8 (below)."""
    found = p_values(ranks(sampler, 1000, 1))
    assert set(found) >= {"log joint", "log likelihood", "K"}
    assert min(found.values()) >= LEVEL / len(NAMES), found


@pytest.mark.t2
@pytest.mark.parametrize(
    ("sampler", "name", "planted"),
    [(SHIPPED[0], "tempered", lambda t: replace(t, dense=0.8 * t.dense)),
     (SHIPPED[1], "prior", lambda t: replace(t, log_prior=np.full(t.n_candidates, -np.log(t.n_candidates))))],
    ids=["tempered", "prior-forgotten"],
)  # fmt: skip
def test_planted_errors_spoil_the_ranks(sampler, name: str, planted) -> None:
    found = p_values(ranks(sampler, 1000, 1, shown=planted))
    assert min(found.values()) < LEVEL / len(NAMES), (name, found)


PLACES = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0], [10.0, 10.0], [5.0, 5.0]])
PLACE_PRIOR = np.array([0.3, 0.25, 0.2, 0.15, 0.1])
ALPHA, ETA, COUNT = 3.0, 1.5, 60


def directions(ways: np.ndarray, alpha: float, generator: np.random.Generator) -> np.ndarray:
    """Unit vectors from density ∝ exp(−α‖u − û‖) around each way, by the inverse of a fine cumulative sum."""
    angle = (np.arange(100_000) + 0.5) * 2 * np.pi / 100_000 - np.pi
    mass = np.cumsum(np.exp(-2 * alpha * np.abs(np.sin(angle / 2))))
    turned = np.interp(generator.random(len(ways)) * mass[-1], mass, angle) + np.arctan2(ways[:, 1], ways[:, 0])
    return np.column_stack([np.cos(turned), np.sin(turned)])


def covered(simulations: int, confidence: float) -> tuple[int, int, float]:
    """Places whose true share lies in the 90 % interval, how many there were, and the mean width of the intervals."""
    inside, count, width = 0, 0, 0.0
    for k in range(simulations):
        generator = np.random.default_rng([17, k])
        theta = draw_assignment(COUNT, ETA, PLACE_PRIOR, generator)
        states = generator.uniform(-3, 13, (COUNT, 2))
        demos = Demonstrations.from_arrays(states, directions(PLACES[theta] - states, ALPHA, generator))
        likelihood = subgoal.action_comparison(
            demos, Candidates.from_points(PLACES, log_prior=np.log(PLACE_PRIOR)), confidence=confidence
        )
        posterior = quiet_sample(likelihood, concentration=ETA, chains=4, draws=100, warmup=50, thin=5, seed=k)
        found = subgoal.subgoals(posterior)
        truth = np.bincount(theta, minlength=len(PLACES)) / COUNT
        for item in found.items:
            low, high = item.share_interval
            inside += low - 1e-12 <= truth[item.candidate] <= high + 1e-12
            count, width = count + 1, width + high - low
    return inside, count, width / count


@pytest.mark.t2
def test_truth_lies_in_the_intervals() -> None:
    """90 % intervals of shares cover the truth: at least so often that chance alone would fall below at 3e-6.

    Places of one simulation are dependent, so each simulation counts as one of its places: the bound is that of 150
    trials, 0.77. Intervals of whole counts cover a little more than 90 %. Notices a confidence 3 times too high.
    """
    bound = binom.ppf(LEVEL, 150, 0.9) / 150
    inside, count, width = covered(150, ALPHA)
    assert inside / count >= bound
    assert width < 0.3
    wrong, places, _ = covered(50, 3 * ALPHA)
    assert wrong / places < bound
