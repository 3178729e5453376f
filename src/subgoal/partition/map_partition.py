"""The likeliest assignment of observations to candidates that a search finds, and how far from the best it may be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.partition.convex_weights import ConvexWeights, convex_weights
from subgoal.partition.local_search import Search
from subgoal.partition.map_bound import upper_bound
from subgoal.partition.outcome import Outcome
from subgoal.partition.protocol import Int32s, Table
from subgoal.partition.row_blocks import over_rows, prior_mass
from subgoal.partition.score_test import score_test
from subgoal.runtime.checks import Floats, Ints, frozen, whole
from subgoal.runtime.errors import InputError
from subgoal.runtime.interrupt import Interrupt
from subgoal.runtime.progress import Progress, Silent
from subgoal.runtime.seeds import stream

PROVED = 1e-9


@dataclass(frozen=True, eq=False)
class MapPartition:
    """An assignment, its log joint and a bound on that of every other.

    Attributes
    ----------
    assignment:
        (N,) candidate of each observation.
    counts:
        (G,) observations of each candidate.
    log_joint:
        log p(θ, O) in nats, weights integrated out.
    log_likelihood:
        Σ_i ℓ_iθ in nats.
    upper_bound:
        No assignment has a greater log joint.
    starts:
        (starts,) log joint at which the search from each start ended.
    outcome:
        CONVERGED: no move gains, from any start. That is a local optimum, and the global one if ``proved``.
    """

    assignment: Int32s
    counts: Ints
    log_joint: float
    log_likelihood: float
    upper_bound: float
    starts: Floats
    outcome: Outcome

    @property
    def gap(self) -> float:
        """Nats by which some other assignment might be better, at most."""
        return max(self.upper_bound - self.log_joint, 0.0)

    @property
    def proved(self) -> bool:
        """Whether the bound shows that nothing is better (by more than 1e-9 nats an observation)."""
        return self.gap <= PROVED * self.assignment.size


def map_partition(
    table: Table,
    concentration: float,
    *,
    start: Any = None,
    seed: int = 0,
    restarts: int = 4,
    bound_steps: int = 300,
    progress: Progress | None = None,
) -> MapPartition:
    """Maximise log p(θ, O) = Σ_i ℓ_iθ + log Dirichlet-multinomial(n; ηp) by local search from several starts.

    Parameters
    ----------
    table:
        N × G log densities and log P(g).
    concentration:
        η above 0.
    start:
        (N,) candidates to begin from. None begins twice: from the convex weights, and from the best single candidate
        if there is one that is possible throughout.
    seed, restarts:
        That many more starts, at the likeliest assignment under random weights: start k hangs on the seed and k alone.
    bound_steps:
        Steps of the Lagrangian bound at most (``map_bound``).
    progress:
        Told the starts.

    Raises ``InputError`` for an observation that no candidate allows, and for a start that is none or impossible.
    """
    mass, more = prior_mass(table, concentration), whole("restarts", restarts, least=0)
    steps, seed = whole("bound_steps", bound_steps), whole("seed", seed, least=0)
    convex = convex_weights(table)
    begins = _beginnings(table, convex) if start is None else [_checked_start(table, start)]
    begins += [_likeliest(table, np.log(stream(seed, k).standard_exponential(mass.size))) for k in range(more)]
    values, best, outcome = [], None, Outcome.CONVERGED
    with Interrupt() as interrupt, progress or Silent() as display:
        for done, theta in enumerate(begins, 1):
            search = Search(table, mass, theta)
            settled = search.run(interrupt)
            values.append(search.log_joint())
            if best is None or values[-1] > max(values[:-1]):
                best = search
            display.update(done, len(begins), f"log joint {max(values):.6g} nats")
            if not settled:
                outcome = Outcome.INTERRUPTED
                break
        bound = upper_bound(table, mass, convex, max(values), steps, interrupt)
    if best is None:
        raise InputError("start", found="none", wanted="at least one start")
    return MapPartition(
        assignment=frozen(best.theta), counts=frozen(best.counts), log_joint=max(values),
        log_likelihood=best.log_likelihood(), upper_bound=bound, starts=frozen(np.array(values)), outcome=outcome,
    )  # fmt: skip


def _likeliest(table: Table, log_weight: Floats) -> Int32s:
    """(N,) argmax_g ℓ_ig + log_weight_g."""
    parts = over_rows(table, lambda _, tile: (tile + log_weight).argmax(axis=1))
    return np.concatenate(parts).astype(np.int32)


def _beginnings(table: Table, convex: ConvexWeights) -> list[Int32s]:
    with np.errstate(divide="ignore"):
        begins = [_likeliest(table, np.log(convex.weights))]
    single = score_test(table).best
    if single is not None:
        begins.append(np.full(table.n_observations, single, np.int32))
    return begins


def _checked_start(table: Table, start: Any) -> Int32s:
    given = np.asarray(start)
    n, g_count = table.n_observations, table.n_candidates
    if given.shape != (n,) or given.dtype.kind not in "iu" or not ((given >= 0) & (given < g_count)).all():
        raise InputError("start", found=f"{given.dtype} of shape {given.shape}",
                         wanted=f"{n} whole numbers from 0 to {g_count - 1}")  # fmt: skip
    theta = given.astype(np.int32)
    own = np.concatenate(over_rows(table, lambda a, tile: tile[np.arange(len(tile)), theta[a : a + len(tile)]]))
    if not np.isfinite(own).all():
        i = int(np.argmax(~np.isfinite(own)))
        raise InputError("start", where=f"observation {i}", found=f"candidate {theta[i]}, of log density {own[i]}",
                         wanted="a possible candidate")  # fmt: skip
    return theta
