"""Segments: which part of each trajectory serves which subgoal, and how sure that is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from subgoal.answers.partition import draw_labels
from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, Ints

OTHER = -1


@dataclass(frozen=True)
class Segment:
    """A maximal run of observations of one trajectory that serve one subgoal.

    ``start`` and ``stop`` are rows of the demonstrations (stop excluded), ``begin`` and ``end`` their times;
    ``subgoal`` indexes ``Subgoals.listed``, −1 for anything else; ``probability`` is the mean over the run of
    P(θ_i in it | O).
    """

    trajectory: int
    start: int
    stop: int
    begin: float
    end: float
    subgoal: int
    probability: float


@dataclass(frozen=True, eq=False, repr=False)
class Segments:
    """All segments in order.

    Attributes
    ----------
    items:
        The segments.
    labels:
        (N,) index into ``Subgoals.listed`` of the subgoal of each observation, −1 for none of them.
    probability:
        (N, S + 1) P(observation i serves listed subgoal k | O); the last column is everything else.
    boundary:
        (N,) P(observation i serves another subgoal than the one before it in its trajectory | O); 1 at the first of a
        trajectory, so that the sum is the expected number of segments. None where the assignments were not kept.
    """

    items: tuple[Segment, ...]
    labels: Ints
    probability: Floats
    boundary: Floats | None = None

    def __repr__(self) -> str:
        return f"Segments({len(self)} over {self.labels.size} observations)"

    def __iter__(self) -> Iterator[Segment]:
        return iter(self.items)

    def __len__(self) -> int:
        return len(self.items)


def subgoal_probabilities(posterior: Posterior, found: Subgoals) -> Floats:
    """(N, S + 1) P(θ_i in listed subgoal k | O), everything else in the last column."""
    listed = found.listed_group
    used = np.flatnonzero(listed >= 0)
    shape = (listed.size, len(found.listed))
    indicator = sparse.csr_array((np.ones(used.size), (used, listed[used])), shape=shape)
    inside = np.asarray((posterior.shares @ indicator).todense())
    return np.column_stack([inside, np.clip(1 - inside.sum(axis=1), 0, 1)])


def segments(posterior: Posterior, found: Subgoals | None = None) -> Segments:
    """Cut every trajectory into maximal runs of its most probable subgoal.

    Observations that say nothing (too slow, or with one legal action) go with the run they are in, and count in its
    length but not in its probability.
    """
    found = subgoals(posterior) if found is None else found
    probability = subgoal_probabilities(posterior, found)
    demos = posterior.demonstrations
    best = probability.argmax(axis=1)
    silent = np.asarray(posterior.uninformative)
    items = []
    for d in range(demos.n_trajectories):
        a, b = int(demos.offset[d]), int(demos.offset[d + 1])
        best[a:b] = _carried(best[a:b], silent[a:b])
        edges = np.flatnonzero(np.diff(best[a:b])) + 1
        for start, stop in zip([a, *(edges + a)], [*(edges + a), b], strict=True):
            speaking = np.flatnonzero(~silent[start:stop]) + start
            rows = speaking if speaking.size else np.arange(start, stop)
            chance = float(probability[rows, best[start]].mean())
            begin, end = (float(start), float(stop - 1)) if demos.times is None else demos.times[[start, stop - 1]]
            label = int(best[start]) if best[start] < len(found.listed) else OTHER
            items.append(Segment(d, int(start), int(stop), float(begin), float(end), label, chance))
    labels = np.where(best < len(found.listed), best, OTHER)
    boundary = None if posterior.assignments is None else boundaries(posterior, found)
    return Segments(tuple(items), labels, probability, boundary)


def boundaries(posterior: Posterior, found: Subgoals | None = None) -> Floats:
    """(N,) P(observation i serves another subgoal than the one before it in its trajectory | O), from the draws.

    Candidates that are merged into one subgoal are the same, so that a draw that goes from one to its near-duplicate
    has no boundary there; a candidate that is in no subgoal stands for itself, and the background too. Observations
    that say nothing are passed over in every draw: none is a boundary, and the next one that speaks is compared with
    the last that spoke. The first of a trajectory has 1.

    Raises ``InputError`` where the assignments were not kept.
    """
    labels = draw_labels(posterior, subgoals(posterior) if found is None else found)
    offset, silent = posterior.demonstrations.offset, np.asarray(posterior.uninformative)
    spoken = np.flatnonzero(~silent)
    trajectory = posterior.demonstrations.trajectory[spoken]
    later = np.flatnonzero(np.diff(trajectory) == 0) + 1
    changes = np.zeros(later.size, np.int64)
    for theta in labels:
        own = theta[spoken]
        changes += own[later] != own[later - 1]
    chance = np.zeros(silent.size)
    chance[spoken[later]] = changes / len(labels)
    chance[offset[:-1]] = 1.0
    return chance


def _carried(labels: Ints, silent: Bools) -> Ints:
    """Labels in which silent observations take the label of the last one that spoke (or the first that will)."""
    spoke = np.where(silent, -1, np.arange(labels.size))
    last = np.maximum.accumulate(spoke)
    if (last < 0).all():
        return labels
    first = int(np.argmax(last >= 0))
    return labels[np.where(last < 0, first, last)]
