"""A hidden Markov model over the candidates: which subgoal follows which is learned, and that subgoals last."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import gammaln

from subgoal._kernels import sticky_hmm as loops
from subgoal.partition.priors import Beta, Gamma, log_weights, probability_of, slice_draw
from subgoal.partition.protocol import (
    Arrays,
    Chain,
    Recorder,
    Stretch,
    log_fit,
    refuse_lone_steps,
    relative_rows,
    starting_assignment,
)
from subgoal.partition.shared_weights import log_rows, log_shared, mass_of
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

MASS = Gamma(1.0, 0.1)
UNIFORM = Beta()
MOST_CANDIDATES = 4096
"""The transitions are a matrix of this size at most (128 MiB each, three of them)."""
WIDTH = 1.0
FARTHEST_LOG, FARTHEST_LOGIT = 60.0, 27.0


@dataclass(frozen=True)
class StickyHMM:
    """Sampler of the sticky hierarchical Dirichlet-process hidden Markov model (Fox et al. 2011) over the candidates.

    β ~ Dirichlet(γp), with γ the concentration of the chain; the law of the next subgoal after j is
    π_j ~ Dirichlet(aβ + κδ_j), that of first steps of trajectories Dirichlet(aβ). Candidates are finite in number, so
    this is exact and no truncation. A sweep draws β and the rows, then the whole path by forward filtering and backward
    drawing; then tables (how often each candidate was drawn from β), a and κ, and each candidate in use moves as a
    whole to an unused one or stays, with β and rows integrated out.

    Time per sweep is O(N·(entries of the rows above e^−600) + G²), memory O(G²).

    Attributes
    ----------
    mass:
        a + κ, or its prior: how much the rows are alike.
    stickiness:
        κ / (a + κ), or its prior; 0 is the model without stickiness.
    """

    mass: float | Gamma = MASS
    stickiness: float | Beta = UNIFORM

    def __post_init__(self) -> None:
        mass_of("mass of the rows", self.mass)
        probability_of("stickiness", self.stickiness)

    @property
    def __name__(self) -> str:
        return "sticky hidden Markov model"

    def refuse(self, offset: Ints) -> None:
        """Raise ``InputError`` for demonstrations that say nothing of which subgoal follows which."""
        refuse_lone_steps(offset, "StickyHMM")

    def bytes_needed(self, n: int, g_count: int) -> float:
        """Of one chain: counts, tables and rows of transitions among all candidates."""
        return 40.0 * g_count**2

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance one chain; see ``Sampler``. Raises ``InputError`` above 4,096 candidates."""
        walk = _Walk(chain, self)
        record = Recorder(chain.table, keep)
        kept: list[tuple[float, float]] = []
        redraws: list[Ints] = []
        for s in range(keep.size):
            walk.sweep()
            fit, joint = walk.log_joint()
            record.sweep(s, keep[s], walk.theta, int(np.count_nonzero(walk.shared)), fit, joint)
            if keep[s]:
                kept.append((walk.mass, walk.stickiness))
                redraws.append(walk.shared.copy())
        columns = np.array(kept).reshape(-1, 2)
        return replace(
            record.stretch(walk.state()),
            parameters={"row mass": columns[:, 0].copy(), "stickiness": columns[:, 1].copy()},
            redraws=np.array(redraws, np.int64).reshape(-1, chain.table.n_candidates),
        )


class _Rows(NamedTuple):
    """The transitions as ``_kernels.sticky_hmm.pack_row`` holds them."""

    length: Ints
    column: Ints
    above: Floats
    onto: Floats

    @classmethod
    def of(cls, g_count: int) -> _Rows:
        """Room for all rows."""
        square = (g_count, g_count)
        return cls(np.zeros(g_count, np.int64), np.empty(square, np.int64), np.empty(square), np.empty(square))


class _Walk:
    """One chain between sweeps: the path, how often each candidate was drawn from β, a + κ and its sticky part."""

    def __init__(self, chain: Chain, model: StickyHMM) -> None:
        table = chain.table
        self.chain, self.model, self.table = chain, model, table
        g_count = table.n_candidates
        if g_count > MOST_CANDIDATES:
            raise InputError(
                "candidates", found=g_count, wanted=f"at most {MOST_CANDIDATES} for a matrix of transitions",
                hint="fewer candidates, or the sampler Persistent",
            )  # fmt: skip
        self.prior = np.exp(table.log_prior)
        self.first = np.zeros(table.n_observations, bool)
        self.first[table.offset[:-1]] = True
        self.counts = np.zeros((g_count + 1, g_count), np.int64)
        self.tables = np.zeros((g_count + 1, g_count), np.int64)
        self.own = np.zeros(g_count, np.int64)
        self.work = np.empty(max(g_count, 2))
        self.begin = np.empty(g_count)
        self.rows = _Rows.of(g_count)
        state = chain.state or self._begin()
        self.theta = np.array(state["theta"], np.int32)
        self.shared = np.array(state["counts"], np.int64)
        self.mass, self.stickiness = (float(x) for x in state["row_mass"])

    def _begin(self) -> Arrays:
        theta = starting_assignment(self.table, self.chain.generator)
        loops.count_transitions(theta, self.first, self.counts)
        entered = self.counts > 0
        entered[np.arange(self.prior.size), np.arange(self.prior.size)] = False
        mass, stickiness = self.model.mass, self.model.stickiness
        start = mass.start if isinstance(mass, Gamma) else float(mass)
        ratio = stickiness.start if isinstance(stickiness, Beta) else float(stickiness)
        return {"theta": theta, "counts": entered.sum(axis=0), "row_mass": np.array([start, ratio])}

    def state(self) -> Arrays:
        """From where the chain goes on."""
        return {
            "theta": self.theta, "counts": self.shared, "row_mass": np.array([self.mass, self.stickiness])
        }  # fmt: skip

    @property
    def free(self) -> float:
        """a, the mass that is not sticky."""
        return self.mass * (1 - self.stickiness)

    @property
    def sticky(self) -> float:
        """κ."""
        return self.mass * self.stickiness

    def sweep(self) -> None:
        """Shared weights, rows, path, tables, the two numbers, then whole candidates."""
        weights = np.exp(self._draw_weights())
        loops.count_transitions(self.theta, self.first, self.counts)
        loops.draw_transitions(
            self.counts, weights, self.free, self.sticky, self.begin, *self.rows, self.work, self.chain.generator
        )
        self._draw_path()
        self._draw_tables(weights)
        self._draw_numbers()
        self._move_clusters()

    def _draw_weights(self) -> Floats:
        """Log β given how often each candidate was drawn from it."""
        return log_weights(self.chain.concentration * self.prior + self.shared, self.chain.generator)

    def _draw_path(self) -> None:
        """Forward over all rows, keeping the law at the edges of blocks; backward with each block filtered again."""
        edges = self.table.edges
        entering = np.zeros((edges.size, self.prior.size))
        filtered = np.empty((int(np.diff(edges).max()), self.prior.size))
        for k in range(edges.size - 1):
            self._filter(k, entering[k], filtered)
            entering[k + 1] = filtered[edges[k + 1] - edges[k] - 1]
        for k in range(edges.size - 2, -1, -1):
            if k < edges.size - 2:
                self._filter(k, entering[k], filtered)
            loops.draw_path(
                edges[k], filtered[: edges[k + 1] - edges[k]], self.first, self.rows.onto, self.theta, self.work,
                self.chain.generator,
            )  # fmt: skip

    def _filter(self, k: int, entering: Floats, out: Floats) -> float:
        start, stop = int(self.table.edges[k]), int(self.table.edges[k + 1])
        rows = self.rows
        return float(
            loops.filter_rows(
                start, relative_rows(self.table, start, stop), self.first, self.begin, rows.length, rows.column,
                rows.above, entering, out,
            )
        )  # fmt: skip

    def _draw_tables(self, weights: Floats) -> None:
        loops.count_transitions(self.theta, self.first, self.counts)
        loops.draw_tables(
            self.counts, weights, self.free, self.sticky, self.tables, self.own, self.shared, self.work,
            self.chain.generator,
        )  # fmt: skip

    def _draw_numbers(self) -> None:
        """a + κ and κ / (a + κ) given the tables, each by a slice."""
        drawn, own = int(self.shared.sum()), int(self.own.sum())
        steps = self.counts.sum(axis=1)
        later, firsts = steps[:-1][steps[:-1] > 0], int(steps[-1])

        def log_tables(mass: float, ratio: float) -> float:
            free = mass * (1 - ratio)
            value = drawn * math.log(free) + math.lgamma(free) - math.lgamma(free + firsts)
            value += own * math.log(mass * ratio) if own else 0.0
            return value + float((gammaln(mass) - gammaln(mass + later)).sum())

        mass, stickiness, generator = self.model.mass, self.model.stickiness, self.chain.generator
        if isinstance(mass, Gamma):
            prior, ratio = mass, self.stickiness

            def of_log(x: float) -> float:
                value = math.exp(x) if abs(x) < FARTHEST_LOG else math.inf
                return log_tables(value, ratio) + prior.log_density(value) + x if value < math.inf else -math.inf

            self.mass = math.exp(slice_draw(of_log, math.log(self.mass), WIDTH, generator))
        if isinstance(stickiness, Beta):
            law, total = stickiness, self.mass

            def of_logit(x: float) -> float:
                if abs(x) >= FARTHEST_LOGIT:
                    return -math.inf
                value = 1 / (1 + math.exp(-x))
                return log_tables(total, value) + law.log_density(value) + math.log(value) + math.log1p(-value)

            start = math.log(self.stickiness) - math.log1p(-self.stickiness)
            self.stickiness = 1 / (1 + math.exp(-slice_draw(of_logit, start, WIDTH, generator)))

    def _move_clusters(self) -> None:
        g_count = self.prior.size
        cluster, label = np.empty(self.theta.size, np.int64), np.empty(g_count, np.int64)
        k = loops.by_first_appearance(self.theta, np.empty(g_count, np.int64), cluster, label)
        sums = np.zeros((k, g_count))
        for start, tile in self.table.tiles():
            loops.add_rows(start, tile, cluster, sums)
        loops.move_clusters(
            sums, self.prior, self.chain.concentration, label, self.shared, self.work, self.chain.generator
        )
        self.theta = label[cluster].astype(np.int32)

    def log_joint(self) -> tuple[float, float]:
        """Σ ℓ[i, θ_i], and the log joint density of path, β, a + κ and κ / (a + κ), rows integrated out.

        β is drawn for it; its density is that of ``log_shared``.
        """
        log_beta = self._draw_weights()
        loops.count_transitions(self.theta, self.first, self.counts)
        value = log_shared(log_beta, np.flatnonzero(self.shared), self.prior, self.chain.concentration)
        value += self._log_path(np.exp(log_beta))
        if isinstance(self.model.mass, Gamma):
            value += self.model.mass.log_density(self.mass)
        if isinstance(self.model.stickiness, Beta):
            value += self.model.stickiness.log_density(self.stickiness)
        fit = log_fit(self.table, self.theta)
        return fit, fit + value

    def _log_path(self, weights: Floats) -> float:
        row, column = np.nonzero(self.counts)
        totals = np.array([self.mass, 0.0]) + np.outer(self.counts.sum(axis=1), [0.0, 1.0])
        totals[-1, 0] = self.free
        shape = self.free * weights[column] + self.sticky * (row == column)
        return log_rows(self.counts[row, column], shape, totals)
