"""Subgoals that persist in time: kept with a probability, else redrawn from weights that all share."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal._kernels import persistence as loops
from subgoal._kernels import persistence_sweeps as whole_sweeps
from subgoal._kernels.counts import log_assignment_prior
from subgoal.partition.priors import SMALLEST_LOG, Beta, log_weights, probability_of, slice_draw
from subgoal.partition.protocol import (
    Arrays,
    Chain,
    Recorder,
    Stretch,
    Table,
    log_fit,
    refuse_lone_steps,
    relative_rows,
    starting_assignment,
)
from subgoal.partition.together import ENTRIES, SWEEPS, bytes_needed, redraw_together
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

UNIFORM = Beta()
LOGITS = 27.0
"""ρ stays within e^−27 of zero and of one."""


@dataclass(frozen=True)
class Persistent:
    """Sampler of the model in which step t keeps the subgoal of t − 1 with probability ρ and else redraws it.

    p(θ_t = g | θ_{t−1} = h) = ρ·1[g = h] + (1 − ρ)·w_g, first steps of trajectories from w, w ~ Dirichlet(ηp); with
    ρ = 0 this is the exchangeable mixture. A sweep draws w | redraws, then all subgoals and redraws at once by
    forward filtering and backward drawing, O(N·G); then, given where redraws fall, each run of one subgoal is an
    observation of the exchangeable mixture, and a sweep of ``collapsed_blocks`` over the runs follows. All exact.

    Attributes
    ----------
    keep:
        ρ, or its prior.
    keep_there:
        ρ where the state is at the current subgoal (an arrival ends a subgoal mostly); None: the same as elsewhere.
        Raises ``InputError`` if it may be above 0 while ``keep`` is 0.
    """

    keep: float | Beta = UNIFORM
    keep_there: float | Beta | None = None

    def __post_init__(self) -> None:
        probability_of("persistence", self.keep)
        if self.keep_there is not None:
            probability_of("persistence at the subgoal", self.keep_there)
        if self.keep == 0 and self.keep_there not in (None, 0):
            raise InputError("persistence", found=0, wanted="above 0, where subgoals that are arrived at may be kept")

    @property
    def __name__(self) -> str:
        return "persistent" if self.keep_there is None else "persistent until arrival"

    def refuse(self, offset: Ints) -> None:
        """Raise ``InputError`` for demonstrations that say nothing of how long subgoals last."""
        refuse_lone_steps(offset, "Persistent")

    def bytes_needed(self, n: int, g_count: int) -> float:
        """Of one chain: both tables of the runs."""
        return bytes_needed(n, g_count)

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance one chain; see ``Sampler``."""
        steps = _Steps(chain, self)
        record = Recorder(chain.table, keep)
        kept, redraws = (
            np.empty((len(record.kept), 2)),
            np.empty((len(record.kept), chain.table.n_candidates), np.int64),
        )
        if steps.in_one_loop:
            steps.sweeps(keep, record, redraws)
            kept[:] = steps.keep, steps.keep_there
        else:
            _one_by_one(steps, keep, record, kept, redraws)
        names = ("persistence", "persistence at the subgoal")[: 1 if self.keep_there is None else 2]
        return replace(
            record.stretch(steps.state()),
            parameters={name: kept[:, k].copy() for k, name in enumerate(names)}, redraws=redraws,
        )  # fmt: skip


def _one_by_one(steps: _Steps, keep: Bools, record: Recorder, kept: Floats, redraws: Ints) -> None:
    """The sweeps in Python: probabilities that are learned, or a table in several blocks. Writes the last two."""
    rows = 0
    for s in range(keep.size):
        steps.sweep()
        fit, joint = steps.log_joint()
        record.sweep(s, keep[s], steps.theta, int(np.unique(steps.theta).size), fit, joint)
        if keep[s]:
            kept[rows], redraws[rows] = (steps.keep, steps.keep_there), steps.counts
            rows += 1


class _Steps:
    """One chain between sweeps: assignment, redraws, and the two probabilities."""

    def __init__(self, chain: Chain, model: Persistent) -> None:
        table = chain.table
        self.chain, self.model, self.table = chain, model, table
        self.prior = np.exp(table.log_prior)
        self.first = np.zeros(table.n_observations, bool)
        self.first[table.offset[:-1]] = True
        self.there_from, self.there = _sparse_rows(table, model)
        state = chain.state or self._begin()
        self.theta = np.array(state["theta"], np.int32)
        self.redrawn = np.array(state["redrawn"], bool)
        self.keep, self.keep_there = (float(x) for x in state["keep"])
        self._recount()

    def _begin(self) -> Arrays:
        theta = starting_assignment(self.table, self.chain.generator)
        redrawn = self.first | (np.diff(theta, prepend=-1) != 0)
        keep = _start(self.model.keep)
        there = keep if self.model.keep_there is None else _start(self.model.keep_there)
        return {"theta": theta, "redrawn": redrawn, "keep": np.array([keep, there])}

    def state(self) -> Arrays:
        """From where the chain goes on."""
        return {
            "theta": self.theta, "redrawn": self.redrawn, "keep": np.array([self.keep, self.keep_there]),
            "counts": self.counts,
        }  # fmt: skip

    def _recount(self) -> None:
        self.counts = np.bincount(self.theta[self.redrawn], minlength=self.table.n_candidates)

    @property
    def in_one_loop(self) -> bool:
        """Whether no probability is learned, and the table is held in one block, with room for its runs."""
        known = not isinstance(self.model.keep, Beta) and not isinstance(self.model.keep_there, Beta)
        whole = self.table.relative is not None and self.table.edges.size == 2
        return known and whole and self.table.n_observations * self.prior.size <= ENTRIES

    def sweeps(self, keep: Bools, record: Recorder, redraws: Ints) -> None:
        """The sweeps of ``sweep``, draw for draw, in one compiled loop; writes what is recorded."""
        table = self.table
        whole_sweeps.sweeps_of_runs(
            table.dense, table.relative, self.first, self.there_from, self.there, self.prior, table.log_prior,
            self.chain.concentration, self.keep, self.keep_there, *self._log_ratios(), SMALLEST_LOG, SWEEPS, self.theta,
            self.redrawn, self.counts, keep, record.kept, redraws, record.log_likelihood, record.log_joint,
            record.n_active, self.chain.generator,
        )  # fmt: skip

    def sweep(self) -> None:
        """Weights, then the probabilities of keeping, then the path, then the runs."""
        weights = np.exp(log_weights(self.chain.concentration * self.prior + self.counts, self.chain.generator))
        self._draw_probabilities(weights)
        self._draw_path(weights)
        self._move_runs()
        self._recount()

    def _draw_path(self, weights: Floats) -> None:
        """Forward over all rows, keeping the law at the edges of blocks; backward with each block filtered again."""
        edges = self.table.edges
        entering = np.zeros((edges.size, weights.size))
        rows = int(np.diff(edges).max())
        filtered = np.empty((rows, weights.size))
        work = np.empty(max(weights.size, 2))
        for k in range(edges.size - 1):
            self._filter(k, weights, entering[k], filtered)
            entering[k + 1] = filtered[edges[k + 1] - edges[k] - 1]
        for k in range(edges.size - 2, -1, -1):
            if k < edges.size - 2:
                self._filter(k, weights, entering[k], filtered)
            loops.draw_rows(
                edges[k], filtered[: edges[k + 1] - edges[k]], self.first, self.there_from, self.there, weights,
                self.keep, self.keep_there, self.theta, self.redrawn, work, self.chain.generator,
            )  # fmt: skip

    def _filter(self, k: int, weights: Floats, entering: Floats, out: Floats) -> None:
        start, stop = int(self.table.edges[k]), int(self.table.edges[k + 1])
        loops.filter_rows(
            start, relative_rows(self.table, start, stop), self.first, self.there_from, self.there, weights, self.keep,
            self.keep_there, entering, out, np.empty(stop - start),
        )  # fmt: skip

    def _move_runs(self) -> None:
        """Given the redraws, runs are observations of the exchangeable mixture."""
        run = np.cumsum(self.redrawn) - 1
        theta = np.ascontiguousarray(self.theta[self.redrawn])
        self.theta = np.ascontiguousarray(redraw_together(self.chain, self.prior, run, theta, self._sums)[run])

    def _sums(self, group: Ints, count: int) -> Floats:
        """(count, G) log likelihood of each group of runs, were it each candidate, up to what is the same for all."""
        sums = np.zeros((count, self.prior.size))
        kept, left = self._log_ratios()
        for start, tile in self.table.tiles():
            loops.add_to_runs(
                start, tile, group, self.there_from, self.there, self.first, self.redrawn, kept, left, sums
            )
        return sums

    def _log_ratios(self) -> tuple[float, float]:
        """What arriving adds to the log probability of keeping, and of leaving."""
        if self.keep_there == self.keep:
            return 0.0, 0.0
        return _log_ratio(self.keep_there, self.keep), _log_ratio(1 - self.keep_there, 1 - self.keep)

    def _draw_probabilities(self, weights: Floats) -> None:
        """Given θ and the weights, with summed out whether a step that stays kept its subgoal or redrew the same."""
        repeats = np.empty((2, weights.size), np.int64)
        changes = loops.count_repeats(self.theta, self.first, self.there_from, self.there, repeats)
        model, generator = self.model, self.chain.generator
        if model.keep_there is None:
            if isinstance(model.keep, Beta):
                self.keep = draw_keep(self.keep, model.keep, repeats.sum(axis=0), sum(changes), weights, generator)
            self.keep_there = self.keep
            return
        if isinstance(model.keep, Beta):
            self.keep = draw_keep(self.keep, model.keep, repeats[0], changes[0], weights, generator)
        if isinstance(model.keep_there, Beta):
            self.keep_there = draw_keep(self.keep_there, model.keep_there, repeats[1], changes[1], weights, generator)

    def _steps(self) -> Ints:
        counts = np.empty((2, 2), np.int64)
        loops.count_steps(self.theta, self.redrawn, self.first, self.there_from, self.there, counts)
        return counts

    def log_joint(self) -> tuple[float, float]:
        """Σ ℓ[i, θ_i], and the log joint density of everything drawn but the weights, which are integrated out."""
        fit = log_fit(self.table, self.theta)
        steps = self._steps()
        value = fit + log_assignment_prior(self.counts, self.prior, self.chain.concentration)
        for number, chance in zip(steps.T, (self.keep, self.keep_there), strict=True):
            value += sum(n * math.log(p) for n, p in zip(number, (chance, 1 - chance), strict=True) if n)
        for law, chance in ((self.model.keep, self.keep), (self.model.keep_there, self.keep_there)):
            value += law.log_density(chance) if isinstance(law, Beta) else 0.0
        return fit, value


def draw_keep(
    keep: float, law: Beta, repeats: Ints, changes: int, weights: Floats, generator: np.random.Generator
) -> float:
    """ρ by a slice on its logit: steps that stay with g have probability ρ + (1 − ρ)·w_g, those that change 1 − ρ."""
    used = np.flatnonzero(repeats)
    number, weight = repeats[used], weights[used]

    def log_density(logit: float) -> float:
        if not -LOGITS < logit < LOGITS:
            return -math.inf
        rho = 1 / (1 + math.exp(-logit))
        fit = float(number @ np.log(rho + (1 - rho) * weight)) + changes * math.log1p(-rho)
        return fit + law.log_density(rho) + math.log(rho) + math.log1p(-rho)

    logit = slice_draw(log_density, math.log(keep) - math.log1p(-keep), 1.0, generator)
    return 1 / (1 + math.exp(-logit))


def _start(law: float | Beta) -> float:
    return law.start if isinstance(law, Beta) else float(law)


def _log_ratio(a: float, b: float) -> float:
    if a == 0:
        return -math.inf
    return math.log(a) - math.log(b) if b > 0 else math.inf


def _sparse_rows(table: Table, model: Persistent) -> tuple[Ints, Ints]:
    """Which observation is at which candidate; empty rows where that makes no difference."""
    if model.keep_there is None:
        return np.zeros(table.n_observations + 1, np.int64), np.empty(0, np.int64)
    there: Any = table.arrived
    return there.indptr.astype(np.int64), there.indices.astype(np.int64)


def persistent(chain: Chain, keep: Bools) -> Stretch:
    """Sampler ``Persistent()``: how long subgoals persist is learned, from a uniform prior on ρ."""
    return Persistent()(chain, keep)
