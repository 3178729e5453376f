"""Small worlds whose action values are given: what tests of the confidence share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal import Demonstrations, LogLikelihood
from subgoal.candidates import Candidates
from subgoal.likelihood.assigned import ActionValues
from subgoal.likelihood.gp_values import TestedValues


@dataclass(frozen=True, eq=False)
class Energies:
    """A source: action values (N, A, G), and the actions taken (N,)."""

    values: np.ndarray
    actions: np.ndarray
    unit: float = 1.0
    kind: str = "energies"

    def log_density(self, start, stop, confidence):
        above = np.asarray(confidence) * self.values[start:stop]
        above = above - above.max(axis=1, keepdims=True)
        log_total = np.log(np.exp(above).sum(axis=1))
        return above[np.arange(stop - start), self.actions[start:stop]] - log_total

    def assigned(self, theta):
        return ActionValues(self.values[np.arange(len(theta)), :, theta], self.actions)

    def log_flat(self, start, stop):
        return np.full(stop - start, -np.log(self.values.shape[1]))

    def log_marginal(self, *_):
        return None

    def arrived(self, start, stop):
        return np.zeros((stop - start, self.values.shape[2]), bool)


@dataclass(frozen=True, eq=False)
class Bell:
    """A source in one dimension: value −(a − g)²/2 of actions (N,), test actions (m,), goals (G,)."""

    actions: np.ndarray
    tests: np.ndarray
    goals: np.ndarray
    unit: float = 1.0
    kind: str = "bell"

    def log_density(self, start, stop, confidence):
        return np.stack(
            [
                self.assigned(np.full(len(self.actions), g)).log_density(confidence)[start:stop]
                for g in range(len(self.goals))
            ],
            axis=1,
        )

    def assigned(self, theta):
        goal = self.goals[np.asarray(theta)]
        tested = -0.5 * (self.tests[None] - goal[:, None]) ** 2
        reach = np.ptp(self.tests)
        return TestedValues(
            -0.5 * (self.actions - goal) ** 2, tested, float(np.log(reach)), self.actions[:, None] / reach,
            self.tests[:, None] / reach,
        )  # fmt: skip


def table(source, offset=None, groups=(), prior=None, **fields) -> LogLikelihood:
    """The likelihood of a source."""
    n = len(source.actions)
    offset = np.array([0, n]) if offset is None else offset
    demos = Demonstrations.from_arrays(np.arange(float(n)), np.zeros(n), offset, groups=groups)
    count = len(source.goals) if isinstance(source, Bell) else source.values.shape[2]
    places = Candidates(np.arange(float(count))[:, None], prior)
    return LogLikelihood(source, 1.0, places, demos, **fields)


def drawn(n=60, actions=5, goals=3, confidence=3.0, seed=0, goal=None) -> Energies:
    """Actions drawn from the model itself: of goal 0 throughout, or of ``goal`` (N,)."""
    generator = np.random.default_rng(seed)
    values = generator.random((n, actions, goals))
    goal = np.zeros(n, int) if goal is None else goal
    chance = np.exp(confidence * values[np.arange(n), :, goal])
    chance /= chance.sum(axis=1, keepdims=True)
    return Energies(values, (chance.cumsum(axis=1) < generator.random((n, 1))).sum(axis=1))
