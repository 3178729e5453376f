"""Groups of trajectories, each with weights of its own: exchangeable within a group, alike between groups."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal._kernels import groups as loops
from subgoal._kernels import seating as restaurants
from subgoal.partition.priors import Gamma, log_weights
from subgoal.partition.protocol import (
    Arrays,
    Chain,
    Recorder,
    Stretch,
    log_fit,
    relative_rows,
    starting_assignment,
)
from subgoal.partition.shared_weights import draw_mass, log_rows, log_shared, mass_of
from subgoal.partition.together import bytes_needed, redraw_together
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

MASS = Gamma(1.0, 0.1)
COUNT_ENTRIES = 2**26
"""Most entries of "group counts" among the parameters of a stretch; above it they are left out."""


@dataclass(frozen=True)
class Grouped:
    """Sampler of the hierarchical Dirichlet process (Teh et al. 2006) over the candidates.

    β ~ Dirichlet(ηp), with η the concentration of the chain; w_k ~ Dirichlet(aβ) for each group k of trajectories (an
    animal, a driver, a day), and θ_i ~ w of its group. Candidates are finite in number, so this is exact and no
    truncation. A sweep draws β, then each θ_i with the w integrated out; seats the observations of each group and
    candidate at tables and draws a; then tables are observations of the exchangeable mixture, β integrated out, and a
    sweep of ``collapsed_blocks`` over them follows, which moves whole candidates. O(N·G) per sweep.

    Attributes
    ----------
    group:
        (D,) number of the group of each trajectory, from 0.
    mass:
        a, or its prior: how much groups are alike.

    Raises ``InputError`` for groups that are not whole numbers from 0, and, when called, for a number of trajectories
    other than that of the likelihood.
    """

    group: Sequence[int] | Any
    mass: float | Gamma = MASS

    def __post_init__(self) -> None:
        mass_of("mass of the groups", self.mass)
        given = np.asarray(self.group)
        if given.ndim != 1 or given.size == 0 or given.dtype.kind not in "iu":
            found = f"{given.dtype} of shape {given.shape}"
            raise InputError("group", found=found, wanted="whole numbers of shape (trajectories,)")
        if given.min() < 0:
            where = int(np.argmax(given < 0))
            raise InputError("group", where=f"trajectory {where}", found=int(given[where]), wanted="a number from 0")
        if given.max() >= given.size:
            where = int(np.argmax(given >= given.size))
            wanted = f"a number below {given.size}, there being {given.size} trajectories"
            raise InputError("group", where=f"trajectory {where}", found=int(given[where]), wanted=wanted)
        object.__setattr__(self, "group", tuple(int(k) for k in given))

    @property
    def __name__(self) -> str:
        return "grouped"

    @property
    def n_groups(self) -> int:
        """Number of groups K."""
        return max(self.group) + 1

    def bytes_needed(self, n: int, g_count: int) -> float:
        """Of one chain: both matrices of the tables."""
        return bytes_needed(n, g_count)

    def __call__(self, chain: Chain, keep: Bools) -> Stretch:
        """Advance one chain; see ``Sampler``."""
        tables = _Franchise(chain, self)
        record = Recorder(chain.table, keep)
        n_kept, g_count = int(keep.sum()), chain.table.n_candidates
        held = n_kept * self.n_groups * g_count < COUNT_ENTRIES
        counts = np.empty((n_kept if held else 0, self.n_groups, g_count), np.int32)
        mass: list[float] = []
        redraws: list[Ints] = []
        for s in range(keep.size):
            tables.sweep()
            fit, joint = tables.log_joint()
            record.sweep(s, keep[s], tables.theta, int(np.count_nonzero(tables.shared)), fit, joint)
            if keep[s]:
                if held:
                    counts[len(mass)] = tables.counts
                mass.append(tables.mass)
                redraws.append(tables.shared.copy())
        found: dict[str, Any] = {"group mass": np.array(mass, float)}
        return replace(
            record.stretch(tables.state()),
            parameters=found | ({"group counts": counts} if held else {}),
            redraws=np.array(redraws, np.int64).reshape(-1, g_count),
        )


class _Franchise:
    """One chain between sweeps: the assignment, how many tables serve each candidate, and a."""

    def __init__(self, chain: Chain, model: Grouped) -> None:
        table = chain.table
        self.chain, self.model, self.table = chain, model, table
        sizes = np.diff(table.offset)
        if sizes.size != len(model.group):
            raise InputError("group", found=f"{len(model.group)} trajectories", wanted=f"{sizes.size}, as there are")
        self.prior = np.exp(table.log_prior)
        self.group = np.repeat(np.array(model.group, np.int64), sizes)
        self.counts = np.zeros((model.n_groups, table.n_candidates), np.int64)
        state = chain.state or self._begin()
        self.theta = np.array(state["theta"], np.int32)
        self.shared = np.array(state["counts"], np.int64)
        self.mass = float(state["group_mass"][0])
        loops.count_in_groups(self.theta, self.group, self.counts)

    def _begin(self) -> Arrays:
        theta = starting_assignment(self.table, self.chain.generator)
        loops.count_in_groups(theta, self.group, self.counts)
        mass = self.model.mass
        start = mass.start if isinstance(mass, Gamma) else float(mass)
        return {"theta": theta, "counts": (self.counts > 0).sum(axis=0), "group_mass": np.array([start])}

    def state(self) -> Arrays:
        """From where the chain goes on."""
        return {"theta": self.theta, "counts": self.shared, "group_mass": np.array([self.mass])}

    def sweep(self) -> None:
        """Shared weights, observations, tables, a, then the candidates of tables."""
        weights = np.exp(self._draw_weights())
        self._redraw(weights)
        table_of, n_tables = self._seat(weights)
        if isinstance(self.model.mass, Gamma):
            sizes = self.counts.sum(axis=1)
            self.mass = draw_mass(self.mass, self.model.mass, n_tables, sizes, self.chain.generator)
        self._move_tables(table_of, n_tables)

    def _draw_weights(self) -> Floats:
        """Log β given how many tables serve each candidate."""
        return log_weights(self.chain.concentration * self.prior + self.shared, self.chain.generator)

    def _redraw(self, weights: Floats) -> None:
        edges, work = self.table.edges, np.empty(self.prior.size)
        for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            loops.redraw_rows(
                start, relative_rows(self.table, start, stop), self.group, weights, self.mass, self.theta, self.counts,
                work, self.chain.generator,
            )  # fmt: skip

    def _seat(self, weights: Floats) -> tuple[Ints, int]:
        """(N,) table of each observation, and how many there are; a restaurant for each group and candidate."""
        restaurant = self.group * weights.size + self.theta
        seating, rows = restaurants.seating_for(self.theta.size, self.counts.size), np.empty((self.theta.size, 0))
        mass = np.tile(self.mass * weights, len(self.counts))
        n_tables = restaurants.seat_rows(0, rows, restaurant, mass, seating, rows, 0, self.chain.generator)
        return seating.table_of, int(n_tables)

    def _move_tables(self, table_of: Ints, n_tables: int) -> None:
        """Given the seating, tables are observations of the exchangeable mixture."""
        dish = np.empty(n_tables, np.int32)
        loops.dishes_of(self.theta, table_of, dish)
        dish = redraw_together(self.chain, self.prior, table_of, dish, self._sums)
        self.theta = np.ascontiguousarray(dish[table_of])
        self.shared = np.bincount(dish, minlength=self.prior.size)
        loops.count_in_groups(self.theta, self.group, self.counts)

    def _sums(self, table_of: Ints, count: int) -> Floats:
        """(count, G) log likelihood of each table, were it at each candidate."""
        sums = np.zeros((count, self.prior.size))
        for start, tile in self.table.tiles():
            loops.add_rows(start, tile, table_of, sums)
        return sums

    def log_joint(self) -> tuple[float, float]:
        """Σ ℓ[i, θ_i], and the log joint density of assignment, β and a, the weights of groups integrated out.

        β is drawn for it; its density is that of ``log_shared``.
        """
        log_beta = self._draw_weights()
        value = log_shared(log_beta, np.flatnonzero(self.shared), self.prior, self.chain.concentration)
        group, column = np.nonzero(self.counts)
        totals = np.column_stack([np.full(len(self.counts), self.mass), self.counts.sum(axis=1)])
        value += log_rows(self.counts[group, column], self.mass * np.exp(log_beta[column]), totals)
        if isinstance(self.model.mass, Gamma):
            value += self.model.mass.log_density(self.mass)
        fit = log_fit(self.table, self.theta)
        return fit, fit + value
