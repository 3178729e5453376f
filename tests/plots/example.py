"""A small posterior in any number of dimensions, with names that try to be markup."""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import lru_cache

import numpy as np

from subgoal.answers.segments import Segments, segments
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import sample

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)>"


@lru_cache
def example(
    dimension: int = 2, *, n: int = 120, trajectories: int = 6, converged: bool = True, named: bool = False
) -> tuple[Posterior, Subgoals, Segments]:
    """Posterior, subgoals and segments of demonstrators that walk to one of three places."""
    generator = np.random.default_rng(dimension)
    states = generator.normal(size=(n, dimension))
    goals = np.zeros((3, dimension))
    goals[:, 0] = [-3, 0, 3]
    goals[1, -1] = 4
    goal = np.arange(n) // 7 % 3
    actions = goals[goal] - states
    offset = np.linspace(0, n, trajectories + 1).astype(int)
    demonstrations = Demonstrations.from_arrays(
        states, actions, offset, units="m", times=np.arange(n) * 0.5,
        names=tuple(EVIL if named else f"x${k}" for k in range(dimension)),
        trajectory_names=tuple(f"{EVIL}{k}" if named else f"walk {k}" for k in range(trajectories)),
        source=Source(EVIL if named else "walks.csv", "abc123", {"rows dropped": 3}),
    )  # fmt: skip
    far = generator.normal(size=(12, dimension)) * 2
    names = [EVIL, *(f"place ${k}" for k in range(14))] if named else ()
    near = goals + 0.01
    places = Candidates.from_points(np.vstack([goals, near, far[:9]]), names, radius=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        posterior = sample(action_comparison(demonstrations, places, confidence=5.0), draws=60, warmup=40, thin=1)
    posterior = replace(posterior, status=Status.CONVERGED if converged else Status.NOT_CONVERGED)
    found = subgoals(posterior)
    return posterior, found, segments(posterior, found)
