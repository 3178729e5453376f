"""What a sampler takes and gives: a small view of the likelihood table in, a stretch of draws out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

Int32s = NDArray[np.int32]
FIRST_TABLES = 64
Arrays = Mapping[str, NDArray[Any]]


class Table(Protocol):
    """The N × G table ℓ[i, g] = log p(a_i | s_i, g) as samplers see it: arrays, no control."""

    @property
    def n_observations(self) -> int:
        """N."""

    @property
    def n_candidates(self) -> int:
        """G."""

    @property
    def log_prior(self) -> Floats:
        """(G,) log P(g), normalised."""

    @property
    def dense(self) -> Floats | None:
        """(N, G) whole table, or None when it is only computed in tiles."""

    @property
    def relative(self) -> Floats | None:
        """(N, G) L_ig / Σ_g p_g L_ig, or None when the table is tiled."""

    @property
    def edges(self) -> Ints:
        """Boundaries of the blocks of rows in which the table is gone through, from 0 to N."""

    @property
    def offset(self) -> Ints:
        """(D+1,) first row of each trajectory, and N."""

    @property
    def arrived(self) -> Any:
        """(N, G) sparse rows of booleans: which observation is at which candidate."""

    def tiles(self) -> Iterator[tuple[int, Floats]]:
        """Consecutive blocks of rows: first row and (rows, G) values."""

    def rows(self, start: int, stop: int) -> Floats:
        """(stop − start, G) values of some rows."""

    def relative_tile(self, start: int, tile: Floats) -> Floats:
        """The same ratio for one tile of rows."""


@dataclass(frozen=True)
class Stretch:
    """A run of consecutive sweeps of one chain.

    Attributes
    ----------
    state:
        Named arrays from which the chain goes on; what they are is the sampler's own affair.
    assignments:
        (kept, N) candidate of each observation after each kept sweep.
    n_active, log_likelihood, log_joint:
        (sweeps,) number of distinct candidates in use, Σ ℓ[i, θ_i], and log p(θ, O) at dish level, with whatever else
        is sampled.
    parameters:
        What else is sampled, each (kept, ...), after each kept sweep.
    redraws:
        (kept, G) how often each candidate was drawn from the shared weights; None where that is once per observation.
    """

    state: Arrays
    assignments: Int32s
    n_active: Ints
    log_likelihood: Floats
    log_joint: Floats
    parameters: Arrays = field(default_factory=dict)
    redraws: Ints | None = None


@dataclass(frozen=True)
class Chain:
    """One Markov chain about to go on.

    Attributes
    ----------
    table:
        The likelihood.
    concentration:
        η of the Chinese restaurant process (thesis 2.8), expected mass of new subgoals.
    generator:
        The chain's own stream; a sampler draws from nothing else.
    state:
        As the last stretch left it; None starts the chain.
    """

    table: Table
    concentration: float
    generator: np.random.Generator
    state: Arrays | None = None


class Sampler(Protocol):
    """A function that advances a chain by ``len(keep)`` sweeps; ``keep`` marks those whose assignments are wanted."""

    @property
    def __name__(self) -> str:
        """What it is called in settings and reports."""

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """See the class."""


class Recorder:
    """Arrays that a stretch of sweeps fills."""

    def __init__(self, table: Table, keep: Bools) -> None:
        self.kept = np.empty((int(keep.sum()), table.n_observations), np.int32)
        self.n_active = np.empty(keep.size, np.int64)
        self.log_likelihood = np.empty(keep.size)
        self.log_joint = np.empty(keep.size)
        self._rows = 0

    def sweep(self, s: int, kept: bool, theta: Int32s, n_active: int, likelihood: float, joint: float) -> None:
        """Record sweep ``s`` (tiled samplers; the dense loops write the arrays themselves)."""
        self.n_active[s], self.log_likelihood[s], self.log_joint[s] = n_active, likelihood, joint
        if kept:
            self.kept[self._rows] = theta
            self._rows += 1

    def stretch(self, state: Arrays) -> Stretch:
        """The frozen result."""
        return Stretch(state, self.kept, self.n_active, self.log_likelihood, self.log_joint)


def starting_assignment(table: Table, generator: np.random.Generator) -> Int32s:
    """(N,) where a chain begins: one subgoal drawn from the prior for all (thesis Alg. 4 lines 2-5).

    Observations that are impossible under it start at a candidate drawn from their own posterior, so that every
    chain begins at a possible state. Chains differ in their first subgoal, hence start apart.
    """
    prior = np.exp(table.log_prior)
    first = int(generator.choice(table.n_candidates, p=prior / prior.sum()))
    theta = np.full(table.n_observations, first, np.int32)
    for start, tile in table.tiles():
        for row in np.flatnonzero(np.isneginf(tile[:, first])):
            weight = tile[row] + table.log_prior
            weight = np.exp(weight - weight.max())
            theta[start + row] = generator.choice(table.n_candidates, p=weight / weight.sum())
    return theta


def refuse_lone_steps(offset: Ints, model: str) -> None:
    """Raise ``InputError`` where no trajectory has two observations: nothing is known of what follows what."""
    if (np.diff(offset) < 2).all():
        raise InputError(
            "demonstrations", found=f"one observation in each of {offset.size - 1} trajectories",
            wanted=f"some trajectory with two, for {model} to learn from",
            hint="trajectory= with the column that tells trajectories apart (offset, for arrays), a smaller every=, or "
            "model=None, the exchangeable model",
        )  # fmt: skip


def log_fit(table: Table, theta: Int32s) -> float:
    """Σ ℓ[i, θ_i]."""
    fit = 0.0
    for start, tile in table.tiles():
        fit += float(tile[np.arange(len(tile)), theta[start : start + len(tile)]].sum())
    return fit


def relative_rows(table: Table, start: int, stop: int) -> Floats:
    """(stop − start, G) rows of L_ig / Σ_g p_g L_ig."""
    whole = table.relative
    return whole[start:stop] if whole is not None else table.relative_tile(start, table.rows(start, stop))
