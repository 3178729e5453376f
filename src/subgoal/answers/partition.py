"""Which observations belong together: co-clustering, and one partition to stand for the posterior."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from subgoal._kernels.partitions import best_merger, count_together, cross_counts, move_singles, mutual_sum
from subgoal.answers.subgoals import Subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, positive, whole
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.executor import run_all, worker_count

MEMORY_BUDGET = 2**31
MOST_CLUSTERS = 40
"""Cuts of the tree go up to so many clusters."""
STARTS = 4
"""So many of the best candidates are improved by moves."""
MOST_ROUNDS = 200
SPARE = 8
"""Empty clusters that a pass of moves may open."""
BLOCK = 64


@dataclass(frozen=True, eq=False)
class PointPartition:
    """The partition that is closest to the posterior on average.

    Attributes
    ----------
    labels:
        (N,) cluster of each observation, 0 for the largest and so on.
    expected_vi:
        Mean variation of information between it and the draws, in nats; 0 if all draws are this partition.
    """

    labels: Ints
    expected_vi: float

    @property
    def n_clusters(self) -> int:
        """Number of clusters."""
        return int(self.labels.max()) + 1


def co_clustering(
    posterior: Posterior, found: Subgoals | None = None, *, memory_budget: float = MEMORY_BUDGET
) -> Floats:
    """(N, N) P(θ_i and θ_j are in the same merged subgoal | O).

    Parameters
    ----------
    found:
        Merged subgoals; a candidate that is in none of them stands for itself. None: candidates as they are.
    memory_budget:
        Bytes; a matrix above it is refused.

    Raises
    ------
    InputError
        The assignments were not kept.
    BudgetError
        The matrix would be above the budget.
    """
    labels = draw_labels(posterior, found)
    n = labels.shape[1]
    needed = 8.0 * n * n + 4.0 * labels.size
    if needed > positive("memory_budget", memory_budget):
        raise BudgetError("co-clustering", needed=needed, budget=memory_budget,
                          hint="fewer observations, for example with thin=, or a larger memory_budget")  # fmt: skip
    columns = np.ascontiguousarray(labels.T)
    out = np.empty((n, n))
    jobs = [(columns, start, min(start + BLOCK, n), out) for start in range(0, n, BLOCK)]
    run_all(count_together, jobs, workers=worker_count(None))
    out /= labels.shape[0]
    return out


def point_partition(
    posterior: Posterior,
    found: Subgoals | None = None,
    *,
    draws: int = 500,
    candidates: int = 200,
    memory_budget: float = MEMORY_BUDGET,
) -> PointPartition:
    """The partition of least expected variation of information (Wade & Ghahramani 2018).

    Tried are ``candidates`` visited draws and the cuts of an average-linkage tree of 1 − co-clustering, each against
    ``draws`` draws spread over the chains; the best few are then improved by moving single observations and merging
    clusters while that helps. A local minimum, better than or equal to every partition tried.

    Raises
    ------
    InputError, BudgetError
        As ``co_clustering``.
    """
    together = co_clustering(posterior, found, memory_budget=memory_budget)
    everything = draw_labels(posterior, found)
    against = _compact(_spread(everything, whole("draws", draws)))
    problem = _Problem.of(against)
    tried = _compact(_spread(everything, whole("candidates", candidates)))
    starts = np.unique(np.concatenate([tried, *([cut] for cut in _tree_cuts(together))]), axis=0)
    scores = [problem.expected_vi(labels) for labels in starts]
    first = np.argsort(scores, kind="stable")[:STARTS]
    _refuse_contingency(problem, int(starts[first].max()) + 1, memory_budget)
    best = [problem.improve(starts[k]) for k in first]
    scores = [problem.expected_vi(labels) for labels in best]
    k = int(np.argmin(scores))
    return PointPartition(_by_size(best[k]), max(0.0, scores[k]))


def variation_of_information(first: Ints, second: Ints) -> float:
    """VI between two partitions of the same things, given as labels (N,), in nats: a metric."""
    if len(first) != len(second):
        raise InputError("partitions", found=f"{len(first)} and {len(second)} labels", wanted="as many in both")
    both = _compact(np.stack([first, second]))
    return max(0.0, _Problem.of(both[:1]).expected_vi(both[1]))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Expected VI = (Σ_a n_a log n_a + E Σ_b m_b log m_b − 2 E Σ_ab n_ab log n_ab) / N against fixed draws (T, N)."""

    draws: Ints
    widest: int
    weight: Floats
    constant: float

    @classmethod
    def of(cls, draws: Ints) -> _Problem:
        """Draws must be compact: labels 0..L−1."""
        counts = np.arange(draws.shape[1] + 2, dtype=float)
        weight = counts * np.log(np.where(counts > 0, counts, 1.0))
        constant = float(np.mean([weight[np.bincount(row)].sum() for row in draws]))
        return cls(draws, int(draws.max()) + 1, weight, constant)

    def expected_vi(self, labels: Ints) -> float:
        """Mean over the draws, in nats."""
        sizes = np.bincount(labels)
        shared = mutual_sum(labels, self.draws, sizes.size, self.widest, self.weight) / len(self.draws)
        return float(self.weight[sizes].sum() + self.constant - 2 * shared) / labels.size

    def improve(self, start: Ints) -> Ints:
        """Greedy moves of single things and mergers of clusters until none helps."""
        labels = start.copy()
        for _ in range(MOST_ROUNDS):
            labels = _in_order(labels)
            sizes = np.bincount(labels, minlength=int(labels.max()) + 1 + SPARE)
            cross = cross_counts(labels, self.draws, sizes.size, self.widest)
            if move_singles(labels, sizes, cross, self.draws, self.weight) > 0:
                continue
            change, kept, merged = best_merger(sizes, cross, self.weight)
            if not change < 0:
                break
            labels[labels == merged] = kept
        return _in_order(labels)


def _refuse_contingency(problem: _Problem, clusters: int, budget: float) -> None:
    """Raise ``BudgetError`` when the table of (draws, labels, clusters) counts would be above the budget."""
    needed = 4.0 * len(problem.draws) * problem.widest * (clusters + SPARE)
    if needed > budget:
        raise BudgetError("point partition", needed=needed, budget=budget, hint="fewer draws=, or merged subgoals")


def draw_labels(posterior: Posterior, found: Subgoals | None) -> Ints:
    """(chains × draws, N) merged subgoal, or candidate, of each observation in each draw; −1 for the background.

    A candidate that is in no merged subgoal is numbered after them. Raises ``InputError`` without assignments.
    """
    if posterior.assignments is None:
        raise InputError("posterior.assignments", found="None: they were not kept",
                         wanted="the draws of every observation",
                         hint="sample again with a larger memory_budget, or fewer draws")  # fmt: skip
    flat = posterior.assignments.reshape(-1, posterior.n_observations)
    if found is None:
        return np.asarray(flat, np.int32)
    own = np.arange(found.group.size) + len(found.items)
    merged = np.where(found.group >= 0, found.group, own).astype(np.int32)
    return np.where(flat >= 0, merged[flat], -1)


def _spread(labels: Ints, most: int) -> Ints:
    """At most ``most`` rows, evenly spaced."""
    rows = np.unique(np.linspace(0, len(labels) - 1, min(most, len(labels))).round().astype(int))
    return np.asarray(labels[rows])


def _compact(rows: Ints) -> Ints:
    """Each row relabelled 0, 1, ... in order of first appearance."""
    return np.stack([_in_order(row) for row in rows])


def _in_order(row: Ints) -> Ints:
    _, first, inverse = np.unique(row, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[inverse], np.int64)


def _by_size(labels: Ints) -> Ints:
    sizes = np.bincount(labels)
    return np.asarray(np.argsort(np.argsort(-sizes, kind="stable"), kind="stable")[labels])


def _tree_cuts(together: Floats) -> Iterator[Ints]:
    """Cuts of the average-linkage tree of 1 − co-clustering, one for each number of clusters."""
    from scipy.cluster.hierarchy import cut_tree, linkage
    from scipy.spatial.distance import squareform

    n = len(together)
    if n == 1:
        yield np.zeros(1, np.int64)
        return
    tree = linkage(squareform(1.0 - together, checks=False), method="average")
    for column in cut_tree(tree, n_clusters=np.arange(1, min(n, MOST_CLUSTERS) + 1)).T:
        yield _in_order(column)
