"""The result: draws of θ, the candidate behind each observation, with their diagnostics and provenance."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.posterior.diagnostics import Diagnostic, Status
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

EXCHANGEABLE = "exchangeable"


@dataclass(frozen=True)
class Settings:
    """Everything that decides the draws: with the same settings and data they are the same.

    ``concentration`` and ``confidence`` are numbers, or a prior in words where they were learned; ``model`` says how
    subgoals follow each other, ``planner`` how actions were planned and how wrong that may be, where they were.
    """

    sampler: str
    concentration: float | str
    confidence: float | str
    chains: int
    draws: int
    warmup: int
    thin: int
    seed: int
    likelihood: str
    data: str
    version: str
    model: str = EXCHANGEABLE
    background: float = 0.0
    planner: str = ""

    @property
    def sweeps(self) -> int:
        """Sweeps per chain, warm-up included."""
        return self.warmup + self.draws * self.thin


@dataclass(frozen=True, eq=False, repr=False)
class CountDraws:
    """How many observations each candidate has in each draw, as sparse rows.

    Draw t of chain c is row r = c·draws + t; its candidates and counts are ``candidate[offset[r]:offset[r+1]]`` and
    ``count[...]``.
    """

    offset: Ints
    candidate: Ints
    count: Ints

    def __repr__(self) -> str:
        return f"CountDraws({self.offset.size - 1} draws)"

    @property
    def row(self) -> Ints:
        """Row of each entry."""
        return np.repeat(np.arange(self.offset.size - 1), np.diff(self.offset))

    def by_group(self, group: Ints, n_groups: int) -> Ints:
        """(rows, n_groups) observations per group of candidates; ``group`` (G,) maps candidates, −1 to none."""
        table = np.zeros((self.offset.size - 1, n_groups), np.int64)
        inside = group[self.candidate] >= 0
        np.add.at(table, (self.row[inside], group[self.candidate[inside]]), self.count[inside])
        return table

    def of_places(self, places: int) -> CountDraws:
        """Without the counts of the background, which is numbered after the ``places`` candidates."""
        inside = self.candidate < places
        sizes = np.bincount(self.row[inside], minlength=self.offset.size - 1)
        return CountDraws(np.append(0, np.cumsum(sizes)), self.candidate[inside], self.count[inside])

    def largest(self, ranks: int) -> Ints:
        """(rows, ranks) the largest counts of each draw, in falling order, zero where there are fewer."""
        order = np.lexsort((-self.count, self.row))
        rank = np.arange(order.size) - np.repeat(self.offset[:-1], np.diff(self.offset))
        table = np.zeros((self.offset.size - 1, ranks), np.int64)
        inside = rank < ranks
        table[self.row[order][inside], rank[inside]] = self.count[order][inside]
        return table


@dataclass(frozen=True, eq=False, repr=False)
class Posterior:
    """Draws from p(θ | O) and what they were drawn for.

    Attributes
    ----------
    assignments:
        (chain, draw, N) int32 candidate of each observation, −1 for background; None above the memory budget, when
        ``counts`` and ``shares`` stand for them. −1 is the background.
    counts:
        Observations per candidate in each draw.
    shares:
        (N, G) sparse, the share of draws in which observation i serves candidate g: P(θ_i = g | O).
    best_assignment:
        (N,) the visited draw of highest log p(θ, O) (the honest reading of the thesis's "mode", Theorem 1).
    log_joint, log_likelihood:
        (chain, draw) log p(θ, O) at dish level, and Σ ℓ[i, θ_i].
    parameters:
        Whatever else was sampled, each (chain, draw, ...).
    redraws:
        How often each candidate was drawn from the shared weights in each draw, where that is not once for each
        observation (subgoals that persist); None otherwise.
    traces:
        "n_active" (distinct candidates in use), "log_joint" and "loss" (mean −ℓ[i, θ_i], nats per observation), each
        (chain, sweep), warm-up included.
    diagnostics, status:
        The gate, per label-invariant summary and in one word.
    likelihood:
        The table the draws are from; None for a loaded posterior whose table cannot be made again.
    weight_settled:
        Whether the weight of an observation that ``learn`` came to agrees with the errors it leaves; None where none
        was sought.
    """

    demonstrations: Demonstrations
    candidates: Candidates
    settings: Settings
    assignments: NDArray[np.int32] | None
    counts: CountDraws
    shares: sparse.csr_array
    best_assignment: NDArray[np.int32]
    log_joint: Floats
    log_likelihood: Floats
    traces: dict[str, Floats]
    diagnostics: dict[str, Diagnostic]
    status: Status
    uninformative: NDArray[np.bool_]
    seconds: float
    parameters: dict[str, NDArray[Any]] = field(default_factory=dict)
    redraws: CountDraws | None = None
    likelihood: LogLikelihood | None = None
    weight_settled: bool | None = None

    def __repr__(self) -> str:
        made = f"{self.n_chains} chains × {self.n_draws} draws of {self.settings.sampler}"
        return f"Posterior({made}, {self.n_observations} observations, {self.status.name})"

    @property
    def n_observations(self) -> int:
        """N."""
        return self.demonstrations.n_observations

    @property
    def n_chains(self) -> int:
        """Chains."""
        return int(self.log_joint.shape[0])

    @property
    def n_draws(self) -> int:
        """Kept draws per chain."""
        return int(self.log_joint.shape[1])

    @property
    def known_likelihood(self) -> LogLikelihood:
        """``likelihood``; raises ``InputError`` where it is lost."""
        if self.likelihood is None:
            raise InputError("posterior", found="no likelihood", wanted="one with it", hint="load(path, mdp=mdp)")
        return self.likelihood

    @property
    def expected_shares(self) -> Floats:
        """(G,) expected share of the observations that serve each candidate: E[n_g | O] / N."""
        return np.asarray(self.shares.sum(axis=0)).ravel() / self.n_observations

    @property
    def concentration(self) -> float:
        """η, or its posterior mean where it was learned."""
        setting = self.settings.concentration
        return float(self.parameters["concentration"].mean()) if isinstance(setting, str) else setting

    @property
    def confidence(self) -> float:
        """α; where it was learned, its mean: over draws, and over levels or candidates by their share. NaN if lost."""
        law: Any = self.settings.confidence if self.likelihood is None else self.likelihood.confidence
        if isinstance(law, Levels):
            return float(law.confidences @ law.shares)
        if isinstance(law, np.ndarray):
            return float(np.average(law, weights=self.expected_shares + 1e-300))
        return float("nan") if isinstance(law, str) else float(law)

    @property
    def background(self) -> Floats:
        """(N,) P(no subgoal is behind the observation | O)."""
        return np.clip(1 - np.asarray(self.shares.sum(axis=1)).ravel(), 0, 1)

    def to_arviz(self, *, log_likelihood: bool = False, seed: int = 0) -> Any:
        """An ArviZ ``DataTree`` (its InferenceData) with dimensions by name; needs the extra ``arviz``.

        Groups: ``posterior``, label-invariant summaries of each draw and what else was sampled; ``sample_stats``, with
        ``lp`` the log joint; ``observed_data`` and ``constant_data``; provenance as attributes of all.

        ``log_likelihood`` adds a group of that name with log p(actions of each trajectory | draw), subgoals summed out,
        so that ``arviz_stats.loo`` leaves out trajectories and not steps of time: ``seed`` draws the weights that this
        needs. It filters all demonstrations once for each draw. Raises ``InputError`` where that is no probability:
        for groups, weighted observations, and posteriors without their likelihood.
        """
        from subgoal.posterior.export import to_arviz

        return to_arviz(self, log_likelihood=log_likelihood, seed=seed)
