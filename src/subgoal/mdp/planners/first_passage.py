"""Planning for every subgoal at once: a subgoal's value function is a first-passage problem.

With reward c at the goal and none elsewhere (thesis 4.1), every return to the goal renews the process. With T the first
time at the goal, h(s) = max over policies of E[γ^T], which is solved with the goal held at one:

    h(s) = γ max_a Σ P(s' | s, a) h(s'),   V*(s) = h(s) V*(g),   V*(g) = c / (1 − γ max_a Σ P(s' | g, a) h(s')).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from subgoal._kernels import first_passage as loops
from subgoal.mdp.planners.compressed import CompressedRows
from subgoal.mdp.planners.goals import goal_sets, membership
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.subgoal_plan import Convention, SubgoalPlan
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.runtime.checks import Floats, Ints, positive, whole
from subgoal.runtime.errors import InputError, PlanningError
from subgoal.runtime.executor import run_each
from subgoal.runtime.progress import Progress, Silent

LANES = 20
"""Goals that are planned side by side, at most; more read a transition row less often."""
NEAR = loops.BLOCK
"""Only goals within so many states of each other are planned side by side: they share the order of their sweeps."""
TOLERANCE = 1e-9
"""Default error bound of the values, as a share of the largest value there can be."""
WORTH_THREADS = 100_000
"""Below this S·G, planning is over before threads have started."""
TIGHTENINGS = 6
SAFETY = 0.5
"""Part of the tolerance that the values away from the goal may use; what is left is for the goal's own."""
FLOOR = 2e-16
ROWS = 1024
"""States whose action values are written at a time."""
ROUNDING = 2e-15
"""What the backup of a value of one may be wrong by in its last digits."""


class _Solved(NamedTuple):
    """One group of J goals: (U, J) values, (U, A, J) action values of the kept states, and what they are worth."""

    value: Floats
    rows: Any
    error: float
    limited: bool
    sweeps: int
    backups: int


def plan_subgoals(
    mdp: TabularMDP,
    goals: Any,
    *,
    states: Any = None,
    convention: Convention = "continuing",
    tolerance: float | None = None,
    relative: bool = False,
    most_sweeps: int = 100_000,
    workers: int | None = None,
    backend: str = "threading",
    allow_unconverged: bool = False,
    progress: Progress | None = None,
) -> SubgoalPlan:
    """Values of G subgoals: reward 1 at every visit of the goal (thesis 4.1), or once, where the episode then ends.

    Parameters
    ----------
    mdp:
        The world; its discount must be below 1.
    goals:
        (G,) states, or G sets of states (feature subgoals, Definition 3: rewarded anywhere in the set).
    states:
        (U,) states whose values and action values are kept. None keeps the values of all, and no action values.
    convention:
        "continuing" (the default, as (2.5) reads): the goal is rewarded at every visit. "absorbing": once, and over;
        its values are those of "continuing" divided by V*(g), hence 1 − γ times them where the goal can be held.
    tolerance:
        Largest error of a value in units of c. Default: 1e-9 of the largest value, 1/(1 − γ) or 1, or what rounding
        allows if that is more, as the status then says.
    relative:
        Settle small values to within rounding of themselves too, goal by goal, so that the best action is known far
        from the goal, where the values of all actions are within the tolerance of each other.
    most_sweeps:
        For each group of goals.
    workers, backend:
        Groups of up to 20 goals near each other are planned for apart: in threads, in processes ("loky") or on a
        connected Dask cluster ("dask"). The values do not depend on it.
    allow_unconverged:
        Return what was reached, with its status, instead of raising.
    progress:
        Told how many groups of goals are done.

    Memory: the result, which is 8·S·G bytes for all values or 8·U·(A + 1)·G for chosen states; beside it, whatever G
    is, the compressed transition table and 8·S bytes for each of the 20 goals that each worker has in hand.

    Raises
    ------
    InputError
        Goals or states that do not exist, an empty set, a discount of 1.
    PlanningError
        The tolerance was not reached.
    """
    check_world(mdp)
    if not mdp.discount < 1:
        raise InputError("discount", found=mdp.discount, wanted="below 1, to plan for subgoals that are held")
    if convention not in ("continuing", "absorbing"):
        raise InputError("convention", found=repr(convention), wanted="'continuing' or 'absorbing'")
    sets = goal_sets(goals, lambda what, states: check_states(what, states, mdp.n_states))
    top = 1.0 / (1.0 - mdp.discount) if convention == "continuing" else 1.0
    asked = tolerance is not None
    tolerance = positive("tolerance", tolerance) if asked else TOLERANCE * top
    kept = None if states is None else np.atleast_1d(check_states("states", states, mdp.n_states))
    if kept is not None and kept.ndim != 1:
        raise InputError("states", found=f"shape {kept.shape}", wanted="(U,)")
    n_rows = mdp.n_states if kept is None else kept.size
    value = np.empty((n_rows, len(sets)))
    rows = None if kept is None else np.empty((n_rows, mdp.n_actions, len(sets)))
    job = _Job(mdp, sets, kept, convention, tolerance, relative, whole("most_sweeps", most_sweeps))
    if workers is None and backend == "threading" and mdp.n_states * len(sets) < WORTH_THREADS:
        workers = 1
    solved, done, jobs = [], 0, [(group,) for group in job.groups]
    with progress or Silent() as display:
        for (group,), each in zip(jobs, run_each(job.solve, jobs, workers=workers, backend=backend), strict=True):
            value[:, group] = each.value
            if rows is not None:
                rows[:, :, group] = each.rows
            solved.append(each._replace(value=value[:0], rows=None))
            done += group.size
            display.update(done, len(sets))
    return _collected(job, value, rows, solved, allow_unconverged, asked)


@dataclass(frozen=True, eq=False)
class _Job:
    """What all groups of goals share."""

    mdp: TabularMDP
    sets: list[Ints]
    kept: Ints | None
    convention: Convention
    tolerance: float
    relative: bool
    most_sweeps: int

    @cached_property
    def table(self) -> CompressedRows:
        """Compressed once for all goals."""
        mdp = self.mdp
        own = np.arange(mdp.n_states)
        rows = loops.compress_rows(mdp.offset, mdp.successor, mdp.probability, mdp.n_actions, mdp.discount, own)
        return CompressedRows(*rows, *loops.find_predecessors(*rows[:3]))

    @cached_property
    def modulus(self) -> float:
        """γ, times what the fullest row sums to: the sweeps contract by it."""
        fullest = max(1.0, float(self.mdp.matrix.sum(axis=1).max()))
        return min(self.mdp.discount * fullest, 1 - 1e-15)

    @cached_property
    def groups(self) -> list[Ints]:
        """Goals that lie near each other, up to ``LANES`` together; single states and sets apart."""
        single = np.array([len(members) == 1 for members in self.sets])
        groups = []
        for kind in (np.flatnonzero(single), np.flatnonzero(~single)):
            if not kind.size:
                continue
            places = np.array([self.sets[g][0] for g in kind])
            label = loops.near_groups(places, self.table.edge, self.table.before, 1 if self.relative else LANES, NEAR)
            groups += [kind[label == k] for k in range(label.max() + 1)]
        return groups

    def solve(self, group: Ints) -> _Solved:
        """One group, tightened until the error bound of the values is within the tolerance."""
        table, mdp = self.table, self.mdp
        sets = [self.sets[g] for g in group]
        pinned = self.convention == "absorbing" or all(len(members) == 1 for members in sets)
        mark, member = membership(sets, mdp.n_states)
        value = np.zeros((mdp.n_states, len(sets)))
        if pinned:
            for j, members in enumerate(sets):
                value[members, j] = 1.0
        order = loops.distance_order(np.concatenate(sets), table.edge, table.before)
        target = self._first_target(pinned)
        sweeps, backups, error = 0, 0, np.inf
        for _ in range(TIGHTENINGS):
            residual, more, work = loops.settle(
                order, target, self.relative, self.most_sweeps - sweeps, *table, mark, member, pinned, value
            )
            sweeps, backups = sweeps + more, backups + work
            scale, error = self._scale(sets, value, residual, pinned)
            if error <= self.tolerance or sweeps >= self.most_sweeps or target <= FLOOR:
                break
            target = max(FLOOR, target * min(0.1, SAFETY * self.tolerance / error))
        value *= scale
        return _Solved(*self._kept(sets, value), error, sweeps >= self.most_sweeps, sweeps, backups)

    def _first_target(self, pinned: bool) -> float:
        """Largest change of a pass that promises the tolerance away from the goal."""
        discount = self.mdp.discount
        top = 1.0 / (1.0 - discount) if pinned and self.convention == "continuing" else 1.0
        return max(FLOOR, SAFETY * self.tolerance / top * (1 - discount) / max(discount, 1e-3))

    def _scale(self, sets: list[Ints], value: Floats, residual: float, pinned: bool) -> tuple[Any, float]:
        """(L,) what first-passage values are multiplied with, and the error bound of the product."""
        modulus = self.modulus
        rounding = ROUNDING / (1 - modulus) if not pinned else ROUNDING
        error = modulus * (residual + rounding) / (1 - modulus)
        if not pinned or self.convention == "absorbing":
            return 1.0, error
        goals = np.array([members[0] for members in sets])
        lanes = np.arange(goals.size)
        ahead = np.clip(self._ahead(goals, value).max(axis=1)[lanes, lanes], 0.0, modulus)
        highest = np.minimum(modulus, ahead + modulus * error)
        own, most = 1 / (1 - ahead), 1 / (1 - highest)
        return own, float((error * most + (most - own)).max())

    def _ahead(self, states: Ints, value: Floats) -> Floats:
        """(U, A, L) γ Σ P(s' | s, a) v(s')."""
        mdp = self.mdp
        out = np.empty((len(states), mdp.n_actions, value.shape[1]))
        loops.action_rows(states, mdp.offset, mdp.successor, mdp.probability, mdp.n_actions, mdp.discount, value, out)
        return out

    def _kept(self, sets: list[Ints], value: Floats) -> tuple[Floats, Any]:
        """Values and action values of the kept states, made a block at a time; or all values."""
        if self.kept is None:
            return value, None
        out = np.empty((self.kept.size, self.mdp.n_actions, len(sets)))
        for start in range(0, self.kept.size, ROWS):
            block = slice(start, start + ROWS)
            states = self.kept[block]
            at = np.stack([np.isin(states, members) for members in sets], axis=1)[:, None]
            rows = self._ahead(states, value)
            if self.convention == "absorbing":
                rows[at & np.isfinite(rows)] = 0.0
            out[block] = rows + at
        return value[self.kept], out


def _collected(
    job: _Job, value: Floats, rows: Any, solved: Sequence[_Solved], allow_unconverged: bool, asked: bool
) -> SubgoalPlan:
    error = max(each.error for each in solved)
    limited = any(each.limited and not each.error <= job.tolerance for each in solved)
    status = PlanStatus.SOLVED if error <= job.tolerance else PlanStatus.LIMIT if limited else PlanStatus.ROUNDING
    missed = status is PlanStatus.LIMIT or (asked and status is PlanStatus.ROUNDING)
    if missed and not allow_unconverged:
        bound = f"error bound {error:.3g}, tolerance {job.tolerance:.3g}"
        hint = "or allow_unconverged=True"
        raise PlanningError(f"planning for {len(job.sets)} subgoals: {status.value}, {hint} ({bound})")
    states = np.arange(job.mdp.n_states) if job.kept is None else job.kept
    return SubgoalPlan(
        states, value, rows, job.convention, error, job.tolerance, status, sum(each.sweeps for each in solved),
        sum(each.backups for each in solved), job.relative,
    )  # fmt: skip
