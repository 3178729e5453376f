"""What an execution came to: whether the goal was reached and held, and how far it was from what was demonstrated."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from subgoal.demonstrations.held import time_step
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.options.continuous import ContinuousOption
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, frozen, positive, whole
from subgoal.runtime.errors import InputError

LAST = 1.0
"""Time at the end of an execution over which the goal must be held."""


@dataclass(frozen=True, eq=False, repr=False)
class Outcome:
    """What each of D executions of an option came to.

    Attributes
    ----------
    reached:
        (D,) time from the start at which it was first within ε of the goal; infinity if it never was.
    share_held:
        (D,) share of the last states that are no farther from the goal than was asked.
    rms:
        (D, d) root mean square difference from the goal in each dimension over the last states, in its own units.
    distance:
        (D,) largest distance from the goal over the last states, in units of the metric.
    """

    reached: Floats
    share_held: Floats
    rms: Floats
    distance: Floats

    @property
    def held(self) -> Bools:
        """(D,) whether it was held throughout."""
        return np.asarray(self.share_held == 1)

    def __repr__(self) -> str:
        arrived = int(np.isfinite(self.reached).sum())
        return f"Outcome(of {len(self.reached)} executions {arrived} reach the goal, {int(self.held.sum())} hold it)"


def outcome(
    option: ContinuousOption, runs: Demonstrations, *, within: float | None = None, last: float = LAST
) -> Outcome:
    """Whether ``runs``, made by ``execute``, reached the goal of ``option`` and held it.

    ``within`` (by default ε), in units of the metric, is what counts as held, and ``last`` the time at the end over
    which it must be, in the unit of the times; the state after the last action is one of those that count. Raises
    ``InputError`` for runs without even times.
    """
    least = positive("within", option.radius if within is None else within)
    step = time_step(runs)
    count = max(1, round(positive("last", last) / step)) + 1
    reached, share, rms, far = [], [], [], []
    for states in trajectories(runs):
        distance = option.distance(states)
        near = distance < option.radius
        reached.append(step * int(np.argmax(near)) if near.any() else np.inf)
        end = option.metric.difference(option.goal, states[-count:]) / option.metric.weights
        share.append((distance[-count:] <= least).mean())
        rms.append(np.sqrt((end**2).mean(axis=0)))
        far.append(distance[-count:].max())
    return Outcome(*(frozen(np.array(each)) for each in (reached, share, rms, far)))


def trajectories(runs: Demonstrations) -> list[Floats]:
    """D arrays (T + 1, d): the states of each trajectory, and the one it ended in."""
    states = np.split(np.asarray(runs.states), runs.offset[1:-1])
    return [np.concatenate([part, end[None]]) for part, end in zip(states, runs.final_states, strict=True)]


def stretches(posterior: Posterior, candidate: int, *, shortest: int = 1) -> Demonstrations:
    """What was demonstrated of one candidate: each run of at least ``shortest`` pairs that the best draw assigns to it.

    Times are as demonstrated; each ends in the state after its last pair. Raises ``InputError`` where there is none.
    """
    g, demos = whole("candidate", candidate, least=0), posterior.demonstrations
    shortest = whole("shortest", shortest)
    another = np.diff(posterior.best_assignment, prepend=-2) != 0
    begins = np.flatnonzero(another | (np.diff(demos.trajectory, prepend=-1) != 0))
    ends = np.append(begins[1:], demos.n_observations)
    kept = (posterior.best_assignment[begins] == g) & (ends - begins >= shortest)
    if not kept.any():
        raise InputError("candidate", found=f"{g}, never served for {shortest} pairs in the best draw",
                         wanted="one with such a stretch", hint="another candidate, or a smaller shortest")  # fmt: skip
    begins, ends = begins[kept], ends[kept]
    rows = np.concatenate([np.arange(a, b) for a, b in zip(begins, ends, strict=True)])
    over, states, own = np.isin(ends, demos.offset[1:]), np.asarray(demos.states), demos.trajectory[begins]
    after = np.where(over[:, None], demos.final_states[own], states[np.minimum(ends, len(states) - 1)])
    return Demonstrations(
        states=states[rows], actions=np.asarray(demos.actions)[rows], offset=np.cumsum([0, *(ends - begins)]),
        times=None if demos.times is None else demos.times[rows], final_states=after,
        truncated=demos.truncated[own] & over, names=demos.names, time_unit=demos.time_unit, source=demos.source,
    )  # fmt: skip


def deviation(metric: Metric, runs: Demonstrations, shown: Demonstrations, *, after: float = 0.0) -> Floats:
    """(D, d) root mean square difference of trajectory k of ``runs`` from trajectory k of ``shown``, moment by moment.

    In the units of each dimension, over the moments since the start that both have; the share ``after`` of them at the
    beginning is left out. Raises ``InputError`` for another number of trajectories, a share of 1 or more, and where the
    steps of ``shown`` are not whole multiples of those of ``runs``.
    """
    left_out = positive("after", after, zero=True)
    if not left_out < 1:
        raise InputError("after", found=after, wanted="a share below 1")
    if runs.n_trajectories != shown.n_trajectories:
        raise InputError("runs", found=f"{runs.n_trajectories} trajectories", wanted=f"{shown.n_trajectories}")
    ratio = time_step(shown) / time_step(runs)
    stride = max(1, round(ratio))
    if not abs(ratio - stride) < 1e-6 * stride:
        raise InputError("shown", found=f"steps of {ratio:g} times those of the runs", wanted="a whole multiple",
                         hint="execute(..., every=...)")  # fmt: skip
    out = []
    for ours, theirs in zip(trajectories(runs), trajectories(shown), strict=True):
        ours = ours[::stride][: len(theirs)]
        off = metric.difference(theirs[: len(ours)], ours) / metric.weights
        out.append(np.sqrt((off[int(left_out * len(off)) :] ** 2).mean(axis=0)))
    return np.array(out)
