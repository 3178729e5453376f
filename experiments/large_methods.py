"""The methods of figure 5-3, each timed from a world and a demonstration to what it learned."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.large_grids import CONFIDENCE, Case
from subgoal.answers.scores import policy_loss, zero_one_loss
from subgoal.candidates import Candidates
from subgoal.irl.apprenticeship import apprenticeship
from subgoal.irl.apprenticeship_local import apprenticeship_in_envelope
from subgoal.likelihood.planned_actions import NATS, PlannedActions, planned_actions
from subgoal.likelihood.planners import Planner
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.iteration import action_values, value_iteration
from subgoal.mdp.planners.outcome import PlanningWarning, PlanStatus
from subgoal.mdp.planners.policy import greedy_actions
from subgoal.mdp.planners.rtdp import rtdp_subgoals
from subgoal.mdp.planners.subgoal_plan import SubgoalPlan
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.sample import ConvergenceWarning, sample
from subgoal.runtime.checks import Floats, Ints

SWEEPS, EXACT = "BNIRL, value iteration", "BNIRL, first passage"
RTDP, PARALLEL = "BNIRL, RTDP", "BNIRL, RTDP, two threads"
ABBEEL, ABBEEL_RTDP = "Abbeel-Ng", "Abbeel-Ng, RTDP"
TOLERANCE = NATS / (2 * CONFIDENCE)
"""Error of an action value by which no log probability is wrong by more than 0.01 nats."""
SAMPLING: dict[str, Any] = {"draws": 200, "warmup": 200, "thin": 1, "chains": 2}
SEARCH: dict[str, Any] = {"margin": 0.01, "most_iterations": 30}
"""Of Abbeel and Ng's method, with the indicators of the demonstrated states as features."""
MOST_STATES, VALUE_TOLERANCE = 5_000, 0.5
"""Of its envelope, and of the values of its reward there; the weights of the reward have length one."""


@dataclass(frozen=True)
class Measured:
    """One method on one draw.

    Attributes
    ----------
    seconds, wall_seconds:
        Of the processor, or by the clock with two threads; by the clock.
    planning_seconds:
        The part of ``seconds`` until the table of the likelihood was there; None where planning is all there is.
    loss:
        Share of the demonstrated actions that are not those of the learned policy, ties broken at random; where there
        are bounds, actions that may be the best for all that these say are tied.
    loss_of_the_middle:
        The same of the policy that takes the best action by the middle of the bounds.
    gap:
        No log probability is wrong by more nats; None where there is no likelihood.
    value_bound:
        No value of Abbeel and Ng's reward is wrong by more.
    inside:
        States in the largest envelope.
    """

    seconds: float
    wall_seconds: float
    candidates: int
    planning_seconds: float | None = None
    loss: float | None = None
    loss_of_the_middle: float | None = None
    gap: float | None = None
    value_bound: float | None = None
    inside: int | None = None
    budget_reached: bool = False
    scaled_from: int | None = None


class Watch:
    """Seconds since it was made."""

    def __init__(self, *, clock: bool = False) -> None:
        self.clock, self.begin = clock, (time.process_time(), time.perf_counter())

    @property
    def wall(self) -> float:
        """By the clock."""
        return time.perf_counter() - self.begin[1]

    @property
    def seconds(self) -> float:
        """Of the processor, unless the clock was asked for."""
        return self.wall if self.clock else time.process_time() - self.begin[0]


def candidates_of(states: Any, most: int | None) -> Candidates:
    """The states on the way, or ``most`` of them, the last among them."""
    goals = np.unique(states)
    if most is not None and goals.size > most:
        goals = np.unique(np.append(states[-1], goals[np.linspace(0, goals.size - 1, most).astype(int)][: most - 1]))
    return Candidates.from_states(goals)


def bnirl_with(planner: Planner, workers: int = 1) -> Callable[[Case, int | None], Measured]:
    """BNIRL on a draw, with all states on the way as candidates or a few of them."""

    def measured(case: Case, most: int | None = None) -> Measured:
        watch, world = Watch(clock=workers > 1), case.world()
        known: Any = world.mdp if isinstance(world, GridWorld) and planner is not rtdp_subgoals else world
        demos = case.demonstrations(world)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)
            warnings.simplefilter("ignore", PlanningWarning)
            likelihood = planned_actions(
                demos, candidates_of(demos.states, most), known, confidence=CONFIDENCE, tolerance=TOLERANCE,
                planner=planner, workers=workers,
            )  # fmt: skip
            planning = watch.seconds
            posterior = sample(likelihood, seed=case.seed, workers=workers, **SAMPLING)
            seconds, wall = watch.seconds, watch.wall
        source: Any = likelihood.source
        likely = np.asarray(posterior.shares.argmax(axis=1)).ravel()
        return Measured(
            seconds, wall, likelihood.n_candidates, planning, assigned_loss(source, likely),
            None if source.plan.half_gap is None else middle_loss(source, likely),
            source.largest_error(CONFIDENCE), inside=source.plan.n_inside or None,
            budget_reached=source.plan.status is PlanStatus.BUDGET,
        )  # fmt: skip

    return measured


def assigned_loss(source: PlannedActions, assigned: Ints) -> float:
    """Share of the actions that are not among the best for the candidate each is assigned to, ties at random.

    Where planning was exact, the best are found anew to rounding, for the candidates that are assigned; where there are
    bounds, they are those that may be the best.
    """
    used, column = np.unique(assigned, return_inverse=True)
    if source.plan.half_gap is None:
        goals = [source.goal_sets[g] for g in used]
        best = plan_subgoals(source.table, goals, states=source.plan.states, relative=True).optimal
    else:
        best = source.plan.optimal[:, :, used]
    return policy_loss(best[source.rows, :, column], source.actions) / assigned.size


def middle_loss(source: PlannedActions, assigned: Ints) -> float:
    """Share of the actions that are not the best by the middle of the bounds."""
    values = source.plan.action_values[source.rows, :, assigned]
    return policy_loss(greedy_actions(values), source.actions) / assigned.size


def plain(
    mdp: TabularMDP, goals: Any, *, states: Any, convention: Any = "continuing", tolerance: float, **unused: Any
) -> SubgoalPlan:
    """Value iteration for one candidate after the other, on all states: the thesis's way, as a planner."""
    kept = np.asarray(states)
    value, rows, sweeps, worst = [], [], 0, 0.0
    for goal in goals:
        reward = np.zeros(mdp.n_states)
        reward[goal] = 1.0
        plan = value_iteration(mdp, reward, tolerance=tolerance)
        value.append(plan.value[kept])
        rows.append(action_values(mdp, plan.value, reward)[kept])
        sweeps, worst = sweeps + plan.sweeps, max(worst, plan.error_bound)
    return SubgoalPlan(
        kept, np.stack(value, axis=1), np.stack(rows, axis=2), convention, worst, tolerance, PlanStatus.SOLVED, sweeps,
        sweeps * mdp.n_states,
    )  # fmt: skip


def plain_on_a_few(case: Case, most: int | None = None) -> Measured:
    """BNIRL by plain value iteration; where ``most`` is less than there are candidates, planning alone, scaled up."""
    states = np.unique(case.demonstrations(case.world()).states)
    if most is None or most >= states.size:
        return bnirl_with(plain)(case, None)
    watch, world = Watch(), case.world()
    mdp: Any = world.mdp  # type: ignore[union-attr]
    table, table_wall = watch.seconds, watch.wall
    few = states[np.linspace(0, states.size - 1, most).astype(int)]
    plain(mdp, few[:, None], states=states, tolerance=TOLERANCE)
    times = states.size / most
    seconds = table + (watch.seconds - table) * times
    wall = table_wall + (watch.wall - table_wall) * times
    return Measured(seconds, wall, states.size, seconds, scaled_from=most)


def abbeel(case: Case, most: int | None = None) -> Measured:
    """Abbeel and Ng's method on the whole world."""
    watch, world = Watch(), case.world()
    demos, mdp = case.demonstrations(world), world.mdp  # type: ignore[union-attr]
    own = np.unique(demos.states)
    features = (np.arange(mdp.n_states)[:, None] == own).astype(float)
    found = apprenticeship(demos, mdp, features, **SEARCH)
    seconds, wall = watch.seconds, watch.wall
    return Measured(seconds, wall, own.size, loss=_loss(found.policy[demos.states], case))


def abbeel_rtdp(case: Case, most: int | None = None) -> Measured:
    """The same inside an envelope."""
    watch, world = Watch(), case.world()
    demos = case.demonstrations(world)
    own = np.unique(demos.states)
    found = apprenticeship_in_envelope(
        demos, world, lambda states: (states[:, None] == own).astype(float), support=own, most_states=MOST_STATES,
        tolerance=VALUE_TOLERANCE, **SEARCH,
    )  # fmt: skip
    seconds, wall = watch.seconds, watch.wall
    return Measured(
        seconds, wall, own.size, loss=_loss(found.policy_at(demos.states), case), value_bound=found.error_bound,
        inside=found.bounds.envelope.n_inside, budget_reached=found.status is PlanStatus.BUDGET,
    )  # fmt: skip


def _loss(policy: Floats, case: Case) -> float:
    return zero_one_loss(policy, case.actions)


METHODS: dict[str, Callable[[Case, int | None], Measured]] = {
    SWEEPS: plain_on_a_few,
    EXACT: bnirl_with(plan_subgoals),
    RTDP: bnirl_with(rtdp_subgoals),
    PARALLEL: bnirl_with(rtdp_subgoals, workers=2),
    ABBEEL: abbeel,
    ABBEEL_RTDP: abbeel_rtdp,
}
