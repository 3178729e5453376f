"""Small posteriors that the tests of this room and its neighbours share."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

import subgoal
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.posterior import Posterior


def quiet_sample(likelihood: LogLikelihood, **settings: Any) -> Posterior:
    """``sample`` on one worker, its verdict on convergence left to the posterior's status."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return subgoal.sample(likelihood, **{"workers": 1, **settings})


def table(n: int = 30, g_count: int = 6, seed: int = 0, scale: float = 2.0) -> LogLikelihood:
    """A table of normal numbers with an uneven prior."""
    generator = np.random.default_rng(seed)
    candidates = Candidates(generator.normal(size=(g_count, 2)), generator.normal(size=g_count))
    return LogLikelihood.from_table(generator.normal(scale=scale, size=(n, g_count)), candidates=candidates)


def two_corners(n: int = 80, noise: float = 0.25, seed: int = 3) -> Demonstrations:
    """One path from (0, 0) over (10, 0) to (10, 10), directions blurred by ``noise`` radians."""
    generator = np.random.default_rng(seed)
    along = np.linspace(0, 20, n, endpoint=False)
    states = np.column_stack([np.minimum(along, 10.0), np.maximum(along - 10.0, 0.0)])
    angle = np.where(along < 10, 0.0, np.pi / 2) + generator.normal(scale=noise, size=n)
    actions = np.column_stack([np.cos(angle), np.sin(angle)])
    final = np.array([[10.0, 10.0]])
    return Demonstrations.from_arrays(states, actions, [0, n], times=along, final_states=final, units="m")


def corner_likelihood(radius: float = 1.0, confidence: float = 4.0) -> LogLikelihood:
    """Directions of ``two_corners`` against a net of its places."""
    demos = two_corners()
    return subgoal.action_comparison(demos, subgoal.epsilon_net(demos, radius), confidence=confidence)


def assert_same_posterior(one: Posterior, two: Posterior) -> None:
    """Raise if anything that was drawn or derived differs."""
    for name in ("best_assignment", "log_joint", "log_likelihood", "uninformative"):
        np.testing.assert_array_equal(getattr(one, name), getattr(two, name))
    assert (one.assignments is None) == (two.assignments is None)
    if one.assignments is not None:
        np.testing.assert_array_equal(one.assignments, two.assignments)
    for name in ("offset", "candidate", "count"):
        np.testing.assert_array_equal(getattr(one.counts, name), getattr(two.counts, name))
    assert (one.shares != two.shares).nnz == 0
    assert one.traces.keys() == two.traces.keys()
    for name, trace in one.traces.items():
        np.testing.assert_array_equal(trace, two.traces[name])
    assert (one.settings, one.status) == (two.settings, two.status)
    assert repr(one.diagnostics) == repr(two.diagnostics)
