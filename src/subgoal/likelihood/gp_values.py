"""Source of log densities of continuous actions from value functions of Gaussian-process dynamic programming."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.softmax import tested_tile
from subgoal.candidates.record import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.protocol import check_bounds
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import Ahead, GoalValues
from subgoal.likelihood.source import Confidence
from subgoal.runtime.checks import Bools, Floats, Ints, frozen
from subgoal.runtime.errors import InputError

HELD = 2**24
"""Largest number of action values that are kept (128 MiB); above it they are made again when asked for."""
MOST_HELD_OUT = 2000
ROWS = 2**19
"""Action values that are made at once."""


def checked_pairs(demonstrations: Any, dimension: int, world: ContinuousWorld) -> tuple[Floats, Floats]:
    """States (N, dimension) and actions (N, k) within the bounds of the world. Raises ``InputError`` for others."""
    if not isinstance(demonstrations, Demonstrations) or demonstrations.is_discrete:
        found = "states of a discrete world" if isinstance(demonstrations, Demonstrations) else demonstrations
        raise InputError("demonstrations", found=found, wanted="positions (N, d) and actions (N, k)")
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions, float)
    for what, array, wanted in (("states", states, dimension), ("actions", actions, world.low.size)):
        if array.shape[1:] != (wanted,):
            raise InputError(what, found=f"shape {array.shape}", wanted=f"{wanted} columns")
    return states, check_bounds(world.low, world.high, actions)


@dataclass(frozen=True, eq=False)
class TestedValues:
    """Values of the actions taken (N,) and of the test actions (N, m), for each observation's candidate.

    ``actions`` (N, k) and ``tests`` (m, k) are those actions in units of their range.
    """

    taken: Floats
    tested: Floats
    log_volume: float
    actions: Floats
    tests: Floats

    def some(self, rows: Ints) -> TestedValues:
        """Those of some observations."""
        return TestedValues(self.taken[rows], self.tested[rows], self.log_volume, self.actions[rows], self.tests)

    def log_density(self, confidence: Confidence) -> Floats:
        """(N,) αQ(s, a) − log mean_m exp(αQ(s, u_m)), per unit of volume of the actions."""
        each = np.full(self.taken.shape, confidence, float)
        return np.asarray(log_densities(self.taken[None], self.tested.T[None], each, self.log_volume)[0])

    def score(self, confidence: Confidence) -> Floats:
        """(N, k) the action taken less the mean one of the model, each in units of the range, times α."""
        alpha = np.broadcast_to(np.asarray(confidence, float), self.taken.shape)
        return np.asarray(alpha[:, None] * (self.actions - self._chance(alpha) @ self.tests))

    def steps_wide(self, confidence: Confidence) -> Floats:
        """(N, k) standard deviation of the actions of the model in each dimension, in steps between test actions.

        Well below a half, the mean of the test actions is no integral any more.
        """
        chance = self._chance(np.broadcast_to(np.asarray(confidence, float), self.taken.shape))
        mean = chance @ self.tests
        square = chance @ self.tests**2 - mean**2
        return np.asarray(np.sqrt(np.maximum(square, 0.0)) / steps_between(self.tests))

    def _chance(self, alpha: Floats) -> Floats:
        """(N, m) probabilities of the test actions."""
        chance = np.exp(alpha[:, None] * (self.tested - self.tested.max(axis=1, keepdims=True)))
        return np.asarray(chance / chance.sum(axis=1, keepdims=True))


def steps_between(actions: Floats) -> Floats:
    """(k,) distance of neighbouring actions (m, k) in each dimension: steps of a grid, else of one that is as dense."""
    values = [np.unique(column) for column in actions.T]
    reach = np.ptp(actions, axis=0)
    if math.prod(len(each) for each in values) == len(actions):
        return np.asarray(reach / (np.array([len(each) for each in values]) - 1.0))
    return np.asarray(reach / (len(actions) ** (1 / actions.shape[1]) - 1.0))


def log_densities(taken: Floats, tested: Floats, confidence: Confidence, log_volume: float) -> Floats:
    """(N, G) log densities from values of the actions taken (N, G) and tested (N, m, G): equation (6.2), mended.

    The denominator is the integral over the bounds of the actions, by the mean of the test actions, where (6.2) prints
    a maximum.
    """
    out = np.empty(taken.shape)
    tested_tile(taken, tested, np.full(taken.shape[1], confidence, float), out)
    return np.asarray(out - log_volume)


@dataclass(frozen=True, eq=False, repr=False)
class GaussianProcessValues:
    """Source of log p(a | s, g) = αQ_g(s, a) − log ∫ exp(αQ_g(s, u)) du, Q_g the share of the future spent at g.

    Attributes
    ----------
    plan:
        The value functions.
    world:
        Dynamics, bounds and test actions.
    metric:
        Of the states.
    states, action:
        (N, d) and (N, k) of the observations.
    ahead_of_taken:
        Where the actions taken (N) lead.
    candidates:
        Those of the plan.
    held_out:
        (N,) observations that are not support states.
    """

    plan: GoalValues
    world: ContinuousWorld
    metric: Metric
    states: Floats
    action: Floats
    ahead_of_taken: Ahead
    candidates: Candidates
    held_out: Bools
    kind: str = field(default="Gaussian-process planning", init=False)

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """None is: every state has a choice of actions."""
        return np.zeros(len(self.states), bool)

    @cached_property
    def unit(self) -> float:
        """One over the median difference of best and worst test action, over observations and candidates."""
        spread = np.concatenate([np.ptp(self.tested(a, b), axis=1).ravel() for a, b in self._blocks()])
        spread = spread[spread > 0]
        return 1.0 / float(np.median(spread)) if spread.size else 1.0

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """Complete log densities: their exponentials have mean one over the test actions, times the volume."""
        return log_densities(self.taken[start:stop], self.tested(start, stop), confidence, self.world.log_volume)

    def log_flat(self, start: int, stop: int) -> Floats:
        """All actions alike."""
        return np.full(stop - start, -self.world.log_volume)

    def assigned(self, theta: Ints) -> TestedValues:
        """Action values of each observation's candidate."""
        tested = np.concatenate(
            [np.take_along_axis(self.tested(a, b), theta[a:b, None, None], axis=2)[:, :, 0] for a, b in self._blocks()]
        )
        span = self.world.high - self.world.low
        return TestedValues(
            np.take_along_axis(self.taken, theta[:, None], axis=1)[:, 0], tested, self.world.log_volume,
            self.action / span, self.world.test_actions / span,
        )  # fmt: skip

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> None:
        """No shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Within half the candidates' radius."""
        points = self.candidates.points[None]
        distance = self.metric.distance(self.states[start:stop, None], points)
        return np.asarray(distance <= self.candidates.radius / 2)

    def distance_law(self, confidence: float) -> None:
        """Actions are compared by value, not by distance."""

    def told(self, confidence: float) -> str:
        """Which planner was used and how far from a fixed point it is, in words."""
        plan = self.plan
        held = self.bellman_residuals()
        at = ""
        if held.size:
            at = f"; Bellman residual at {held.shape[0]} other states: mean {held.mean():.1e}, largest {held.max():.1e}"
        proof = "a contraction" if plan.smoother.contracts else f"gain of the smoother {plan.gain:.2g}, so not proved"
        return (
            f"Gaussian-process dynamic programming on {plan.values.shape[0]} support states: {plan.status.value}; "
            f"{plan.residuals.size} sweeps, residual {plan.residual:.1e} ({proof})"
            f"{at}; {self.world!r}"
        )

    def bellman_residuals(self) -> Floats:
        """(rows, G) |V − max_u Q| at the observed states that are not support states, 2,000 at most, evenly spaced."""
        rows = np.flatnonzero(self.held_out)
        if not rows.size:
            return np.zeros((0, self.plan.values.shape[1]))
        rows = rows[np.unique(np.linspace(0, rows.size - 1, min(rows.size, MOST_HELD_OUT)).astype(np.int64))]
        best = np.stack([self.tested(i, i + 1)[0].max(axis=0) for i in rows.tolist()])
        known = self.plan.values_at(coordinates(self.metric, self.states[rows]))
        return np.asarray(np.abs(np.asarray(known) - best))

    def again(self, demonstrations: Demonstrations) -> GaussianProcessValues:
        """The same value functions for other demonstrations. Raises ``InputError`` for those that do not fit."""
        states, actions = checked_pairs(demonstrations, self.metric.dimension, self.world)
        return replace(
            self, states=states, action=actions, ahead_of_taken=self.world.ahead(states, actions, self.metric),
            held_out=np.ones(len(states), bool),
        )  # fmt: skip

    @cached_property
    def taken(self) -> Floats:
        """(N, G) values of the actions taken."""
        return frozen(np.asarray(self.plan.action_values(self.ahead_of_taken)))

    def tested(self, start: int, stop: int) -> Floats:
        """(rows, m, G) values of the test actions."""
        if self._whole is not None:
            return self._whole[start:stop]
        return self._tested(start, stop)

    @cached_property
    def _whole(self) -> Floats | None:
        m, goals = len(self.world.test_actions), self.plan.values.shape[1]
        if len(self.states) * m * goals > HELD:
            return None
        return frozen(np.concatenate([self._tested(a, b) for a, b in self._blocks()]))

    def _tested(self, start: int, stop: int) -> Floats:
        m = len(self.world.test_actions)
        values = self.plan.action_values(self.world.ahead_of_tests(self.states[start:stop], self.metric))
        return np.asarray(values).reshape(stop - start, m, -1)

    def _blocks(self) -> list[tuple[int, int]]:
        rows = max(1, ROWS // (len(self.world.test_actions) * self.plan.values.shape[1]))
        n = len(self.states)
        return [(a, min(a + rows, n)) for a in range(0, n, rows)]
