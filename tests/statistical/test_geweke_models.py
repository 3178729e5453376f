"""Geweke's joint test for sticky transitions and for groups: state from the prior, then rounds of data and sweep."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from subgoal.partition.groups import Grouped
from subgoal.partition.priors import Beta, Gamma
from subgoal.partition.protocol import Chain, Sampler
from subgoal.partition.sticky_hmm import StickyHMM
from tests.exact.shared_tables import with_trajectories, worst_gap
from tests.oracles.hdp import group_rows, seat, walk_rows
from tests.statistical.toy import peaked

ETA = 1.5


def joint_gap(
    model: Sampler, toy: Any, starts: tuple[int, ...], prior: Callable[..., dict], summaries: Callable[..., tuple],
    replicas: int,
) -> float:  # fmt: skip
    """Standard errors between summaries of the prior's joint law and those after three rounds."""
    generator, keep = np.random.default_rng(2), np.ones(1, bool)
    wanted, got = [], []
    for _ in range(4 * replicas):
        state = prior(generator)
        wanted.append(summaries(state, toy.outcomes(state["theta"], generator)))
    for _ in range(replicas):
        state = prior(generator)
        for _ in range(3):
            seen = toy.outcomes(state["theta"], generator)
            table = with_trajectories(toy.table(seen).dense, starts, toy.prior)
            state = dict(model(Chain(table, ETA, generator, state), keep).state)
        got.append(summaries(state, seen))
    return worst_gap(np.array(got, float), np.array(wanted, float))


HMM_TOY = peaked(4, 3, 6, ETA)
HMM_STARTS = (0, 4)
HMM_LEARNED = StickyHMM(Gamma(2.0, 0.7), Beta(2.0, 2.0))


def hmm_prior(generator: np.random.Generator) -> dict[str, np.ndarray]:
    """A state drawn from the prior."""
    mass, share = generator.gamma(2.0) / 0.7, generator.beta(2.0, 2.0)
    weights = generator.dirichlet(ETA * HMM_TOY.prior)
    free, sticky = mass * (1 - share), mass * share
    theta: list[int] = []
    for i in range(HMM_TOY.n):
        rows = walk_rows(theta, HMM_STARTS)
        row = "first" if i in HMM_STARTS else theta[-1]
        before = [g for r, g in zip(rows, theta, strict=True) if r == row]
        law = np.array([before.count(g) + free * weights[g] + (sticky if row == g else 0) for g in range(4)])
        theta.append(int(generator.choice(4, p=law / law.sum())))
    shared = seat(walk_rows(theta, HMM_STARTS), theta, free, sticky, weights, generator)
    return {"theta": np.array(theta, np.int32), "counts": shared, "row_mass": np.array([mass, share])}


def hmm_summaries(state, outcomes_: np.ndarray) -> tuple[float, ...]:
    theta, (mass, share), shared = state["theta"], state["row_mass"], state["counts"]
    likelihood = float(np.log(HMM_TOY.emission[theta, outcomes_]).sum())
    equal = (theta[1:] == theta[:-1]).sum()
    return likelihood, np.unique(theta).size, (theta == 0).sum(), equal, np.log(mass), share, shared.sum(), shared[0]


@pytest.mark.parametrize("replicas", [1500, pytest.param(12_000, marks=pytest.mark.t2)])
def test_a_sweep_of_sticky_transitions_leaves_the_joint_law(replicas: int) -> None:
    """Geweke: state from the prior, three rounds of data and sweep. Level 3e-6 over 16 statistics: 5.3 errors."""
    assert joint_gap(HMM_LEARNED, HMM_TOY, HMM_STARTS, hmm_prior, hmm_summaries, replicas) <= 5.3


GROUPS_TOY = peaked(4, 3, 6, ETA)
GROUPS_STARTS, GROUPS_GROUPS, GROUPS_OWN = (0, 2, 4), (0, 1, 0), (0, 0, 1, 1, 0, 0)
GROUPS_LEARNED = Grouped(GROUPS_GROUPS, Gamma(2.0, 0.7))


def groups_prior(generator: np.random.Generator) -> dict[str, np.ndarray]:
    """A state drawn from the prior."""
    mass, weights = generator.gamma(2.0) / 0.7, generator.dirichlet(ETA * GROUPS_TOY.prior)
    theta: list[int] = []
    for i in range(GROUPS_TOY.n):
        before = [theta[k] for k in range(i) if GROUPS_OWN[k] == GROUPS_OWN[i]]
        law = np.array([before.count(g) + mass * weights[g] for g in range(4)])
        theta.append(int(generator.choice(4, p=law / law.sum())))
    shared = seat(group_rows(GROUPS_OWN), theta, mass, 0.0, weights, generator)
    return {"theta": np.array(theta, np.int32), "counts": shared, "group_mass": np.array([mass])}


def groups_summaries(state, seen: np.ndarray) -> tuple[float, ...]:
    theta, shared = state["theta"], state["counts"]
    likelihood = float(np.log(GROUPS_TOY.emission[theta, seen]).sum())
    within, across = theta[0] == theta[5], theta[0] == theta[2]
    first = (theta == 0).sum()
    return likelihood, np.unique(theta).size, first, within, across, np.log(state["group_mass"][0]), shared.sum()


@pytest.mark.parametrize("replicas", [700, pytest.param(12_000, marks=pytest.mark.t2)])
def test_a_sweep_over_groups_leaves_the_joint_law(replicas: int) -> None:
    """Geweke: state from the prior, three rounds of data and sweep. Level 3e-6 over 14 statistics: 5.3 errors."""
    assert joint_gap(GROUPS_LEARNED, GROUPS_TOY, GROUPS_STARTS, groups_prior, groups_summaries, replicas) <= 5.3
