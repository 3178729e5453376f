"""Observations beside one candidate each: how well it explains them at any confidence, and which way they are off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from subgoal.likelihood import normalisers
from subgoal.likelihood.source import Confidence
from subgoal.runtime.checks import Bools, Floats, Ints


@dataclass(frozen=True, eq=False)
class Chords:
    """Unit directions taken and asked for, both (N, d); ``flat`` (N,) where none is asked for."""

    taken: Floats
    asked: Floats
    flat: Bools

    def some(self, rows: Ints) -> Chords:
        """Those of some observations."""
        return Chords(self.taken[rows], self.asked[rows], self.flat[rows])

    def log_density(self, confidence: Confidence) -> Floats:
        """(N,) −α‖u − û‖ − log Z(α), or the uniform density."""
        d = self.taken.shape[1]
        log_z = normalisers.log_direction_normalisers(np.atleast_1d(confidence), d)
        distance = np.linalg.norm(self.taken - self.asked, axis=1)
        return np.where(self.flat, -normalisers.log_sphere_area(d), -confidence * distance - log_z)

    def score(self, confidence: Confidence) -> Floats:
        """(N, d) along the sphere: of length α·cos(φ/2) for an angle φ between the two, towards the one taken."""
        cosine = np.sum(self.taken * self.asked, axis=1)
        across = unit_vectors(self.taken - cosine[:, None] * self.asked)
        length = confidence * np.sqrt(np.clip((1 + cosine) / 2, 0, 1)) * ~self.flat
        return np.asarray(across * length[:, None])


@dataclass(frozen=True, eq=False)
class Shortfalls:
    """Actions taken minus asked for (N, k), in units of the scale; ``flat`` (N,) where none is asked for."""

    gap: Floats
    flat: Bools
    log_flat: float
    log_normaliser: Callable[[Confidence], Floats]

    def some(self, rows: Ints) -> Shortfalls:
        """Those of some observations."""
        return Shortfalls(self.gap[rows], self.flat[rows], self.log_flat, self.log_normaliser)

    def log_density(self, confidence: Confidence) -> Floats:
        """(N,) −α‖a − a_CL‖ − log Z(α), or the density of actions that serve nothing."""
        distance = np.linalg.norm(self.gap, axis=1)
        return np.where(self.flat, self.log_flat, -confidence * distance - self.log_normaliser(confidence))

    def score(self, confidence: Confidence) -> Floats:
        """(N, k) of length α, towards the action taken."""
        return np.asarray(unit_vectors(self.gap) * (confidence * ~self.flat)[:, None])


@dataclass(frozen=True, eq=False)
class ActionValues:
    """Values (N, A) of all actions for each observation's candidate, −inf for illegal ones, and the actions (N,)."""

    values: Floats
    actions: Ints

    def some(self, rows: Ints) -> ActionValues:
        """Those of some observations."""
        return ActionValues(self.values[rows], self.actions[rows])

    def log_density(self, confidence: Confidence) -> Floats:
        """(N,) log probabilities of the actions taken."""
        above = self._above(confidence)
        return np.asarray(above[np.arange(self.actions.size), self.actions] - np.log(np.exp(above).sum(axis=1)))

    def score(self, confidence: Confidence) -> Floats:
        """(N, A) α·(1[a taken] − π(a)): by the values of the actions."""
        chance = np.exp(self._above(confidence))
        chance /= chance.sum(axis=1, keepdims=True)
        taken = np.zeros_like(chance)
        taken[np.arange(self.actions.size), self.actions] = 1.0
        return np.asarray(np.atleast_1d(np.asarray(confidence, float))[:, None] * (taken - chance))

    def _above(self, confidence: Confidence) -> Floats:
        alpha = np.atleast_1d(np.asarray(confidence, float))[:, None]
        return np.asarray(alpha * (self.values - self.values.max(axis=1, keepdims=True)))


def unit_vectors(vectors: Floats) -> Floats:
    """Each vector (last axis) at length one; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0, length, 1.0))
