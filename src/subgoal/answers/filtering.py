"""Filtering: which subgoal is served now, given the actions so far; and how well each action was foretold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import logsumexp

from subgoal._kernels.persistence import filter_rows
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.table import LogLikelihood
from subgoal.partition.priors import log_weights
from subgoal.posterior.posterior import CountDraws, Posterior
from subgoal.runtime.checks import Bools, Floats, Ints, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.seeds import stream

DRAWS = 100
ROWS = 1e-300
"""Rows of transitions are kept above this, so that their logarithms are numbers."""


@dataclass(frozen=True, eq=False)
class Filtering:
    """What was known at each observation of some demonstrations, from a posterior of others.

    Attributes
    ----------
    log_predictive:
        (M,) log p(a_t | states up to t, actions before t in the same trajectory, O), nats.
    probability:
        (M, G) p(candidate g is served at t | actions up to t, O); the rest to one is the background.
    """

    log_predictive: Floats
    probability: Floats

    @property
    def bits_per_decision(self) -> float:
        """Mean log₂ of the predictive probability (density, where actions are continuous)."""
        return float(self.log_predictive.mean() / np.log(2))


def filtering(posterior: Posterior, demonstrations: Demonstrations, *, draws: int = DRAWS, seed: int = 0) -> Filtering:
    """Filter ``demonstrations`` forward in time under a posterior of others, trajectory by trajectory.

    The exact predictive of the model, averaged over ``draws`` draws: weights, or rows of transitions, are drawn given
    the counts of each, and draws that foretold a trajectory so far better than others count for more in what follows.
    The noise is at its posterior mean. Works for the exchangeable model, ``Persistent`` and ``StickyHMM``; only the
    past is used, so that this is also what can be said while a recording is still going on.

    Raises ``InputError`` for groups, for a posterior without its likelihood, and for demonstrations that do not fit.
    """
    if posterior.likelihood is None:
        raise InputError("posterior", found="no likelihood", wanted="one with it", hint="load(path, mdp=mdp)")
    table = same_likelihood(posterior.likelihood, demonstrations)
    first = np.zeros(table.n_observations, bool)
    first[table.offset[:-1]] = True
    rows = np.unique(np.linspace(0, posterior.log_joint.size - 1, whole("draws", draws)).astype(int))
    laws = _laws(posterior)
    log_total = np.empty((rows.size, table.n_observations))
    filtered = []
    for k, row in enumerate(rows.tolist()):
        law = laws(posterior, int(row), stream(seed, 85, int(row)))
        out = np.empty((table.n_observations, table.n_candidates))
        law.run(table, first, out, log_total[k])
        filtered.append(out)
    log_total += table.log_marginal
    return _averaged(log_total, filtered, demonstrations.trajectory, posterior.candidates.n_candidates)


def _averaged(log_total: Floats, filtered: list[Floats], trajectory: Ints, places: int) -> Filtering:
    """Mean over draws, each weighted by how well it foretold the trajectory before."""
    so_far = np.cumsum(log_total, axis=1)
    begin = np.searchsorted(trajectory, np.arange(trajectory.max() + 1))
    before_trajectory = np.where(begin > 0, so_far[:, begin - 1], 0.0)[:, trajectory]
    after = so_far - before_trajectory
    before = after - log_total
    predictive = logsumexp(after, axis=0) - logsumexp(before, axis=0)
    weight = np.exp(after - logsumexp(after, axis=0))
    probability = sum(w[:, None] * each[:, :places] for w, each in zip(weight, filtered, strict=True))
    return Filtering(np.asarray(predictive), np.asarray(probability))


def _laws(posterior: Posterior) -> Any:
    if "stickiness" in posterior.parameters:
        return _Transitions.of
    if "persistence" in posterior.parameters or posterior.redraws is None or "Persistent(" in posterior.settings.model:
        return _SharedWeights.of
    raise InputError("posterior", found=posterior.settings.model, wanted="a model of one sequence, without groups")


@dataclass(frozen=True, eq=False)
class _SharedWeights:
    """Weights (G,) that all redraws share, and the probabilities of keeping the subgoal."""

    weights: Floats
    keep: float
    keep_there: float

    @classmethod
    def of(cls, posterior: Posterior, row: int, generator: np.random.Generator) -> _SharedWeights:
        counts = _counts(_redraws(posterior), row, _columns(posterior))
        if posterior.redraws is None and posterior.settings.background:
            counts[-1] = posterior.n_observations - counts.sum()
        weights = np.exp(log_weights(_concentration(posterior, row) * _prior(posterior) + counts, generator))
        keep = _parameter(posterior, "persistence", row)
        there = _parameter(posterior, "persistence at the subgoal", row)
        return cls(weights, keep or 0.0, (keep or 0.0) if there is None else there)

    def run(self, table: LogLikelihood, first: Bools, out: Floats, log_total: Floats) -> None:
        """Write the filtered laws and the totals, relative to the marginals."""
        there_from, there = np.zeros(first.size + 1, np.int64), np.empty(0, np.int64)
        if self.keep_there != self.keep:
            there_from, there = table.arrived.indptr.astype(np.int64), table.arrived.indices.astype(np.int64)
        entering = np.zeros(self.weights.size)
        for start, tile in table.tiles():
            stop = start + len(tile)
            filter_rows(
                start, table.relative_tile(start, tile), first, there_from, there, self.weights, self.keep,
                self.keep_there, entering, out[start:stop], log_total[start:stop],
            )  # fmt: skip
            entering = out[stop - 1].copy()


@dataclass(frozen=True, eq=False)
class _Transitions:
    """Law of the first subgoal (G,), and of the next one after each (G, G)."""

    first: Floats
    rows: Floats

    @classmethod
    def of(cls, posterior: Posterior, row: int, generator: np.random.Generator) -> _Transitions:
        if posterior.assignments is None:
            raise InputError("posterior.assignments", found="None: they were not kept", wanted="all draws")
        size = _columns(posterior)
        shared = _counts(_redraws(posterior), row, size)
        base = np.exp(log_weights(_concentration(posterior, row) * _prior(posterior) + shared, generator))
        mass, sticky = _parameter(posterior, "row mass", row) or 0.0, _parameter(posterior, "stickiness", row) or 0.0
        theta = posterior.assignments.reshape(-1, posterior.n_observations)[row]
        theta = np.where(theta < 0, size - 1, theta)
        begins = posterior.demonstrations.offset[:-1]
        inside = np.setdiff1d(np.arange(1, theta.size), begins)
        counts = np.zeros((size, size))
        np.add.at(counts, (theta[inside - 1], theta[inside]), 1)
        shape = np.maximum(mass * (1 - sticky) * base, ROWS)
        rows = np.stack([
            np.exp(log_weights(shape + counts[j] + mass * sticky * (np.arange(size) == j), generator))
            for j in range(size)
        ])  # fmt: skip
        begun = np.bincount(theta[begins], minlength=size)
        return cls(np.exp(log_weights(shape + begun, generator)), rows)

    def run(self, table: LogLikelihood, first: Bools, out: Floats, log_total: Floats) -> None:
        """Write the filtered laws and the totals, relative to the marginals."""
        law = self.first
        for start, tile in table.tiles():
            relative = table.relative_tile(start, tile)
            for r in range(len(tile)):
                law = (self.first if first[start + r] else law @ self.rows) * relative[r]
                total = law.sum()
                law /= total
                out[start + r], log_total[start + r] = law, np.log(total)


def _columns(posterior: Posterior) -> int:
    return posterior.candidates.n_candidates + (posterior.settings.background > 0)


def _prior(posterior: Posterior) -> Floats:
    if posterior.likelihood is None:
        raise InputError("posterior", found="no likelihood", wanted="one with it")
    return np.exp(posterior.likelihood.log_prior)


def _redraws(posterior: Posterior) -> CountDraws:
    return posterior.counts if posterior.redraws is None else posterior.redraws


def _counts(draws: CountDraws, row: int, size: int) -> Floats:
    part = slice(int(draws.offset[row]), int(draws.offset[row + 1]))
    counts = np.zeros(size)
    counts[draws.candidate[part]] = draws.count[part]
    return counts


def _concentration(posterior: Posterior, row: int) -> float:
    learned = _parameter(posterior, "concentration", row)
    return posterior.concentration if learned is None else learned


def _parameter(posterior: Posterior, name: str, row: int) -> float | None:
    if name not in posterior.parameters:
        return None
    return float(posterior.parameters[name].ravel()[row])
