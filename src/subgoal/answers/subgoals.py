"""Subgoals: candidates that stand for one place merged, with their shares, probabilities and credible sets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, positive

MERGED_FROM = 0.001
"""Candidates with at least this expected share are merged into subgoals."""
LISTED_FROM = 0.01
"""Subgoals with at least this expected share stand in files and tables."""
COUNTED_FROM = 0.05
"""Subgoals with at least this share count in ``n_subgoals``."""
MERGE_RADII = 5.0
COARSE = {"Gaussian-process planning": 2.0}
"""Where the net of candidates is coarse, its radius a good part of the distance between subgoals."""
CREDIBLE = 0.95


@dataclass(frozen=True, eq=False)
class Subgoal:
    """One place the demonstrator was after.

    Attributes
    ----------
    label:
        1 for the largest expected share, and so on.
    name:
        The candidate's own name, or "subgoal 1" and so on.
    candidate, position:
        Its heaviest member, and where that lies (d,).
    share, expected_observations:
        Expected share of the observations, and E[n | O].
    share_interval:
        90 % interval of the share over the draws.
    inclusion:
        Posterior probability that it holds at least 1 % of the observations.
    prominence:
        Posterior probability that it holds at least 5 %.
    members, member_shares:
        Candidates it is merged from, by falling expected share.
    credible_set:
        The fewest members that hold 95 % of its share.
    radius:
        Largest distance from ``position`` to a place of the credible set.
    """

    label: int
    name: str
    candidate: int
    position: Floats
    share: float
    expected_observations: float
    share_interval: tuple[float, float]
    inclusion: float
    prominence: float
    members: Ints
    member_shares: Floats
    credible_set: Ints
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class Subgoals:
    """All merged subgoals of a posterior, by falling share.

    Attributes
    ----------
    items:
        Every merged subgoal, however small.
    group:
        (G,) index into ``items`` of each candidate, −1 for candidates below 0.1 %.
    merge_radius:
        Places within it (complete linkage) are one subgoal.
    counted_per_draw:
        (chain, draw) number of subgoals with at least 5 % of the observations.
    """

    items: tuple[Subgoal, ...]
    group: Ints
    merge_radius: float
    counted_per_draw: Ints

    def __repr__(self) -> str:
        return f"Subgoals({self.n_subgoals} with at least 5 % of the observations, {len(self)} with at least 1 %)"

    def __iter__(self) -> Iterator[Subgoal]:
        return iter(self.listed)

    def __len__(self) -> int:
        return len(self.listed)

    def __getitem__(self, k: int) -> Subgoal:
        return self.listed[k]

    @property
    def listed(self) -> tuple[Subgoal, ...]:
        """Those with at least 1 % of the observations in expectation."""
        return tuple(item for item in self.items if reaches(item.share, LISTED_FROM))

    @property
    def n_subgoals(self) -> int:
        """Number of subgoals with at least 5 % of the observations in expectation."""
        return sum(reaches(item.share, COUNTED_FROM) for item in self.items)

    @property
    def n_subgoals_distribution(self) -> dict[int, float]:
        """P(number of subgoals with at least 5 % of the observations = k | O)."""
        values, counts = np.unique(self.counted_per_draw, return_counts=True)
        return {int(k): float(c / self.counted_per_draw.size) for k, c in zip(values, counts, strict=True)}

    @property
    def listed_group(self) -> Ints:
        """(G,) like ``group``, with −1 for members of subgoals that are not listed."""
        return np.where(self.group < len(self.listed), self.group, -1)


def reaches(share: float, threshold: float) -> bool:
    """Whether a share is at least the threshold, sums of exact shares that round to just below included."""
    return share >= threshold * (1 - 1e-12)


def subgoals(posterior: Posterior, *, merge_radius: float | None = None) -> Subgoals:
    """Merge near-duplicate candidates once for all chains and draws, and summarise each merged place.

    Candidates with an expected share of at least 0.1 % are merged by complete linkage within ``merge_radius`` (default
    5 × ``Candidates.radius``, in continuous worlds 2 ×), whether they alternate across draws or are active in the same
    one. A merged subgoal sits at its heaviest member with the summed share.
    """
    candidates = posterior.candidates
    if merge_radius is None:
        merge_radius = COARSE.get(posterior.settings.likelihood, MERGE_RADII) * candidates.radius
    merge_radius = positive("merge_radius", merge_radius, zero=True)
    expected = posterior.expected_shares
    kept = np.flatnonzero(expected >= MERGED_FROM)
    cluster = _complete_linkage(posterior, kept, merge_radius)
    weight = np.bincount(cluster, weights=expected[kept])
    rank = np.argsort(np.argsort(-weight, kind="stable"), kind="stable")
    group = np.full(candidates.n_candidates, -1, np.int64)
    group[kept] = rank[cluster]
    per_draw = posterior.counts.by_group(group, weight.size) / posterior.n_observations
    items = tuple(_subgoal(posterior, k, group, expected, per_draw[:, k]) for k in range(weight.size))
    counted = (per_draw >= COUNTED_FROM).sum(axis=1).reshape(posterior.log_joint.shape)
    return Subgoals(items, group, merge_radius, counted)


def _complete_linkage(posterior: Posterior, kept: Ints, merge_radius: float) -> Ints:
    """(kept,) cluster numbers from 0; no cluster is wider than ``merge_radius``."""
    if kept.size <= 1:
        return np.arange(kept.size)
    points = posterior.candidates.points[kept]
    distance = posterior.candidates.metric.distance(points[:, None], points[None])
    tree = linkage(squareform(distance, checks=False), method="complete")
    return np.asarray(fcluster(tree, merge_radius, criterion="distance"), np.int64) - 1


def _subgoal(posterior: Posterior, k: int, group: Ints, expected: Floats, shares: Floats) -> Subgoal:
    candidates = posterior.candidates
    members = np.flatnonzero(group == k)
    members = members[np.argsort(-expected[members], kind="stable")]
    weights = expected[members]
    enough = int(np.searchsorted(np.cumsum(weights), CREDIBLE * weights.sum() * (1 - 1e-12))) + 1
    head = int(members[0])
    spread = candidates.metric.distance(candidates.points[head], candidates.points[members[:enough]])
    low, high = np.quantile(shares, [0.05, 0.95])
    return Subgoal(
        label=k + 1,
        name=candidates.name(head) or f"subgoal {k + 1}",
        candidate=head,
        position=candidates.points[head],
        share=float(weights.sum()),
        expected_observations=float(weights.sum() * posterior.n_observations),
        share_interval=(float(low), float(high)),
        inclusion=float((shares >= LISTED_FROM).mean()),
        prominence=float((shares >= COUNTED_FROM).mean()),
        members=members,
        member_shares=weights,
        credible_set=members[:enough],
        radius=float(spread.max()),
    )
