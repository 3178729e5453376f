"""Options (thesis 2.1, 6.6) in a discrete world: where to begin, what to do, when to stop; and running them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from subgoal.answers.predictions import planned_source
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.policy import uniform_policy
from subgoal.mdp.simulation import simulate
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, frozen, real_array, whole
from subgoal.runtime.errors import InputError


@dataclass(frozen=True, eq=False, repr=False)
class Option:
    """A closed-loop skill in a discrete world.

    Attributes
    ----------
    name:
        What it is called, such as "subgoal 1".
    initiation:
        (S,) booleans I_o: states in which it may begin (6.4); none for which the goal is beyond all discount.
    policy:
        (S, A) probabilities π_o (6.5); uniform over what is legal where the goal is out of reach.
    termination:
        (S,) booleans β_o: states in which it is over (6.6).
    """

    name: str
    initiation: Bools
    policy: Floats
    termination: Bools

    def __post_init__(self) -> None:
        policy = real_array("policy", self.policy, ndim=2)
        for what in ("initiation", "termination"):
            array = np.array(getattr(self, what))
            if array.dtype != bool or array.shape != policy.shape[:1]:
                raise InputError(what, found=f"{array.dtype} of shape {array.shape}",
                                 wanted=f"booleans of shape {policy.shape[:1]}")  # fmt: skip
            object.__setattr__(self, what, frozen(array))
        object.__setattr__(self, "policy", policy)

    def __repr__(self) -> str:
        told = f"begins in {int(self.initiation.sum())} states, ends in {int(self.termination.sum())}"
        return f"Option({self.name!r}: {told} of {len(self.policy)})"


def option(posterior: Posterior, candidate: int, *, begin: str = "anywhere") -> Option:
    """The option of one candidate of a posterior that was made by planning in a discrete world.

    Parameters
    ----------
    candidate:
        Its index, such as ``goal.candidate`` of a merged subgoal.
    begin:
        "anywhere": every state from which the goal can be reached. "served": only states with an observation that the
        best draw assigns to the candidate, as in (6.4).

    The policy is optimal for the candidate's reward, uniform over ties (6.5); the option ends in the candidate's states
    (6.6). Raises ``InputError`` for a candidate that does not exist or a posterior without planned actions.
    """
    source = planned_source(posterior)
    g = whole("candidate", candidate, least=0)
    sets: Any = posterior.candidates.goal_sets
    if g >= len(sets):
        raise InputError("candidate", found=g, wanted=f"0 to {len(sets) - 1}")
    made = goal_option(source.table, sets[g], name=posterior.candidates.name(g) or f"candidate {g}")
    if begin == "anywhere":
        return made
    if begin != "served":
        raise InputError("begin", found=repr(begin), wanted="'anywhere' or 'served'")
    served = np.zeros(source.table.n_states, bool)
    served[posterior.demonstrations.states[posterior.best_assignment == g]] = True
    return replace(made, initiation=served & made.initiation)


def goal_option(mdp: TabularMDP, goal: Any, *, name: str = "goal") -> Option:
    """The option that goes to ``goal``, a state or a set of states, and ends there.

    Its policy is optimal for a reward at every visit (4.1), so that it stays at the goal, or near it, when it is held.
    """
    check_world(mdp)
    members = np.atleast_1d(np.asarray(goal))
    states = np.flatnonzero(~mdp.terminal)
    plan = plan_subgoals(mdp, [members], states=states, relative=True)
    policy = np.zeros((mdp.n_states, mdp.n_actions))
    policy[states] = uniform_policy(plan.optimal[:, :, 0])
    reached = np.zeros(mdp.n_states, bool)
    reached[states] = ~plan.unreachable[:, 0]
    there = np.zeros(mdp.n_states, bool)
    there[members] = True
    return Option(name, (reached | there) & ~mdp.terminal, policy, there)


def execute(
    option: Option, mdp: TabularMDP, *, start: Any, steps: int, hold: bool = False, trajectories: int = 1, seed: int = 0
) -> Demonstrations:
    """Run an option in the world from ``start`` until it ends, or for ``steps`` actions; with ``hold``, past its end.

    Returns what was done as demonstrations, ``truncated`` where the option did not end. ``start`` is a state, or one
    for each of ``trajectories``. Trajectory k hangs on the seed and on k alone. Raises ``InputError`` for a start
    outside the initiation set or, unless it is held, where the option is over already, naming the state.
    """
    check_world(mdp)
    if len(option.policy) != mdp.n_states:
        raise InputError("option", found=f"{len(option.policy)} states", wanted=f"{mdp.n_states}, as the world")
    first = check_states("start", start, mdp.n_states)
    count = whole("trajectories", trajectories)
    if first.shape not in ((), (count,)):
        raise InputError("start", found=f"shape {first.shape}", wanted=f"one state or {count}")
    first = np.broadcast_to(first, (count,))
    ends = mdp.terminal if hold else option.termination | mdp.terminal
    for bad, wanted in (
        (~option.initiation[first], "a state of the initiation set"),
        (ends[first], "a state in which the option is not over"),
    ):
        if bad.any():
            raise InputError("start", found=f"state {first[np.argmax(bad)]}", wanted=wanted)
    return simulate(ended_at(mdp, ends), option.policy, steps=steps, trajectories=trajectories, start=first, seed=seed)


def ended_at(mdp: TabularMDP, ends: Bools) -> TabularMDP:
    """The same world with episodes over on entering ``ends`` (S,)."""
    legal = mdp.available & ~ends[:, None]
    kept = np.repeat(legal.ravel(), np.diff(mdp.offset))
    sizes = np.where(legal.ravel(), np.diff(mdp.offset), 0)
    return replace(
        mdp, offset=np.concatenate([[0], np.cumsum(sizes)]), successor=mdp.successor[kept],
        probability=mdp.probability[kept], available=legal, terminal=mdp.terminal | ends, start=None,
    )  # fmt: skip
