"""How much each group of trajectories (an animal, a driver, a day) serves each subgoal, and where groups differ."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError

INTERVAL = (0.05, 0.95)


@dataclass(frozen=True, eq=False, repr=False)
class GroupShares:
    """Shares of K groups in S listed subgoals, over all draws.

    Subgoals are merged places, so that nothing here hangs on labels. Shares of a group need not sum to one: what is
    left serves places that are not listed, or none.

    Attributes
    ----------
    subgoals:
        The subgoals; columns below are ``subgoals.listed`` in order.
    sizes:
        (K,) observations of each group.
    share, interval:
        (K, S) expected share of the observations of a group that serve a subgoal, and its 90 % interval (K, S, 2).
    pairs:
        (P, 2) every two groups, the lower number first.
    difference, difference_interval:
        (P, S) expected share of the first of a pair less that of the second, and its 90 % interval (P, S, 2).
    larger:
        (P, S) posterior probability that the share of the first is larger, plus half of that that they are equal.
    per_draw:
        (chain, draw, K, S) the shares in each draw.
    """

    subgoals: Subgoals
    sizes: Ints
    share: Floats
    interval: Floats
    pairs: Ints
    difference: Floats
    difference_interval: Floats
    larger: Floats
    per_draw: Floats

    def __repr__(self) -> str:
        return f"GroupShares({self.sizes.size} groups, {self.share.shape[1]} subgoals)"


def group_shares(posterior: Posterior, group: Any, found: Subgoals | None = None) -> GroupShares:
    """Share of each listed subgoal in each group, and the differences between every two groups.

    Parameters
    ----------
    posterior:
        From any sampler. That of ``Grouped`` lets groups differ beforehand; others pull them together.
    group:
        (D,) number of the group of each trajectory; every number from 0 to the largest occurs.
    found:
        The merged subgoals; made from the posterior if not given.

    Raises ``InputError`` where assignments were not kept, and for groups that are not such numbers.
    """
    if posterior.assignments is None:
        raise InputError(
            "posterior", found="no assignments, which were above the memory budget", wanted="kept assignments",
            hint="fewer draws, or a larger memory budget",
        )  # fmt: skip
    found = subgoals(posterior) if found is None else found
    own = _group_of_observations(posterior, group)
    sizes = np.bincount(own)
    n_columns = len(found.listed)
    column = np.append(found.listed_group, -1)
    draws = posterior.assignments.reshape(-1, own.size)
    shares = np.empty((len(draws), sizes.size, n_columns))
    for row, theta in zip(shares, draws, strict=True):
        cell = own * (n_columns + 1) + column[theta] + 1
        counts = np.bincount(cell, minlength=sizes.size * (n_columns + 1)).reshape(sizes.size, -1)
        row[:] = counts[:, 1:] / sizes[:, None]
    pairs = np.array(list(combinations(range(sizes.size), 2)), np.int64).reshape(-1, 2)
    first, second = shares[:, pairs[:, 0]], shares[:, pairs[:, 1]]
    return GroupShares(
        subgoals=found,
        sizes=sizes,
        share=shares.mean(axis=0),
        interval=_interval(shares),
        pairs=pairs,
        difference=(first - second).mean(axis=0),
        difference_interval=_interval(first - second),
        larger=(first > second).mean(axis=0) + 0.5 * (first == second).mean(axis=0),
        per_draw=shares.reshape(*posterior.assignments.shape[:2], *shares.shape[1:]),
    )


def _interval(values: Floats) -> Floats:
    """(..., 2) quantiles over the draws (first axis)."""
    return np.moveaxis(np.quantile(values, INTERVAL, axis=0), 0, -1)


def _group_of_observations(posterior: Posterior, group: Any) -> Ints:
    """(N,) group of each observation, checked."""
    demos = posterior.demonstrations
    given = np.asarray(group)
    if given.shape != (demos.n_trajectories,) or given.dtype.kind not in "iu":
        wanted = f"whole numbers of shape ({demos.n_trajectories},), one for each trajectory"
        raise InputError("group", found=f"{given.dtype} of shape {given.shape}", wanted=wanted)
    if given.min() < 0:
        where = int(np.argmax(given < 0))
        raise InputError("group", where=f"trajectory {where}", found=int(given[where]), wanted="a number from 0")
    if given.max() >= given.size:
        where = int(np.argmax(given))
        raise InputError(
            "group", where=f"trajectory {where}", found=int(given[where]),
            wanted=f"a number below {given.size}, there being {given.size} trajectories",
        )  # fmt: skip
    empty = np.flatnonzero(np.bincount(given) == 0)
    if empty.size:
        raise InputError("group", found=f"no trajectory of group {empty[0]}", wanted="every number from 0 in use")
    return np.asarray(given[demos.trajectory], np.int64)
