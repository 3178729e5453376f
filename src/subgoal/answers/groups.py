"""How much each group of trajectories (an animal, a driver, a day) serves each subgoal, and where groups differ."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from subgoal.answers.subgoals import Subgoals, subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, Ints, copied
from subgoal.runtime.errors import InputError

INTERVAL = (0.05, 0.95)


@dataclass(frozen=True, eq=False, repr=False)
class GroupShares:
    """Shares of K groups in S listed subgoals, over all draws.

    Subgoals are merged places, so that nothing here hangs on labels. Shares of a group need not sum to one: what is
    left serves places that are not listed, or none. Printed, it is a table of shares and one of differences.

    Attributes
    ----------
    subgoals:
        The subgoals; columns below are ``subgoals.listed`` in order.
    names:
        The K groups.
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
    names: tuple[str, ...]
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

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def lines(self) -> list[str]:
        """The shares in percent with their 90 % intervals, then the differences, one line for each subgoal of each."""
        told = ["share of each group in %, with 90 % intervals"]
        for k, name in enumerate(self.names):
            for s, goal in enumerate(self.subgoals.listed):
                told.append(f"  {name}: {goal.name:<12} {_percent(self.share[k, s], self.interval[k, s])}")
        told += ["differences in percentage points"] if len(self.pairs) else []
        for p, (a, b) in enumerate(self.pairs.tolist()):
            for s, goal in enumerate(self.subgoals.listed):
                gap = _percent(self.difference[p, s], self.difference_interval[p, s])
                sure = "" if self.differs[p, s] else "  (may be none)"
                told.append(f"  {self.names[a]} − {self.names[b]}: {goal.name:<12} {gap}{sure}")
        return told

    @property
    def differs(self) -> Bools:
        """(P, S) whether the 90 % interval of a difference leaves zero out."""
        low, high = np.moveaxis(self.difference_interval, -1, 0)
        return np.asarray((low > 0) | (high < 0))


def group_shares(posterior: Posterior, group: Any = None, found: Subgoals | None = None) -> GroupShares:
    """Share of each listed subgoal in each group, and the differences between every two groups.

    Parameters
    ----------
    posterior:
        From any sampler. That of ``Grouped`` lets groups differ beforehand; others pull them together.
    group:
        (D,) group of each trajectory: names, or numbers of which every one from 0 to the largest occurs. By default
        those of the demonstrations (``read(..., group="animal")``).
    found:
        The merged subgoals; made from the posterior if not given.

    Raises ``InputError`` where assignments were not kept, for groups that are not such, and where there are none.
    """
    if posterior.assignments is None:
        raise InputError(
            "posterior", found="no assignments, which were above the memory budget", wanted="kept assignments",
            hint="fewer draws, or a larger memory budget",
        )  # fmt: skip
    found = subgoals(posterior) if found is None else found
    number, names = _numbered(posterior, group)
    own = _group_of_observations(posterior, number)
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
        names=names or tuple(map(str, range(sizes.size))),
        sizes=sizes,
        share=shares.mean(axis=0),
        interval=_interval(shares),
        pairs=pairs,
        difference=(first - second).mean(axis=0),
        difference_interval=_interval(first - second),
        larger=(first > second).mean(axis=0) + 0.5 * (first == second).mean(axis=0),
        per_draw=shares.reshape(*posterior.assignments.shape[:2], *shares.shape[1:]),
    )


def _percent(value: float, interval: Floats) -> str:
    low, high = (100 * interval).tolist()
    return f"{100 * value:6.1f}  [{low:.1f}, {high:.1f}]"


def _numbered(posterior: Posterior, group: Any) -> tuple[Any, tuple[str, ...]]:
    """Numbers of groups, and their names where these are known."""
    demos = posterior.demonstrations
    if group is None:
        return demos.group, demos.group_names
    given = copied("group", group)
    if given.dtype.kind != "U" or given.ndim != 1:
        return given, ()
    names, number = np.unique(given, return_inverse=True)
    return number.astype(np.int64), tuple(names.tolist())


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
