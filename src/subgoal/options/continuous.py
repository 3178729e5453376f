"""Options (thesis 6.6) in a continuous world: where to begin, what to do, when to stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.dynamics.refinement import climb, pattern
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.goal_values import GoalValues
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, positive, real_array, whole
from subgoal.runtime.errors import InputError

STARTS, ROUNDS = 4, 4
ROWS = 2**17
"""Action values that are made at once."""


@dataclass(frozen=True, eq=False, repr=False)
class ContinuousOption:
    """A closed-loop skill in a continuous world.

    Attributes
    ----------
    name:
        What it is called, such as "subgoal 1".
    goal:
        (d,) s_g.
    values:
        V of this goal alone.
    world:
        The model that it looks ahead in: dynamics, bounds and test actions.
    metric, radius:
        What is near, and ε in units of it.
    initiation:
        (n, d) states near which it may begin (6.4), or None: anywhere.
    candidate:
        Number of the goal among the candidates of the posterior it was learned by, if it was.
    starts, rounds:
        Refinement of its actions: from how many of the best test actions, and how often the spacing is halved. Values
        have several maxima over the actions; from one start, or with less refinement, it loses unstable steady states.
    names:
        Of the dimensions of the states, if they have some.
    """

    name: str
    goal: Floats
    values: GoalValues
    world: ContinuousWorld
    metric: Metric
    radius: float
    initiation: Floats | None = None
    candidate: int | None = None
    starts: int = STARTS
    rounds: int = ROUNDS
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if len(self.values.goals) != 1:
            raise InputError("values", found=f"{len(self.values.goals)} goals", wanted="one")
        for what, value in (("goal", self.goal), ("initiation", self.initiation)):
            if value is None:
                continue
            array = real_array(what, value, ndim=1 if what == "goal" else 2)
            if array.shape[-1] != self.metric.dimension:
                raise InputError(what, found=f"shape {array.shape}", wanted=f"{self.metric.dimension} columns")
            object.__setattr__(self, what, array)
        object.__setattr__(self, "radius", positive("radius", self.radius))
        object.__setattr__(self, "starts", whole("starts", self.starts))
        object.__setattr__(self, "rounds", whole("rounds", self.rounds, least=0))

    def __repr__(self) -> str:
        begins = "anywhere" if self.initiation is None else f"near {len(self.initiation)} states"
        goal = ", ".join(f"{value:.2f}" for value in self.goal)
        return f"ContinuousOption({self.name!r}: begins {begins}, ends within {self.radius:g} of ({goal}))"

    def may_begin(self, states: Any) -> Bools:
        """(B,) whether states (B, d) are in I_o: closer than ε to a state of ``initiation`` (6.4)."""
        at = self._states(states)
        if self.initiation is None:
            return np.ones(len(at), bool)
        near = [np.asarray(self.metric.distance(each, self.initiation)).min() for each in at]
        return np.array(near) < self.radius

    def over(self, states: Any) -> Bools:
        """(B,) β_o: whether states (B, d) are closer than ε to the goal (6.6)."""
        return self.distance(states) < self.radius

    def distance(self, states: Any) -> Floats:
        """(B,) of states (B, d) to the goal, in units of the metric."""
        return np.asarray(self.metric.distance(self._states(states), self.goal))

    def action_values(self, states: Any, actions: Any) -> Floats:
        """(B, M) Q(s, a), the share of the discounted future spent at the goal, of actions (B, M, k) in states (B, d).

        One step of the world is looked ahead, whatever the time between two decisions.
        """
        at, tried = self._states(states), real_array("actions", actions, ndim=3)
        shape = tried.shape[:2]
        ahead = self.world.ahead(np.repeat(at, shape[1], axis=0), tried.reshape(-1, tried.shape[2]), self.metric)
        return np.asarray(self.values.action_values(ahead)).reshape(shape)

    def policy(self, states: Any) -> Floats:
        """(B, k) π_o(s) = argmax_a Q(s, a) (6.5) in states (B, d), within the bounds of the actions.

        The best of the test actions, and from ``starts`` of them at once the best neighbour, ``rounds`` times, each at
        half the spacing of the last. Refinement never lowers Q. Raises ``InputError`` for states that are not (B, d) or
        not finite.
        """
        at = self._states(states)
        rows = max(1, ROWS // max(len(self.world.test_actions), self.starts * len(pattern(self.world.low.size))))
        parts = [self._greedy(at[first : first + rows]) for first in range(0, len(at), rows)]
        return np.concatenate([np.empty((0, self.world.low.size)), *parts])

    def _greedy(self, at: Floats) -> Floats:
        tests = self.world.test_actions
        worth = self.action_values(at, np.broadcast_to(tests, (len(at), *tests.shape)))
        top = np.argsort(-worth, axis=1, kind="stable")[:, : self.starts]
        return climb(self.world, tests[top], lambda tried: self.action_values(at, tried), self.rounds)[0]

    def _states(self, states: Any) -> Floats:
        at = real_array("states", states, ndim=2)
        if at.shape[1] != self.metric.dimension:
            raise InputError("states", found=f"shape {at.shape}", wanted=f"(B, {self.metric.dimension})")
        return at


def option(
    posterior: Posterior, candidate: int, *, begin: str = "anywhere", radius: float | None = None
) -> ContinuousOption:
    """The option of one candidate of a posterior of ``gpsrl``.

    Parameters
    ----------
    candidate:
        Its index, such as ``goal.candidate`` of a merged subgoal.
    begin:
        "anywhere", or "served": only near a demonstrated state that the best draw assigns to the candidate (6.4).
    radius:
        ε; by default that of the candidates.

    Raises ``InputError`` for a candidate that does not exist, one that nothing is assigned to if ``begin`` is "served",
    or a posterior that was not planned for by Gaussian processes.
    """
    source = None if posterior.likelihood is None else posterior.likelihood.source
    if not isinstance(source, GaussianProcessValues):
        raise InputError("posterior", found=f"likelihood {posterior.settings.likelihood!r}",
                         wanted="one that was sampled from gp_actions",
                         hint="subgoal.gpsrl(demonstrations, world)")  # fmt: skip
    g = whole("candidate", candidate, least=0)
    candidates = posterior.candidates
    if g >= candidates.n_candidates:
        raise InputError("candidate", found=g, wanted=f"0 to {candidates.n_candidates - 1}")
    if begin not in ("anywhere", "served"):
        raise InputError("begin", found=repr(begin), wanted="'anywhere' or 'served'")
    served = np.asarray(posterior.demonstrations.states)[posterior.best_assignment == g]
    if begin == "served" and not len(served):
        used = ", ".join(str(each) for each in np.unique(posterior.best_assignment))
        raise InputError("candidate", found=f"{g}, which serves nothing in the best draw", wanted=f"one of {used}",
                         hint="begin='anywhere'")  # fmt: skip
    return ContinuousOption(
        candidates.name(g) or f"candidate {g}", candidates.points[g], source.plan.only([g]), source.world,
        candidates.metric, candidates.radius if radius is None else radius,
        None if begin == "anywhere" else served, g, names=posterior.demonstrations.names,
    )  # fmt: skip
