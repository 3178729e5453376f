"""Small posteriors, every assignment of which is written out."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.checks import Floats, Ints

PRIOR = np.array([0.5, 0.3, 0.2])
GENERIC = np.log(np.array([[0.7, 0.2, 0.4], [0.1, 0.6, 0.3], [0.5, 0.4, 0.9], [0.2, 0.8, 0.1]]))
PEAKED = np.log(np.array([[0.98, 0.01, 0.01], [0.01, 0.97, 0.02], [0.02, 0.01, 0.97], [0.96, 0.02, 0.02]]))
WALLED = GENERIC.copy()
WALLED[0, 1] = WALLED[2, 2] = WALLED[3, 0] = WALLED[3, 2] = -np.inf
TABLES = {"generic": GENERIC, "peaked": PEAKED, "walled": WALLED}
"""Log densities of 4 observations and 3 candidates; in the last, some are impossible."""


@dataclass(frozen=True, eq=False)
class Enumerated:
    """A posterior p(θ | O): its table (N, G), η, all S possible assignments (S, N) and their probabilities (S,)."""

    likelihood: LogLikelihood
    concentration: float
    states: Ints
    probability: Floats

    def drawn(self, count: int, generator: np.random.Generator) -> Ints:
        """(count, N) independent draws."""
        return np.asarray(self.states[generator.choice(len(self.states), count, p=self.probability)])

    def tally(self, assignments: Any) -> Ints:
        """(S,) how often each state is among (count, N) assignments; ``LookupError`` for one that is impossible."""
        base = self.likelihood.n_candidates ** np.arange(self.states.shape[1])
        order = np.argsort(self.states @ base)
        codes = (self.states @ base)[order]
        seen = np.asarray(assignments, np.int64) @ base
        place = np.minimum(np.searchsorted(codes, seen), codes.size - 1)
        wrong = codes[place] != seen
        if wrong.any():
            raise LookupError(f"drew {assignments[int(np.argmax(wrong))].tolist()}, which is impossible")
        return np.bincount(order[place], minlength=len(self.states))


def enumerated(table: Floats, concentration: float, prior: Floats = PRIOR, power: float = 1.0) -> Enumerated:
    """The law ∝ p(θ)·p(O | θ)^power, the prior by Blackwell and MacQueen's urn, draw after draw."""
    n, g_count = table.shape
    states = np.array(list(itertools.product(range(g_count), repeat=n)))
    weight = np.exp([log_urn(theta, concentration, prior) for theta in states])
    weight *= np.exp(power * table[np.arange(n), states].sum(axis=1))
    possible = weight > 0
    return Enumerated(likelihood_of(table, prior), concentration, states[possible], weight[possible] / weight.sum())


def likelihood_of(table: Floats, prior: Floats, **fields: Any) -> LogLikelihood:
    """The table with a prior of its columns."""
    places = Candidates(np.arange(len(prior), dtype=float)[:, None], np.log(prior))
    return LogLikelihood.from_table(table, candidates=places, **fields)


def log_urn(theta: Ints, concentration: float, prior: Floats) -> float:
    """log p(θ)."""
    seen = np.zeros(prior.size)
    total = 0.0
    for i, g in enumerate(theta):
        total += float(np.log((seen[g] + concentration * prior[g]) / (i + concentration)))
        seen[g] += 1
    return total
