"""One envelope with two bounds, grown until they meet for a group of subgoals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from subgoal._kernels import envelope as envelope_loops
from subgoal._kernels import first_passage as loops
from subgoal.mdp.local_world import LocalWorld, set_bound
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.goals import membership
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.subgoal_plan import Convention
from subgoal.mdp.tabular import ROW_TOLERANCE
from subgoal.runtime.checks import Bools, Floats, Ints
from subgoal.runtime.errors import InputError

COVER = 0.98
"""Share of what is expected outside that the next states are chosen to hold."""
GROWTH = 0.5
"""The envelope grows by this share at a time, at most, beyond the states that were chosen."""
LEAST_GROWTH = 200
LANDMARKS = 64
"""Roots for which it is asked whether a state may lie on their way, at most."""
FINE, FINEST = 0.02, 1e-6
"""Largest change of a last sweep as a share of the gap: at first, and at last."""
CLOSED = 1e-12
"""The same where nothing is outside and only the sweeps can close the gap."""
COVER_RINGS = 3
"""Chosen states are taken in with so many rings around them: what slips past the first comes back from the next."""
SLACK = 1e-9
"""How far a lower bound may be above a heuristic, for rounding."""
ROUNDING = 2e-15
MOST_SWEEPS = 10_000
FLOW_SWEEPS = 50


@dataclass(frozen=True)
class Settings:
    """What is planned: at most ``tolerance`` from Q*, in units of the reward; ``most_states`` inside an envelope."""

    convention: Convention
    tolerance: float
    most_states: int


class Bounds(NamedTuple):
    """Bounds of one group of J subgoals at U states, and what they cost."""

    value: Floats
    """(2, U, J) lower and upper."""
    rows: Floats
    """(2, U, A, J) of action values, −inf for illegal actions."""
    status: PlanStatus
    n_inside: int
    n_met: int
    rounds: int
    sweeps: int
    backups: int


def plan_group(world: LocalWorld, goals: list[Ints], states: Ints, settings: Settings) -> Bounds:
    """Bounds of the values at ``states`` (U,) for some goals, each a set of states."""
    growing = Growing(world, goals, states, settings)
    while not growing.step():
        growing.grow()
    return growing.answer()


class Growing:
    """One envelope and its two bounds."""

    def __init__(self, world: LocalWorld, goals: list[Ints], states: Ints, settings: Settings) -> None:
        self.world, self.settings, self.states = world, settings, states
        self.envelope = Envelope(world)
        self.here = self.envelope.meet(states)
        self.sets = [self.envelope.meet(members) for members in goals]
        self.goal_states = goals
        self.pinned = settings.convention == "absorbing" or all(len(each) == 1 for each in goals)
        self.top = 1.0 / (1.0 - world.discount) if settings.convention == "continuing" else 1.0
        start = np.unique(np.concatenate([self.here, *self.sets]))
        self.envelope.expand(start)
        self.roots = np.arange(self.envelope.n_met)
        self.envelope.expand(np.setdiff1d(self.roots, start))
        self.lower, self.upper = np.zeros((0, len(goals))), np.zeros((0, len(goals)))
        self.told = np.zeros((0, len(goals)))
        self.gap, self.fine = np.full(len(goals), np.inf), FINE
        self.rounds = self.sweeps = self.backups = 0

    def step(self) -> bool:
        """Settle both bounds inside; whether that is the end."""
        envelope, lanes = self.envelope, len(self.sets)
        self.table = envelope.table()
        self.order = envelope.order(self.table, np.unique(np.concatenate(self.sets)))
        self.edge = np.flatnonzero(~envelope.inside)
        value = self._start()
        mark, member = membership(self.sets, envelope.n_met)
        _, sweeps, backups = loops.settle(
            self.order, self._target(), False, MOST_SWEEPS, *self.table, mark, np.hstack([member, member]),
            self.pinned, value,
        )  # fmt: skip
        self.rounds, self.sweeps, self.backups = self.rounds + 1, self.sweeps + sweeps, self.backups + backups
        self.lower, self.upper = value[:, :lanes].copy(), value[:, lanes:].copy()
        self._check_heuristic()
        self.value, self.rows = self._bounds()
        legal = np.isfinite(self.rows[0])
        gap = np.subtract(self.rows[1], self.rows[0], where=legal, out=np.zeros_like(self.rows[0]))
        self.gap = gap.max(axis=(0, 1)) + 2 * rounding_of(self.top, self.world.discount)
        self.status = self._status()
        return self.status is not None

    def _check_heuristic(self) -> None:
        """Raise ``InputError`` where a lower bound is above what the heuristic said could not be exceeded."""
        beyond = self.lower > self.told * (1 + SLACK) + SLACK * self._scale_top()
        if beyond.any():
            place, j = (int(k) for k in np.argwhere(beyond)[0])
            where = f"state {self.envelope.states[place]}, goal {self.goal_states[j].tolist()}"
            raise InputError("heuristic", where=where, found=f"{self.told[place, j]:.6g}",
                             wanted=f"at least {self.lower[place, j]:.6g}: never less than E[γ^T]")  # fmt: skip

    def _status(self) -> PlanStatus | None:
        if self.gap.max() <= 2 * self.settings.tolerance:
            return PlanStatus.SOLVED
        if not self.edge.size:
            return PlanStatus.ROUNDING if self.fine <= CLOSED else None
        return PlanStatus.BUDGET if self.envelope.n_inside >= self.settings.most_states else None

    def grow(self) -> None:
        """Take in the states at which greedy behaviour under the upper bound leaves the envelope.

        Where it leaves too rarely to explain the gap, the sweeps stopped too early: they go on instead.
        """
        excess, missing = self._excess()
        if not self.edge.size or (excess.sum() < missing and self.fine > FINEST):
            self.fine *= 0.1
            return
        envelope = self.envelope
        most = ring_limit(envelope.n_inside, self.settings.most_states)
        envelope.expand_rings(largest_excess(excess, self.edge), COVER_RINGS, most, self._worth())

    def _excess(self) -> tuple[Floats, float]:
        """(S,) what is expected outside, and how much of it there is at least if the sweeps are done."""
        envelope = self.envelope
        excess, stops, inside, missing = np.zeros(envelope.n_met), np.zeros(envelope.n_met, bool), envelope.inside, 0.0
        enough = 2 * self.settings.tolerance / self._scale_top()
        for j in np.flatnonzero(self.gap > 2 * self.settings.tolerance):
            gap = self.upper[self.roots, j] - self.lower[self.roots, j]
            missing = max(missing, float(gap.max()))
            at = np.zeros(envelope.n_met, bool)
            at[self.sets[j]] = True
            envelope_loops.leaving(
                self.order, self.roots[gap > enough], j, at if self.pinned else stops, 1e-3 * enough, FLOW_SWEEPS,
                *self.table[:5], stops.astype(float) if self.pinned else at.astype(float), inside, self.upper,
                np.ascontiguousarray(self.upper[:, j]), excess,
            )  # fmt: skip
        return excess, missing

    def _worth(self) -> Callable[[Ints], Bools]:
        """Whether a state may be on a way from a root to a goal that beats the lower bound, for all that is known."""
        gap = self.upper[self.roots] - self.lower[self.roots]
        enough = 2 * self.settings.tolerance / self._scale_top()
        rooted = np.flatnonzero((gap > enough).any(axis=1))
        if rooted.size > LANDMARKS:
            rooted = rooted[np.linspace(0, rooted.size - 1, LANDMARKS).astype(int)]
        roots = self.roots[rooted]
        least = np.where(gap[rooted] > enough, self.lower[roots], np.inf)
        starts = self.envelope.states[roots].copy()

        def worth(places: Ints) -> Bools:
            there = self.world.reach_bound(starts, self.envelope.states[places]).T
            onwards = self._heuristic(places)
            each = ((there * onwards[:, j, None] >= least[:, j]).any(axis=1) for j in range(least.shape[1]))
            return np.asarray(np.logical_or.reduce(list(each)))

        return worth

    def answer(self) -> Bounds:
        """What is known now."""
        status, envelope = self.status or PlanStatus.LIMIT, self.envelope
        return Bounds(
            self.value, self.rows, status, envelope.n_inside, envelope.n_met, self.rounds, self.sweeps, self.backups
        )

    def _start(self) -> Floats:
        """(S, 2J) both bounds as they were; for states newly met nothing, and what the heuristic says."""
        lanes = len(self.sets)
        value = np.zeros((self.envelope.n_met, 2 * lanes))
        value[: len(self.lower), :lanes] = self.lower
        value[: len(self.upper), lanes:] = self.upper
        new = np.arange(len(self.upper), self.envelope.n_met)
        value[new, lanes:] = heard = self._heuristic(new)
        self.told = np.concatenate([self.told, heard])
        if self.pinned:
            for j, members in enumerate(self.sets):
                value[members, j] = value[members, lanes + j] = 1.0
        return value

    def _heuristic(self, places: Ints) -> Floats:
        states = self.envelope.states[places]
        if all(len(members) == 1 for members in self.goal_states):
            return self.world.reach_bound(states, np.concatenate(self.goal_states))
        out = np.stack([set_bound(self.world, states, members) for members in self.goal_states], axis=1)
        return out if self.pinned else out * self.top

    def _target(self) -> float:
        wanted = max(2 * self.settings.tolerance, min(float(self.gap.max()), self.top))
        return max(1e-15, self.fine * wanted / self._scale_top())

    def _scale_top(self) -> float:
        return self.top if self.pinned else 1.0

    def _bounds(self) -> tuple[Floats, Floats]:
        """(2, U, J) of the values and (2, U, A, J) of the action values."""
        goals = np.array([members[0] for members in self.sets])
        both = [self.lower, self.upper]
        value, rows = [], []
        at = np.stack([np.isin(self.here, members) for members in self.sets], axis=1)
        for bound in both:
            scale: Any = 1.0
            if self.pinned and self.settings.convention == "continuing":
                lanes = np.arange(goals.size)
                ahead = self._ahead(self.envelope.states[goals], bound).max(axis=1)[lanes, lanes]
                scale = 1 / (1 - np.clip(ahead, 0.0, min(self.world.discount * (1 + ROW_TOLERANCE), 1 - 1e-15)))
            each = self._ahead(self.states, bound) * scale
            if self.settings.convention == "absorbing":
                each[at[:, None] & np.isfinite(each)] = 0.0
            value.append(bound[self.here] * scale)
            rows.append(each + at[:, None])
        return np.stack(value), np.stack(rows)

    def _ahead(self, states: Ints, value: Floats) -> Floats:
        """(U, A, J) γ Σ P(s' | s, a) v(s')."""
        rows = self.envelope.action_rows(states)
        out = np.empty((states.size, self.world.n_actions, value.shape[1]))
        loops.action_rows(
            np.arange(states.size), rows.offset, rows.successor, rows.probability, self.world.n_actions,
            self.world.discount, value, out,
        )  # fmt: skip
        return out


def rounding_of(top: float, discount: float) -> float:
    """How far rounding may put a value of up to ``top`` off."""
    return ROUNDING * top / (1 - discount)


def ring_limit(inside: int, most_states: int) -> int:
    """How many states one growth may take in."""
    return min(most_states - inside, max(LEAST_GROWTH, int(GROWTH * inside)))


def largest_excess(excess: Floats, edge: Ints) -> Ints:
    """The states of ``edge`` that hold most of the excess together; all of them where there is none."""
    found = edge[excess[edge] > 0]
    if not found.size:
        return edge
    falling = found[np.argsort(-excess[found], kind="stable")]
    share = np.cumsum(excess[falling])
    return falling[: int(np.searchsorted(share, COVER * share[-1])) + 1]
