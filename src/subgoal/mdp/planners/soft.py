"""Soft planning: values and policies of a demonstrator who prefers good actions, but not only the best (Ziebart 2010).

V(s) = T log Σ_a exp(Q(s, a)/T) over the actions that are available, Q(s, a) = R(s) + γ Σ P(s' | s, a) V(s'), and
π(a | s) = exp((Q(s, a) − V(s))/T): the policy of greatest expected reward plus T times its entropy, over time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from subgoal.mdp.planners.bellman import ULP, Bellman
from subgoal.mdp.planners.flow import Flow
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, frozen, positive, whole
from subgoal.runtime.errors import InputError, PlanningError

CLOSE, CLOSE_AT_1 = 1e-9, 1e-6
"""Default tolerance: share of the largest value there can be; at discount 1, of the largest gain of a step."""
SETTLED = 8
"""Roundings of a backup within which values stand still."""
ENDLESS = (
    "soft planning: at discount 1 rewards, or the entropy of the actions, can be collected without end, so that values "
    "are not finite. Try: a discount below 1, or a larger cost of each step"
)


@dataclass(frozen=True, eq=False, repr=False)
class SoftPlan:
    """A soft value function and its policy.

    Attributes
    ----------
    value:
        (S,) V(s) = T log Σ_a exp(Q(s, a)/T); in terminal states their own R(s), or 0 with rewards r(s, a).
    action_values:
        (S, A) Q(s, a); −inf for actions that are not available.
    policy:
        (S, A) π(a | s) = exp((Q(s, a) − V(s))/T); zero in terminal states.
    temperature:
        T.
    status:
        Whether ``error_bound`` is within the tolerance, and if not, why.
    error_bound:
        No value or action value is further than this from the true one, rounding included.
    sweeps:
        Backups of all states; between two of them, one sparse linear solve.
    """

    value: Floats
    action_values: Floats
    policy: Floats
    temperature: float
    status: PlanStatus
    error_bound: float
    sweeps: int

    def __repr__(self) -> str:
        told = f"{self.value.size} states, temperature {self.temperature:g}, {self.status.name}"
        return f"SoftPlan({told}, ±{self.error_bound:.1g}, {self.sweeps} sweeps)"


def soft_value_iteration(
    mdp: TabularMDP,
    reward: Any = None,
    *,
    temperature: float = 1.0,
    tolerance: float | None = None,
    initial: Any = None,
    most_sweeps: int = 1_000,
    allow_unconverged: bool = False,
) -> SoftPlan:
    """Soft values by Newton's method: evaluate the soft policy of the last values exactly, back up, repeat.

    The backup is a γ-contraction and convex, so that after the first step values only rise and the last steps double
    the digits; a step is soft policy iteration, v + (I − γP_π)⁻¹(Tv − v).

    Parameters
    ----------
    reward:
        As in ``value_iteration``: R(s) (S,) paid now, terminal states being worth their own; or r(s, a) (S, A).
    temperature:
        T > 0, in units of the reward. Towards 0 the plan becomes the optimal one.
    tolerance:
        Largest error of a value; not given: 1e-9 (max |R| + T log A)/(1 − γ), at discount 1
        1e-6 (max |R| + T log A).
    initial:
        (S,) values to start from.
    most_sweeps, allow_unconverged:
        Backups at most; whether to return what was reached, with its status, instead of raising.

    Notes
    -----
    If a backup changes nothing by more than d, its values are within γd/(1 − γ) of the true ones. At discount 1 the
    bound is found by a value function above and one below that the backup is seen to bring closer.

    Raises
    ------
    InputError
        As ``value_iteration``; a temperature that is not above 0.
    PlanningError
        The tolerance was not reached; at discount 1, values that are not finite.
    """
    soft = _SoftBellman(Bellman.of(mdp, reward), positive("temperature", temperature))
    wanted, most = soft.tolerance(tolerance), whole("most_sweeps", most_sweeps)
    value, sweeps = soft.bellman.start(initial), 0
    while True:
        last, sweeps = soft.backup(value), sweeps + 1
        bound = soft.bound(last)
        settled = last.change <= SETTLED * soft.rounding(last.value)
        if bound <= wanted or settled or sweeps == most:
            break
        value = soft.improved(last)
    if not np.isfinite(bound) and sweeps < most:
        raise PlanningError(ENDLESS)
    status = PlanStatus.SOLVED if bound <= wanted else PlanStatus.ROUNDING if settled else PlanStatus.LIMIT
    if status is not PlanStatus.SOLVED and not allow_unconverged:
        told = f"error bound {bound:.3g}, tolerance {wanted:.3g}, {sweeps} sweeps"
        raise PlanningError(f"soft planning: {status.value}, or allow_unconverged=True ({told})")
    made = (frozen(last.value), frozen(last.action_values), frozen(last.policy))
    return SoftPlan(*made, soft.temperature, status, bound, sweeps)


class _Backup(NamedTuple):
    """v, T v, and the action values and policy that gave it."""

    before: Floats
    value: Floats
    action_values: Floats
    policy: Floats

    @property
    def change(self) -> float:
        """max |T v − v|."""
        return float(np.abs(self.value - self.before).max())


@dataclass(frozen=True, eq=False)
class _SoftBellman:
    """The operator (T v)(s) = T log Σ_a exp((r + γ Σ P v)/T)."""

    bellman: Bellman
    temperature: float

    def tolerance(self, given: float | None) -> float:
        """``given``, or the default; raises ``InputError`` where values would be too large for a number."""
        modulus = self.bellman.modulus
        size = self.bellman.largest + self.temperature * np.log(self.bellman.mdp.n_actions)
        with np.errstate(over="ignore"):
            largest = float(size / (1 - modulus if modulus < 1 else 1))
        if not largest < np.inf:
            found = f"values up to {largest:g}"
            raise InputError("temperature", found=found, wanted="one at which entropy over time is finite")
        usual = (CLOSE if modulus < 1 else CLOSE_AT_1) * largest
        return positive("tolerance", usual if given is None else given, zero=True)

    def backup(self, value: Floats) -> _Backup:
        """T v; actions that are not available have no part in the sum."""
        mdp, temperature = self.bellman.mdp, self.temperature
        shape = mdp.available.shape
        ahead = self.bellman.each.reshape(shape) + mdp.discount * (mdp.matrix @ value).reshape(shape)
        table = np.where(mdp.available, ahead, -np.inf)
        peak = np.where(mdp.terminal, 0.0, table.max(axis=1))
        with np.errstate(over="ignore"):
            weight = np.exp((table - peak[:, None]) / temperature)
        total = np.where(mdp.terminal, 1.0, weight.sum(axis=1))
        after = np.where(mdp.terminal, self.bellman.ending, peak + temperature * np.log(total))
        return _Backup(value, after, table, weight / total[:, None])

    def improved(self, last: _Backup) -> Floats:
        """(S,) the value of the policy of ``last``, entropy included."""
        try:
            step = Flow(self.bellman.mdp, last.policy).backwards(last.value - last.before)
        except RuntimeError:
            raise PlanningError(ENDLESS) from None
        if not np.isfinite(step).all():
            raise PlanningError(ENDLESS)
        return np.asarray(last.before + step)

    def rounding(self, value: Floats) -> float:
        """Largest rounding error of one computed backup."""
        actions = self.bellman.mdp.n_actions
        return self.bellman.rounding(value) + (actions + 4 + float(np.log(actions))) * ULP * self.temperature

    def bound(self, last: _Backup) -> float:
        """Largest error of ``last.value``."""
        floor, modulus = self.rounding(last.value), self.bellman.modulus
        if modulus < 1:
            return (modulus * last.change + floor) / (1 - modulus)
        return self._between(last, 2 * last.change + 8 * floor)

    def _between(self, last: _Backup, margin: float) -> float:
        """At discount 1: with u the expected steps to an end, v ± margin·u, if a backup moves both towards each other.

        All soft policies end, so that there is one fixed point only, and it lies between the two.
        """
        mdp = self.bellman.mdp
        try:
            steps = Flow(mdp, last.policy).backwards((~mdp.terminal).astype(float))
        except RuntimeError:
            return np.inf
        if not (np.isfinite(steps).all() and (steps >= 0).all()):
            return np.inf
        low, high = last.before - margin * steps, last.before + margin * steps
        under, over, slack = self.backup(low).value, self.backup(high).value, 2 * self.rounding(high)
        inner = ~mdp.terminal
        if not ((under - slack >= low)[inner].all() and (over + slack <= high)[inner].all()):
            return np.inf
        return float(np.maximum(high - last.value, last.value - low).max())
