"""PolicyWalk against enumeration on four states, and against a walk that solves every world anew."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
import pytest

from subgoal._kernels import policy_walk as loops
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.reward_walk import READINGS, RewardChain, RewardLaw
from subgoal.irl.single_reward import shown
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.errors import InputError
from tests.exact.replay import matrix, outcomes, python_form
from tests.oracles import rewards as oracle

DISCOUNT, CONFIDENCE, STEP = 0.8, 1.7, 0.5
STATES, ACTIONS = np.array([0, 1, 1, 3, 2]), np.array([1, 0, 2, 2, 0])
LEVELS, LOG_PRIOR = (-STEP, 0.0, STEP), np.log([0.2, 0.5, 0.3])
POINTS = (-1, 0, 1)


@dataclass
class Levels:
    """Three levels and nothing else."""

    start = 0.0

    def log_density(self, values: np.ndarray) -> np.ndarray:
        found = np.full(np.shape(values), -np.inf)
        for level, height in zip(LEVELS, LOG_PRIOR, strict=True):
            found[np.isclose(values, level)] = height
        return found


def dense_world(states: int = 4, actions: int = 3, seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).dirichlet(np.full(states, 0.6), size=(states, actions))


TRANSITION = dense_world()
WORLD = TabularMDP.from_dense(TRANSITION, DISCOUNT)
FEATURES = np.random.default_rng(1).normal(size=(4, 3))
VARIANTS = {
    "every state": (np.eye(4), np.ones(4)),
    "relevance": (np.eye(4), np.array([0.1, 2.0, 0.7, 1.0])),
    "features": (FEATURES, np.array([1.0, 0.3, 1.0])),
}


def law_of(features, relevance, reading: str = "product", prior=None, mdp=WORLD) -> RewardLaw:
    demos = Demonstrations.from_arrays(STATES, ACTIONS)
    prior = Levels() if prior is None else prior
    return RewardLaw(mdp, shown(demos, mdp), features, prior, CONFIDENCE, STEP, reading, relevance)


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("variant", VARIANTS)
def test_a_step_is_reversible(variant: str, reading: str, monkeypatch) -> None:
    """Also where the policy is made the base at every step."""
    monkeypatch.setattr(loops, "LARGEST_RANK", 0)
    features, relevance = VARIANTS[variant]
    law = law_of(features, relevance, reading)
    args = (TRANSITION, DISCOUNT, STATES, ACTIONS, CONFIDENCE, reading, features, LEVELS, LOG_PRIOR)
    exact = oracle.posterior(*args)
    states, pi = list(exact), np.array(list(exact.values()))

    def move(state):
        chain = RewardChain(law, None, np.array([POINTS[k] for k in state]))
        arrays = np.empty((1, features.shape[1]), np.int64), np.empty((1, 4)), np.empty(1), np.empty(1)
        loops.steps(
            law.world, law.counts, law.reaching(3), chain.walk, chain.base, law.linear, np.ones(1), np.ones(1, bool),
            *arrays, np.zeros(1, bool), None,
        )  # fmt: skip
        return tuple(POINTS.index(k) for k in arrays[0][0])

    step = matrix(states, lambda state: outcomes(loops, lambda: move(state)))
    flow = pi[:, None] * step
    assert np.abs(step.sum(axis=1) - 1).max() <= 1e-12
    assert np.abs(flow - flow.T).max() <= 1e-13
    assert (step > 0).sum() > 3 * len(states)


def test_proposals_are_symmetric() -> None:
    """With a likelihood of one and a flat prior every move goes both ways equally often, whatever the relevance."""
    law = law_of(np.eye(4), np.array([0.1, 2.0, 0.7, 1.0]))
    flat = RewardLaw(law.mdp, law.pairs, law.features, law.prior, 0.0, STEP, "product", law.relevance)
    states = list(itertools.product(range(3), repeat=4))
    at = flat.reaching(3)
    at = at._replace(log_prior=np.where(at.log_prior > -np.inf, 0.0, -np.inf))

    def move(state):
        chain = RewardChain(flat, None, np.array([POINTS[k] for k in state]))
        points = np.empty((1, 4), np.int64)
        loops.steps(
            flat.world, flat.counts, at, chain.walk, chain.base, False, np.ones(1), np.ones(1, bool), points,
            np.empty((1, 4)), np.empty(1), np.empty(1), np.zeros(1, bool), None,
        )  # fmt: skip
        return tuple(POINTS.index(k) for k in points[0])

    step = matrix(states, lambda state: outcomes(loops, lambda: move(state)))
    assert np.abs(step - step.T).max() <= 1e-15


def test_a_constant_relevance_is_policy_walk_draw_for_draw() -> None:
    chains = [RewardChain(law_of(np.eye(4), np.full(4, size)), np.random.default_rng(5)) for size in (1.0, 0.25)]
    first, second = (chain.advance(np.ones(300), np.ones(300, bool)) for chain in chains)
    np.testing.assert_array_equal(first.points, second.points)
    np.testing.assert_array_equal(first.log_joint, second.log_joint)


def test_how_steps_are_cut_does_not_change_them() -> None:
    whole, cut = (RewardChain(law_of(FEATURES, np.ones(3)), np.random.default_rng(6)) for _ in range(2))
    all_at_once = whole.advance(np.ones(90), np.ones(90, bool))
    pieces = [cut.advance(np.ones(n), np.ones(n, bool)) for n in (1, 40, 49)]
    np.testing.assert_array_equal(all_at_once.points, np.concatenate([each.points for each in pieces]))
    np.testing.assert_array_equal(all_at_once.log_joint, np.concatenate([each.log_joint for each in pieces]))


class Wide:
    """Normal, of deviation 3."""

    start = 0.0

    def log_density(self, values):
        return -0.5 * (np.asarray(values) / 3.0) ** 2


@pytest.mark.parametrize("count", [400, pytest.param(10_000, marks=pytest.mark.t2)])
def test_the_same_steps_are_accepted_as_where_every_world_is_solved_anew(count: int, monkeypatch) -> None:
    """Forty states; values within 1e-9 all along, with many changes of base and the inverse computed anew."""
    monkeypatch.setattr(loops, "LARGEST_RANK", 24)
    transition = dense_world(40, 4, seed=8)
    mdp = TabularMDP.from_dense(transition, 0.93)
    generator = np.random.default_rng(2)
    states, actions = generator.integers(40, size=120), generator.integers(2, size=120)
    demos = Demonstrations.from_arrays(states, actions)
    relevance = generator.uniform(0.1, 1.0, size=40)
    law = RewardLaw(mdp, shown(demos, mdp), np.eye(40), Wide(), CONFIDENCE, STEP, "product", relevance)
    made = RewardChain(law, np.random.default_rng(9)).advance(np.ones(count), np.ones(count, bool))
    accepted, values = oracle.policy_walk(
        transition, 0.93, states, actions, CONFIDENCE, STEP, relevance, Wide().log_density, count,
        np.random.default_rng(9),
    )  # fmt: skip
    np.testing.assert_array_equal(made.accepted, accepted)
    assert np.abs(made.values - values).max() <= 1e-9
    assert 0.2 < accepted.mean() < 0.95


def test_changes_of_base_and_fresh_inverses_change_no_value(monkeypatch) -> None:
    """The Python form with a change of base at every switch, every third of them from the inverse itself."""
    monkeypatch.setattr(loops, "LARGEST_RANK", 0)
    monkeypatch.setattr(loops, "FRESH_EVERY", 3)
    for features in (np.eye(4), FEATURES):
        law = law_of(features, np.ones(features.shape[1]), prior=Wide())
        chain = RewardChain(law, np.random.default_rng(4))
        with python_form(loops):
            made = chain.advance(np.ones(150), np.ones(150, bool))
        for points, value in zip(made.points, made.values, strict=True):
            exact = oracle.optimal_values(TRANSITION, features @ (STEP * points), DISCOUNT)
            assert np.abs(exact - value).max() <= 1e-12
        assert len({tuple(each) for each in made.points}) > 30
        fit = oracle.log_likelihood(
            TRANSITION, features @ (STEP * made.points[-1]), DISCOUNT, STATES, ACTIONS, CONFIDENCE, "product"
        )
        assert abs(made.log_likelihood[-1] - fit) <= 1e-12
        prior = Wide().log_density(STEP * made.points[-1]).sum()
        assert abs(made.log_joint[-1] - fit - prior) <= 1e-10


def test_bad_laws_are_refused() -> None:
    with pytest.raises(InputError, match="relevance"):
        law_of(np.eye(4), np.array([0.0, 0, 0, 0]))
    with pytest.raises(InputError, match="relevance"):
        law_of(np.eye(4), np.array([1.0, 1, 1, -1]))
    with pytest.raises(InputError, match="likelihood"):
        law_of(np.eye(4), np.ones(4), reading="sum")
    with pytest.raises(InputError, match="relevance"):
        law_of(np.eye(4), np.array([1.0, 1, 1, np.nan]))
