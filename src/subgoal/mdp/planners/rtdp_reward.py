"""Real-time dynamic programming with bounds for any bounded reward, so that single-reward methods run on it too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal._kernels import envelope as loops
from subgoal.mdp.local_world import LocalWorld, local_world
from subgoal.mdp.planners.envelope import Envelope
from subgoal.mdp.planners.growing import COVER_RINGS, largest_excess, ring_limit
from subgoal.mdp.planners.outcome import PlanStatus
from subgoal.mdp.planners.rtdp import MOST_STATES
from subgoal.runtime.checks import Bools, Floats, Ints, positive, whole
from subgoal.runtime.errors import InputError

StateReward = Callable[[Ints], Any]
"""``reward(states (M,))`` gives (M,) rewards R(s)."""
FINE, FINEST = 0.02, 1e-12
MOST_SWEEPS, FLOW_SWEEPS = 100_000, 200
PART = 4096
"""States that are asked at a time how far the support is."""


@dataclass(frozen=True, eq=False)
class RewardBounds:
    """Bounds of the optimal values of one reward around some states.

    Attributes
    ----------
    states:
        (U,) the states asked for.
    value:
        (2, U) lower and upper bound of V*.
    action_values:
        (2, U, A) of Q*, −inf for illegal actions.
    status:
        SOLVED where no two bounds are further apart than twice the tolerance.
    envelope:
        The states looked at; ``envelope.sub_world()`` makes a world of them.
    """

    states: Ints
    value: Floats
    action_values: Floats
    status: PlanStatus
    envelope: Envelope

    @property
    def error_bound(self) -> float:
        """Half of the largest gap: no middle of two bounds is further from the exact value."""
        legal = np.isfinite(self.action_values[0])
        gap = np.subtract(self.action_values[1], self.action_values[0], where=legal, out=np.zeros(legal.shape))
        return float(max(gap.max(), (self.value[1] - self.value[0]).max()) / 2)


def rtdp_reward(
    world: Any,
    reward: StateReward,
    *,
    states: Any,
    least: float,
    most: float,
    support: Any = None,
    tolerance: float | None = None,
    most_states: int = MOST_STATES,
    envelope: Envelope | None = None,
) -> RewardBounds:
    """Bounds of V*(s) = R(s) + γ max_a Σ P(s' | s, a) V*(s') and Q* at U states, from an envelope around these.

    Parameters
    ----------
    world:
        As in ``rtdp_subgoals``.
    reward:
        R(s) for being in s now, as a function of an array of states.
    states:
        (U,) states whose values are wanted.
    least, most:
        Bounds of R: outside the envelope V* is between least/(1 − γ) and most/(1 − γ).
    support:
        (K,) states beyond which R is zero, if that is known: then V* is nearer zero the longer it takes to get there.
    tolerance:
        Largest error of an action value; default: 1e-3 of (most − least)/(1 − γ).
    most_states:
        As in ``rtdp_subgoals``; where it is reached the status is BUDGET.
    envelope:
        Of an earlier reward in the same world, to go on from; it is grown in place.

    Raises
    ------
    InputError
        States that do not exist, a discount of 1, bounds in the wrong order, rewards beyond them.
    """
    seen = local_world(world)
    if not seen.discount < 1:
        raise InputError("discount", found=seen.discount, wanted="below 1")
    if not least <= most or not np.isfinite([least, most]).all():
        raise InputError(
            "least, most", found=f"{least}, {most}", wanted="finite numbers, the first not above the second"
        )
    top = (most - least) / (1 - seen.discount)
    wanted = max(1e-3 * top, 1e-12) if tolerance is None else positive("tolerance", tolerance)
    kept = np.atleast_1d(seen.check("states", states))
    known = np.unique(seen.check("support", np.zeros(0, np.int64) if support is None else support))
    outside = _Outside(seen, least, most, known if support is not None else None, _told(reward, known, least, most))
    growing = _Growing(seen, reward, kept, outside, wanted, whole("most_states", most_states), envelope)
    while not growing.step():
        growing.grow()
    return growing.answer()


@dataclass(frozen=True, eq=False)
class _Outside:
    """What is known of V* without looking."""

    world: LocalWorld
    least: float
    most: float
    support: Ints | None
    own: Floats
    """(K,) rewards of the support."""

    def bounds(self, states: Ints) -> Floats:
        """(M, 2)."""
        ends = np.array([self.least, self.most]) / (1 - self.world.discount)
        if self.support is None:
            return np.tile(ends, (states.size, 1))
        held = np.stack([np.minimum(self.own, 0.0), np.maximum(self.own, 0.0)], axis=1) / (1 - self.world.discount)
        parts = [states[i : i + PART] for i in range(0, states.size, PART)]
        told = [self.world.reach_bound(part, self.support) @ held for part in parts]
        return np.asarray(np.clip(np.concatenate([np.zeros((0, 2)), *told]), min(ends[0], 0.0), max(ends[1], 0.0)))


class _Growing:
    """One envelope and the two bounds of one reward."""

    def __init__(
        self, world: LocalWorld, reward: StateReward, states: Ints, outside: _Outside, tolerance: float,
        most_states: int, envelope: Envelope | None,
    ) -> None:  # fmt: skip
        self.world, self.reward_of, self.states, self.outside = world, reward, states, outside
        self.tolerance, self.most_states, self.fine = tolerance, most_states, FINE
        self.envelope = Envelope(world) if envelope is None else envelope
        here = np.unique(self.envelope.meet(states))
        self.envelope.expand(here[~self.envelope.inside[here]])
        self.roots = np.unique(np.concatenate([here, self.envelope.action_rows(states).successor]))
        self.value, self.reward = np.zeros((0, 2)), np.zeros(0)
        self.gap = np.inf

    def step(self) -> bool:
        """Back up both bounds inside; whether that is the end."""
        envelope = self.envelope
        new = envelope.states[len(self.value) :].copy()
        told = _told(self.reward_of, new, self.outside.least, self.outside.most)
        self.reward = np.concatenate([self.reward, told])
        self.value = np.concatenate([self.value, self.outside.bounds(new)])
        self.table = envelope.table()
        self.order = envelope.order(self.table, self.roots)
        gap = min(self.gap, float((self.value[:, 1] - self.value[:, 0]).max()))
        target = self.fine * max(gap, self.tolerance) * (1 - self.world.discount)
        loops.settle_reward(self.order, max(target, 1e-15), MOST_SWEEPS, *self.table[:5], self.reward, self.value)
        self.rows = self._rows()
        legal = np.isfinite(self.rows[0])
        self.gap = float(np.subtract(self.rows[1], self.rows[0], where=legal, out=np.zeros(legal.shape)).max())
        closed = envelope.inside.all()
        if self.gap <= 2 * self.tolerance:
            self.status = PlanStatus.SOLVED
        elif closed and self.fine <= FINEST:
            self.status = PlanStatus.ROUNDING
        elif not closed and envelope.n_inside >= self.most_states:
            self.status = PlanStatus.BUDGET
        else:
            return False
        return True

    def grow(self) -> None:
        """As for subgoals; what is not known of a state at the edge is the gap of its bounds."""
        envelope = self.envelope
        edge = np.flatnonzero(~envelope.inside)
        apart = self.value[:, 1] - self.value[:, 0]
        excess = np.zeros(envelope.n_met)
        roots = self.roots[apart[self.roots] > 2 * self.tolerance]
        loops.leaving(
            self.order, roots, 1, np.zeros(envelope.n_met, bool), 1e-3 * self.tolerance / max(self.gap, 1e-300),
            FLOW_SWEEPS, *self.table[:5], self.reward, envelope.inside, self.value, apart, excess,
        )  # fmt: skip
        missing = float(apart[self.roots].max())
        if not edge.size or (excess.sum() < missing and self.fine > FINEST):
            self.fine *= 0.1
            return
        most = ring_limit(envelope.n_inside, self.most_states)
        envelope.expand_rings(largest_excess(excess, edge), COVER_RINGS, most, _nothing)

    def _rows(self) -> Floats:
        """(2, U, A) R(s) + γ Σ P(s' | s, a) V(s'), −inf for illegal actions."""
        rows = self.envelope.action_rows(self.states)
        offset, n = rows.offset, self.states.size
        value = rows.probability[:, None] * self.value[rows.successor]
        summed = np.concatenate([np.zeros((1, 2)), np.cumsum(value, axis=0)])
        ahead = self.world.discount * (summed[offset[1:]] - summed[offset[:-1]])
        ahead[np.diff(offset) == 0] = -np.inf
        own = self.reward[self.envelope.places(self.states)]
        return np.asarray(own[:, None] + ahead.reshape(n, -1, 2).transpose(2, 0, 1))

    def answer(self) -> RewardBounds:
        """The frozen record."""
        value = self.value[self.envelope.places(self.states)].T
        return RewardBounds(self.states, value, self.rows, self.status, self.envelope)


def _told(reward: StateReward, states: Ints, least: float, most: float) -> Floats:
    """(M,) rewards, within their bounds."""
    told = np.asarray(reward(states), float)
    if told.shape != states.shape or not ((told >= least) & (told <= most)).all():
        found = f"shape {told.shape}, {told.min(initial=np.inf)} to {told.max(initial=-np.inf)}"
        raise InputError("reward", found=found, wanted=f"({states.size},) numbers of {least} to {most}")
    return told


def _nothing(places: Ints) -> Bools:
    """Without a way to tell what a ring further out is worth, it is left to the next growth."""
    return np.zeros(places.size, bool)
