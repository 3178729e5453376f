"""Sources of action comparison: unit directions through compiled loops, or any controller in blocks."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.directions import direction_log_sum, direction_tile
from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.likelihood import normalisers
from subgoal.likelihood.assigned import Chords, Shortfalls, unit_vectors
from subgoal.likelihood.controllers import Controller
from subgoal.likelihood.source import Confidence, DistanceLaw
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

Compare = Literal["direction", "action"]
ROWS = 256
"""Observations for which a controller is asked at a time."""


@dataclass(frozen=True, eq=False)
class Pace:
    """Weights of the action dimensions, median and top speed of the pairs that move, and which pairs are slow."""

    weights: Floats
    median: float
    top: float
    slow: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Directions:
    """Unit directions against the straight way (5.2): the compiled source. All arrays in weighted units."""

    units: Floats
    states: Floats
    goals: Floats
    period: Floats
    slow: NDArray[np.bool_]
    near: float
    kind: str = field(default="directions", init=False)
    unit: float = field(default=1.0, init=False)

    @classmethod
    def of(cls, states: Floats, actions: Floats, candidates: Candidates, pace: Pace) -> Directions:
        """Weighted once, here, so that the loops need not."""
        weights, weighted = candidates.metric.weights, actions * pace.weights
        speed = np.linalg.norm(weighted, axis=1, keepdims=True)
        return cls(
            np.ascontiguousarray(weighted / np.where(speed > 0, speed, 1.0)),
            np.ascontiguousarray(states * weights),
            np.ascontiguousarray((candidates.points * weights).T),
            candidates.metric.period * weights,
            pace.slow,
            candidates.radius / 2,
        )

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) slow pairs."""
        return self.slow

    def _constants(self, confidence: Confidence) -> tuple[Floats, Floats, float]:
        """α and the logarithm of its normaliser for each candidate, and the log density of a uniform direction."""
        d = self.states.shape[1]
        each = np.full(self.goals.shape[1], confidence, float)
        return each, normalisers.log_direction_normalisers(each, d), -normalisers.log_sphere_area(d)

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """Complete density over the unit sphere."""
        out = np.empty((stop - start, self.goals.shape[1]))
        block = slice(start, stop)
        direction_tile(
            self.units[block], self.states[block], self.slow[block], self.goals, self.period, self.near,
            *self._constants(confidence), out,
        )  # fmt: skip
        return out

    def log_flat(self, start: int, stop: int) -> Floats:
        """Uniform over the unit sphere."""
        return np.full(stop - start, -normalisers.log_sphere_area(self.states.shape[1]))

    def assigned(self, theta: Ints) -> Chords:
        """Directions beside those to each observation's candidate."""
        d = self.states.shape[1]
        way = Metric(np.ones(d), self.period).difference(self.states, self.goals.T[theta])
        flat = self.slow | (np.linalg.norm(way, axis=1) <= self.near)
        return Chords(self.units, unit_vectors(way), flat)

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> Floats:
        """Summed on the fly: memory O(N + G)."""
        out = np.empty(stop - start)
        block = slice(start, stop)
        direction_log_sum(
            self.units[block], self.states[block], self.slow[block], self.goals, self.period, self.near,
            *self._constants(confidence), log_prior, out,
        )  # fmt: skip
        return out

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Within half the candidates' radius."""
        metric = Metric(np.ones(len(self.period)), self.period)
        return np.asarray(metric.distance(self.states[start:stop, None], self.goals.T[None]) <= self.near)

    def distance_law(self, confidence: float) -> DistanceLaw:
        """Chord between unit directions, 0 to 2."""
        return _direction_law(confidence, self.states.shape[1])


@dataclass(frozen=True, eq=False)
class ControllerActions:
    """Any controller, called for blocks of observations and all candidates at once."""

    states: Floats
    actions: Floats
    candidates: Candidates
    pace: Pace
    controller: Controller
    compare: Compare
    kind: str = field(default="controller", init=False)
    unit: float = field(default=1.0, init=False)

    @classmethod
    def of(
        cls,
        states: Floats,
        actions: Floats,
        candidates: Candidates,
        pace: Pace,
        controller: Controller,
        compare: Compare,
    ) -> ControllerActions:
        """Tried on one pair before anything is built on it."""
        source = cls(states, actions, candidates, pace, controller, compare)
        source._goal_actions(0, 1)
        return source

    @property
    def uninformative(self) -> NDArray[np.bool_]:
        """(N,) slow pairs."""
        return self.pace.slow

    def _goal_actions(self, start: int, stop: int) -> Floats:
        """(B, G, k) what the controller would do."""
        shape = (stop - start, self.candidates.n_candidates, self.actions.shape[1])
        answer = np.asarray(self.controller(self.states[start:stop, None], self.candidates.points[None]), float)
        try:
            if answer.shape[-1:] != shape[-1:]:
                raise ValueError("one number per dimension of the actions")
            answer = np.broadcast_to(answer, shape)
        except ValueError:
            raise InputError(
                "controller", found=f"actions of shape {answer.shape}", wanted=f"{shape} (observations, candidates, k)",
                hint="write it for states and goals that broadcast, e.g. goal - state",
            ) from None  # fmt: skip
        if not np.isfinite(answer).all():
            i, g, _ = (int(k) for k in np.argwhere(~np.isfinite(answer))[0])
            raise InputError("controller", where=f"observation {start + i}, candidate {g}", found="a non-finite action",
                             wanted="finite numbers")  # fmt: skip
        return answer

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """Complete density over the unit sphere or over R^k, as ``compare`` says."""
        distance, flat = self._distances(start, stop)
        log_flat = float(self.log_flat(0, 1)[0])
        return np.where(flat, log_flat, -confidence * distance - self._log_normaliser(confidence))

    def _distances(self, start: int, stop: int) -> tuple[Floats, NDArray[np.bool_]]:
        """(B, G) distances in units of the scale, and where no action is asked for."""
        wanted, flat = self._wanted(start, stop)
        done = (self.actions[start:stop] * self.pace.weights)[:, None]
        if self.compare == "direction":
            return np.linalg.norm(unit_vectors(done) - unit_vectors(wanted), axis=2), flat
        return np.linalg.norm(done - wanted, axis=2) / self.pace.median, flat

    def _wanted(self, start: int, stop: int) -> tuple[Floats, NDArray[np.bool_]]:
        """(B, G, k) weighted actions asked for, and (B, G) where none is."""
        there = self.arrived(start, stop)
        wanted = self._goal_actions(start, stop) * self.pace.weights
        slow = np.broadcast_to(self.pace.slow[start:stop, None], there.shape)
        if self.compare == "direction":
            return wanted, there | (np.linalg.norm(wanted, axis=2) == 0) | slow
        return np.where(there[..., None], 0.0, wanted), slow

    def _log_normaliser(self, confidence: Confidence) -> Floats:
        k = self.actions.shape[1]
        if self.compare == "direction":
            return normalisers.log_direction_normalisers(np.atleast_1d(confidence), k)
        log_weights = normalisers.sum_log(self.pace.weights)
        return np.asarray(normalisers.log_action_normaliser(confidence, k, self.pace.median, log_weights))

    def log_flat(self, start: int, stop: int) -> Floats:
        """Uniform over the unit sphere, or over the ball of the fastest demonstrated speed."""
        k = self.actions.shape[1]
        if self.compare == "direction":
            return np.full(stop - start, -normalisers.log_sphere_area(k))
        log_weights = normalisers.sum_log(self.pace.weights)
        return np.full(stop - start, -normalisers.log_ball_volume(k, self.pace.top, log_weights))

    def assigned(self, theta: Ints) -> Chords | Shortfalls:
        """Actions beside what the controller would do for each observation's candidate."""
        n = len(self.states)
        wanted, flat = np.empty(self.actions.shape), np.empty(n, bool)
        for start in range(0, n, ROWS):
            rows = np.arange(start, min(start + ROWS, n))
            parts = self._wanted(start, start + rows.size)
            wanted[rows], flat[rows] = parts[0][rows - start, theta[rows]], parts[1][rows - start, theta[rows]]
        done = self.actions * self.pace.weights
        if self.compare == "direction":
            return Chords(unit_vectors(done), unit_vectors(wanted), flat)
        return Shortfalls((done - wanted) / self.pace.median, flat, float(self.log_flat(0, 1)[0]), self._log_normaliser)

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> None:
        """No shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Within half the candidates' radius."""
        points = self.candidates.points[None]
        distance = self.candidates.metric.distance(self.states[start:stop, None], points)
        return np.asarray(distance <= self.candidates.radius / 2)

    def distance_law(self, confidence: float) -> DistanceLaw:
        """Chord between directions, or distance in median speeds."""
        k = self.actions.shape[1]
        if self.compare == "direction":
            return _direction_law(confidence, k)
        log_z = normalisers.log_action_normaliser(
            confidence, k, self.pace.median, normalisers.sum_log(self.pace.weights)
        )
        upper = (k + 6 * k**0.5) / confidence
        return DistanceLaw(log_z, lambda r: normalisers.action_distance_cdf(r, confidence, k), upper)


def _direction_law(confidence: float, dimension: int) -> DistanceLaw:
    log_z = normalisers.log_direction_normaliser(confidence, dimension)
    return DistanceLaw(log_z, lambda r: normalisers.direction_distance_cdf(r, confidence, dimension), 2.0)
