"""Seatings of the Chinese restaurant, one move at a time: what the mixture samplers are made of.

One update of point i is ``leave(i)``, one draw from ``law(i)``, ``join(i, choice)``. The samplers and the exact
tests go through the same three steps.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import InputError


class Base(Protocol):
    """The law of one cluster, known through summed statistics: s numbers a cluster, p numbers a parameter.

    A finite base fits too: its statistics are the rows of the likelihood table, its marginal a log-sum-exp.
    """

    def statistics(self, points: Any) -> Floats:
        """(n, s) statistics of single points (n, d); a cluster's are the sum over its points."""

    def log_marginal_of(self, totals: Floats) -> Floats:
        """(K,) log density of each cluster's points, parameters integrated out, from totals (K, s)."""

    def draw_given(self, totals: Floats, generator: np.random.Generator) -> Floats:
        """(K, p) parameters from the posterior given totals (K, s); a row of zeros means the prior."""

    def log_likelihood(self, points: Floats, parameters: Floats) -> Floats:
        """(n, K) log density of each point under each of K parameters (K, p)."""


class Tables:
    """Who sits where, and rows of what a sampler keeps about each open table; tables empty out at once."""

    def __init__(self, label: Ints, **rows: Floats) -> None:
        self.label, self.size = label.copy(), int(label.max()) + 1
        self.count = np.bincount(label).astype(np.float64)
        self.rows = rows

    def leave(self, i: int) -> dict[str, Floats] | None:
        """Point ``i`` gets up; the rows of its table if that made it close, else None."""
        table = int(self.label[i])
        self.label[i] = -1
        self.count[table] -= 1
        if self.count[table] > 0:
            return None
        closed = {name: values[table].copy() for name, values in self.rows.items()}
        last = self.size - 1
        for values in (self.count, *self.rows.values()):
            values[table] = values[last]
        self.label[self.label == last] = table
        self.size = last
        return closed

    def join(self, i: int, table: int, **new: Floats) -> None:
        """Point ``i`` sits down; ``table == size`` opens one with the rows ``new``."""
        if table == self.size:
            if table == self.count.size:
                self.count = np.concatenate([self.count, np.zeros_like(self.count)])
                self.rows = {name: np.concatenate([old, np.zeros_like(old)]) for name, old in self.rows.items()}
            self.count[table] = 0.0
            for name, row in new.items():
                self.rows[name][table] = row
            self.size += 1
        self.label[i] = table
        self.count[table] += 1


class Collapsed:
    """State of the collapsed sampler (Neal 2000, Algorithm 3): labels and the summed statistics of each table."""

    def __init__(self, points: Floats, base: Base, label: Ints, eta: float) -> None:
        self.base, self.eta, self.statistic = base, eta, base.statistics(points)
        totals = summed(self.statistic, label)
        self.tables = Tables(label, totals=totals, log_marginal=base.log_marginal_of(totals))
        self.alone = base.log_marginal_of(self.statistic)

    def leave(self, i: int) -> None:
        """Take point ``i`` out of its cluster."""
        table = int(self.tables.label[i])
        if self.tables.leave(i) is None:
            totals = self.tables.rows["totals"][table : table + 1]
            totals -= self.statistic[i]
            self.tables.rows["log_marginal"][table] = self.base.log_marginal_of(totals)[0]

    def law(self, i: int) -> Floats:
        """(K + 1,) log weights of the clusters for point ``i``, a new one last (Neal's equation 3.7)."""
        k, rows = self.tables.size, self.tables.rows
        self.joined = self.base.log_marginal_of(rows["totals"][:k] + self.statistic[i])
        weight = np.log(self.tables.count[:k]) + self.joined - rows["log_marginal"][:k]
        return np.append(weight, np.log(self.eta) + self.alone[i])

    def join(self, i: int, table: int) -> None:
        """Put point ``i``, whose ``law`` was asked for last, into cluster ``table``; K opens a new one."""
        opened, rows = table == self.tables.size, self.tables.rows
        self.tables.join(i, table, totals=self.statistic[i], log_marginal=self.alone[i])
        if not opened:
            rows["totals"][table] += self.statistic[i]
            rows["log_marginal"][table] = self.joined[table]


class Uncollapsed:
    """State of the samplers that keep each table's parameter (Neal 2000, Algorithm 8; thesis Algorithm 2)."""

    def __init__(self, points: Floats, base: Base, label: Ints, eta: float, parameter: Floats) -> None:
        self.points, self.base, self.eta = points, base, eta
        column = np.ascontiguousarray(base.log_likelihood(points, parameter).T)
        self.tables = Tables(label, parameter=parameter.copy(), column=column)

    def leave(self, i: int, fresh: Floats, *, keeps_own: bool = True) -> Floats:
        """Take point ``i`` out; its auxiliary parameters: ``fresh`` (m, p), the first one its own if it sat alone."""
        closed = self.tables.leave(i)
        if closed is None or not keeps_own:
            return fresh
        return np.vstack([closed["parameter"], fresh[1:]])

    def law(self, i: int, auxiliary: Floats) -> Floats:
        """(K + m,) log weights for point ``i``: n_k p(x_i|θ_k), then (η/m) p(x_i|θ) of each auxiliary."""
        k = self.tables.size
        old = np.log(self.tables.count[:k]) + self.tables.rows["column"][:k, i]
        new = np.log(self.eta / len(auxiliary)) + self.base.log_likelihood(self.points[i : i + 1], auxiliary)[0]
        return np.concatenate([old, new])

    def join(self, i: int, choice: int, auxiliary: Floats) -> None:
        """Put point ``i`` into an open cluster, or into a new one with the chosen auxiliary parameter."""
        if choice < self.tables.size:
            self.tables.join(i, choice)
            return
        parameter = auxiliary[choice - self.tables.size]
        column = self.base.log_likelihood(self.points, parameter[None])[:, 0]
        self.tables.join(i, self.tables.size, parameter=parameter, column=column)


def choose(log_weight: Floats, generator: np.random.Generator) -> int:
    """One index with probability proportional to exp(log_weight)."""
    top = log_weight.max()
    if not np.isfinite(top):
        raise InputError("points", found="a point of density zero under every cluster", wanted="a possible point")
    edges = np.cumsum(np.exp(log_weight - top))
    return int(np.searchsorted(edges, generator.random() * edges[-1], side="right"))


def summed(statistic: Floats, label: Ints) -> Floats:
    """(K, s) statistics of the clusters, from those of the points (N, s)."""
    totals = np.zeros((int(label.max()) + 1, statistic.shape[1]))
    np.add.at(totals, label, statistic)
    return totals
