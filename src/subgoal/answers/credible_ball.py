"""How far partitions of the posterior lie from the one that stands for them (Wade & Ghahramani 2018)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.answers.partition import PointPartition, draw_labels
from subgoal.answers.subgoals import Subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, positive
from subgoal.runtime.errors import InputError

PROBABILITY = 0.95
TIE = 1e-10
"""Distances within it, in nats, are the same."""


@dataclass(frozen=True, eq=False, repr=False)
class CredibleBall:
    """The smallest ball of partitions around a centre that holds a given share of the draws, and its extremes.

    Bounds are draws inside the ball, each partition once and its clusters numbered from the largest; several rows are
    equally extreme.

    Attributes
    ----------
    centre:
        (N,) labels of the point partition.
    radius:
        Variation of information in nats; it is at most log N.
    probability:
        Share of the draws within the radius: at least what was asked for, more where distances are tied.
    distance:
        (draws,) of every draw from the centre, in the order of ``Posterior.assignments``.
    horizontal:
        (H, N) the partitions of the ball that lie farthest from the centre.
    upper:
        (U, N) those of fewest clusters, and of these the farthest: how much could be merged.
    lower:
        (L, N) those of most clusters, and of these the farthest: how much could be split.
    """

    centre: Ints
    radius: float
    probability: float
    distance: Floats
    horizontal: Ints
    upper: Ints
    lower: Ints

    def __repr__(self) -> str:
        few, many = self.upper.max(initial=0) + 1, self.lower.max(initial=0) + 1
        held = f"{self.probability:.1%} of the draws within {self.radius:.3g} nats"
        return f"CredibleBall({held}, {few} to {many} clusters)"


def credible_ball(
    posterior: Posterior, point: PointPartition | Ints, found: Subgoals | None = None, *,
    probability: float = PROBABILITY,
) -> CredibleBall:  # fmt: skip
    """The credible ball of a point partition in the variation of information (Wade & Ghahramani 2018).

    Parameters
    ----------
    point:
        From ``point_partition``, or (N,) labels.
    found:
        Merged subgoals, the same as the point partition was made with.
    probability:
        Share of the draws that the ball holds at least, above 0 and at most 1.

    The bounds are over the partitions that were drawn, not over all there are; a rare one may be missing, and every
    draw counts the same. Raises ``InputError`` where the assignments were not kept, and for labels that do not fit.
    """
    share = positive("probability", probability)
    if share > 1:
        raise InputError("probability", found=share, wanted="above 0 and at most 1")
    draws, centre = draw_labels(posterior, found), _centre(point, posterior.n_observations)
    distance = distances(centre, draws)
    enough = int(np.ceil(share * distance.size * (1 - 1e-12)))
    radius = float(np.sort(distance)[enough - 1])
    inside = np.flatnonzero(distance <= radius + TIE)
    ball = draws[inside]
    clusters = np.array([np.unique(row).size for row in ball])
    return CredibleBall(
        centre=centre,
        radius=radius,
        probability=inside.size / distance.size,
        distance=distance,
        horizontal=_farthest(ball, distance[inside]),
        upper=_farthest(ball[clusters == clusters.min()], distance[inside][clusters == clusters.min()]),
        lower=_farthest(ball[clusters == clusters.max()], distance[inside][clusters == clusters.max()]),
    )


def distances(centre: Ints, draws: Ints) -> Floats:
    """(T,) variation of information in nats between labels ``centre`` (N,) and each row of ``draws`` (T, N).

    VI = (Σ_a n_a log n_a + Σ_b m_b log m_b − 2 Σ_ab n_ab log n_ab) / N, n_ab the size of cluster a ∩ b.
    """
    counts = np.arange(centre.size + 1, dtype=float)
    weight = counts * np.log(np.where(counts > 0, counts, 1.0))
    least = int(draws.min())
    width = int(draws.max()) - least + 1
    own = weight[np.bincount(centre)].sum()
    found = np.empty(len(draws))
    for k, row in enumerate(draws):
        shifted = row.astype(np.int64) - least
        shared = weight[np.bincount(centre * width + shifted)].sum()
        found[k] = own + weight[np.bincount(shifted)].sum() - 2 * shared
    return np.asarray(np.maximum(found / centre.size, 0.0))


def _centre(point: PointPartition | Ints, count: int) -> Ints:
    labels = np.asarray(point.labels if isinstance(point, PointPartition) else point)
    if labels.shape != (count,) or labels.dtype.kind not in "iu":
        found = f"{labels.dtype} of shape {labels.shape}"
        raise InputError("point", found=found, wanted=f"a PointPartition, or ({count},) whole numbers")
    return _by_size(labels)


def _farthest(ball: Ints, distance: Floats) -> Ints:
    """The partitions of the largest distance, each once."""
    far = ball[distance >= distance.max() - TIE]
    return np.unique([_by_size(row) for row in far], axis=0)


def _by_size(labels: Ints) -> Ints:
    """The same partition, numbered from the largest cluster; of equal ones that which comes first."""
    _, first, inverse, sizes = np.unique(labels, return_index=True, return_inverse=True, return_counts=True)
    rank = np.empty(sizes.size, np.int64)
    rank[np.lexsort((first, -sizes))] = np.arange(sizes.size)
    return rank[inverse]
