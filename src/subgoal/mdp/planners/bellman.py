"""What all planners share: one backup of a world and a reward, and how far its result can be from the truth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from subgoal._kernels import backups as loops
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rewards import check_reward
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Bools, Floats, Ints, frozen, positive, real_array
from subgoal.runtime.errors import InputError, PlanningError

ULP = 2.0**-53
"""Largest relative error of one rounding."""
LEAST_SHARE = 1e-12
"""Of 1 − γ, where a sum of rewards over time is tried for being finite."""


@dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """An optimal value function and a policy that is greedy in it.

    Attributes
    ----------
    value:
        (S,) V(s) of (2.2); in terminal states their own R(s), or 0 with rewards r(s, a).
    policy:
        (S,) the best action, −1 in terminal states; of those equal up to rounding, the one of lowest index.
    status:
        Whether ``error_bound`` is within the tolerance, and if not, why.
    error_bound:
        No value is further than this from the optimal one, rounding included; infinite where no bound is known.
    sweeps, backups:
        Work done: passes over the states, and rows of the transition table that were read in them.
    """

    value: Floats
    policy: Ints
    status: PlanStatus
    error_bound: float
    sweeps: int
    backups: int

    def __repr__(self) -> str:
        return f"Plan({self.value.size} states, {self.status.name}, ±{self.error_bound:.1g}, {self.sweeps} sweeps)"


class Backup(NamedTuple):
    """One backup of v: T v, its greedy actions, the lowest and highest of T v − v, and the bound on |T v − V*|."""

    value: Floats
    policy: Ints
    low: float
    high: float
    bound: float

    @property
    def change(self) -> float:
        """max |T v − v|."""
        return max(-self.low, self.high)


class _Table(NamedTuple):
    """What the compiled loops read."""

    offset: Ints
    successor: Any
    probability: Floats
    terminal: Bools
    reward: Floats
    ending: Floats
    n_actions: int
    discount: float


@dataclass(frozen=True, eq=False)
class Bellman:
    """The operator T of (2.5) for one world and one reward: (T v)(s) = max_a r + γ Σ P(s' | s, a) v(s')."""

    mdp: TabularMDP
    reward: Floats
    ending: Floats

    @classmethod
    def of(cls, mdp: TabularMDP, reward: Any) -> Bellman:
        """Checked; see ``check_reward``. Raises ``InputError`` also where values would be too large for a number."""
        bellman = cls(mdp, *check_reward(mdp, reward))
        if not bellman.largest / max(1 - bellman.modulus, LEAST_SHARE) < np.inf:
            wanted = "rewards whose sum over time is a finite number"
            raise InputError("reward", found=f"rewards up to {bellman.largest:g}", wanted=wanted)
        return bellman

    @cached_property
    def table(self) -> _Table:
        """World and reward, as the compiled loops take them."""
        mdp = self.mdp
        rows = (mdp.offset, mdp.successor, mdp.probability, mdp.terminal)
        return _Table(*rows, self.reward, self.ending, mdp.n_actions, mdp.discount)

    @cached_property
    def rows(self) -> int:
        """Rows of the transition table that one sweep reads."""
        return int(np.count_nonzero(self.mdp.available))

    @cached_property
    def each(self) -> Floats:
        """(S·A,) immediate reward of every action."""
        mdp = self.mdp
        return self.reward if self.reward.size == mdp.available.size else np.repeat(self.reward, mdp.n_actions)

    @cached_property
    def gains(self) -> Floats:
        """(rows,) immediate reward of every available action."""
        return np.asarray(self.each[self.mdp.available.ravel()])

    @cached_property
    def sums(self) -> Floats:
        """(rows,) what the probabilities of every available action sum to: one, nearly."""
        sums = np.asarray(self.mdp.matrix.sum(axis=1), float).ravel()
        return np.asarray(sums[self.mdp.available.ravel()])

    @cached_property
    def largest(self) -> float:
        """max |R|, values of terminal states included."""
        return float(max(np.abs(self.gains).max(initial=0.0), np.abs(self.ending).max(initial=0.0)))

    @cached_property
    def modulus(self) -> float:
        """T brings value functions closer by this factor: γ times the largest sum of a row."""
        return self.mdp.discount * float(self.sums.max(initial=0.0))

    def tolerance(self, given: float | None) -> float:
        """``given``, or 1e-6 of the largest value there can be, max |R| / (1 − γ) (of max |R| at γ = 1)."""
        if given is not None:
            return positive("tolerance", given, zero=True)
        return 1e-6 * self.largest / (1 - self.modulus if self.modulus < 1 else 1)

    def start(self, given: Any) -> Floats:
        """Where iteration starts: ``given``, (S,), or zero; terminal states have their own values from the start."""
        value = np.zeros(self.mdp.n_states) if given is None else real_array("initial", given, ndim=1)
        if value.size != self.mdp.n_states:
            raise InputError("initial", found=f"{value.size} values", wanted=f"{self.mdp.n_states}")
        return np.where(self.mdp.terminal, self.ending, value)

    def rounding(self, value: Floats) -> float:
        """Largest rounding error of one computed backup of ``value``: m + 4 roundings of terms this large."""
        longest = int(np.diff(self.mdp.offset).max(initial=0))
        size = self.largest + self.modulus * float(np.abs(value).max(initial=0.0))
        return (longest + 4) * ULP * size

    def stop(self, tolerance: float, value: Floats) -> float:
        """The change of a sweep below which ``bound`` is within ``tolerance``, or nothing more is to be had."""
        floor = self.rounding(value)
        if self.modulus < 1:
            wanted = ((1 - self.modulus) * tolerance - floor) / max(self.modulus, 1e-300)
        else:
            depth = self._highest_ending - float(value.min(initial=0.0))
            wanted = self._least_cost * tolerance / (depth + tolerance) / 2 if self._least_cost > 0 else 0.0
        return max(wanted, floor)

    def bound(self, change: float, value: Floats) -> float:
        """Largest error of T v, where ``change`` is max |T v − v| and ``value`` is T v.

        Below discount 1: (γ change + rounding) / (1 − γ). At discount 1, where every step costs at least c and no value
        is above that of the best ending, K: K − (K − v) c / (c ± change) is above and below V*; else nothing is known.
        """
        floor = self.rounding(value)
        if self.modulus < 1:
            return (self.modulus * change + floor) / (1 - self.modulus)
        change, depth = max(self.modulus, 1.0) * change + floor, self._highest_ending - value
        if not (change < self._least_cost and (depth >= 0).all()):
            return np.inf
        return float(depth.max() * change / (self._least_cost - change))

    def backup(self, value: Floats, kept: Ints | None = None) -> Backup:
        """T v with its greedy actions and its bound; ``kept`` (S,) actions are kept where they are among the best."""
        out, policy = np.empty(self.mdp.n_states), np.empty(self.mdp.n_states, np.int64)
        kept = np.full(self.mdp.n_states, -1) if kept is None else kept
        low, high = loops.greedy_backup(4 * self.rounding(value), *self.table, value, kept, out, policy)
        return Backup(out, policy, low, high, self.bound(max(-low, high), out))

    def centred(self, last: Backup) -> Backup:
        """``last`` moved to the middle of the bounds of MacQueen (1966), which makes its own bound smaller.

        T v + γ low / (1 − γ) ≤ V* ≤ T v + γ high / (1 − γ). As rows sum to one only nearly, γ is taken times the sum
        that makes each bound the wider. Terminal states, whose values are known, do not move.
        """
        if not self.modulus < 1:
            return last
        least, most = (g / (1 - g) for g in (self.mdp.discount * float(self.sums.min(initial=1.0)), self.modulus))
        under = last.low * (most if last.low < 0 else least)
        over = last.high * (most if last.high > 0 else least)
        value = np.where(self.mdp.terminal, last.value, last.value + (under + over) / 2)
        bound = (over - under) / 2 + 2 * self.rounding(value) / (1 - self.modulus)
        return last._replace(value=value, bound=bound) if bound < last.bound else last

    def settled(self, last: Backup, tolerance: float) -> bool:
        """Whether ``last`` is within the tolerance, or differs from what came before by no more than rounding."""
        return last.bound <= tolerance or last.change <= 2 * self.rounding(last.value)

    def plan(self, last: Backup, tolerance: float, *, limited: bool, sweeps: int, backups: int) -> Plan:
        """The plan that ends with the backup ``last``; ``limited`` if more sweeps would have changed it."""
        if last.bound <= tolerance:
            status = PlanStatus.SOLVED
        elif limited:
            status = PlanStatus.LIMIT
        else:
            status = PlanStatus.ROUNDING if np.isfinite(last.bound) else PlanStatus.SETTLED
        return Plan(frozen(last.value), frozen(last.policy), status, last.bound, sweeps, backups)

    @cached_property
    def _highest_ending(self) -> float:
        """K, the largest value of a terminal state."""
        return float(self.ending[self.mdp.terminal].max(initial=-np.inf)) if self.mdp.terminal.any() else 0.0

    @cached_property
    def _least_cost(self) -> float:
        """c, the least that a step costs, with values measured from K (rows that do not quite sum to one included)."""
        shifted = self._highest_ending * (self.mdp.discount * self.sums - 1)
        return -float((self.gains + shifted).max(initial=-np.inf))


def delivered(plan: Plan, what: str, tolerance: float, allow_unconverged: bool) -> Plan:
    """``plan``, if its status permits; raises ``PlanningError`` otherwise."""
    if not allow_unconverged and plan.status in (PlanStatus.ROUNDING, PlanStatus.LIMIT):
        bound = f"error bound {plan.error_bound:.3g}, tolerance {tolerance:.3g}, {plan.sweeps} sweeps"
        raise PlanningError(f"{what}: {plan.status.value}, or allow_unconverged=True ({bound})")
    return plan
