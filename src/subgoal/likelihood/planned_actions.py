"""The likelihood of thesis (4.2) in a discrete world: a softmax over the action values of optimal plans."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal._kernels.softmax import softmax_tile
from subgoal.candidates.record import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.assigned import ActionValues
from subgoal.likelihood.pairs import check_demonstrations, checked_pairs
from subgoal.likelihood.planners import Planner, plans_exactly, world_and_planner
from subgoal.likelihood.source import Confidence
from subgoal.likelihood.table import DENSE_ENTRIES, LogLikelihood
from subgoal.mdp.local_world import LocalWorld
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.outcome import PlanningWarning, PlanStatus
from subgoal.mdp.planners.subgoal_plan import Convention, SubgoalPlan
from subgoal.mdp.tabular import TabularMDP
from subgoal.runtime.checks import Floats, Ints, positive
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.progress import Progress

DEFAULT_CONFIDENCE = 10.0
LARGEST_PLAN = 2**32
"""Bytes that action values may take."""
NATS = 0.01
"""Largest error of a log probability that planning in an envelope aims at."""


@dataclass(frozen=True, eq=False, repr=False)
class PlannedActions:
    """Source of log π(a | s, g) from action values Q*(s, a) at the states that were observed.

    Attributes
    ----------
    plan:
        Values and action values at the U different states that were observed.
    mdp:
        The world they were planned in: a ``TabularMDP``, or a ``LocalWorld``.
    planner:
        What planned in it: ``plan_subgoals`` or ``rtdp_subgoals``, with its settings.
    legal:
        (U, A) which actions are available in the observed states.
    pair, state_row, action:
        (N,) which different pair each observation is; (P,) row of the plan and action of each pair.
    goal_sets:
        The states of each candidate.
    at_goal:
        (U, G) which observed states belong to which candidate.
    uninformative:
        (N,) observations whose state has one legal action only.
    """

    plan: SubgoalPlan
    mdp: TabularMDP | LocalWorld
    planner: Planner
    legal: NDArray[np.bool_]
    pair: Ints
    state_row: Ints
    action: Ints
    goal_sets: tuple[Ints, ...]
    at_goal: NDArray[np.bool_]
    uninformative: NDArray[np.bool_]
    kind: str = field(default="planned actions", init=False)

    def log_density(self, start: int, stop: int, confidence: Confidence) -> Floats:
        """Complete log probabilities: over the legal actions of a state they sum to one."""
        pairs, where = np.unique(self.pair[start:stop], return_inverse=True)
        out = np.empty((pairs.size, self.at_goal.shape[1]))
        each = np.full(out.shape[1], confidence, float)
        softmax_tile(self.plan.action_values, self.state_row[pairs], self.action[pairs], each, out)
        return out[where]

    @cached_property
    def unit(self) -> float:
        """One over the median difference of best and worst action, over states and candidates in reach."""
        values = np.where(np.isfinite(self.plan.action_values), self.plan.action_values, np.nan)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            spread = (np.nanmax(values, axis=1) - np.nanmin(values, axis=1)).ravel()
        spread = spread[spread > 0]
        return 1.0 / float(np.median(spread)) if spread.size else 1.0

    def log_flat(self, start: int, stop: int) -> Floats:
        """All legal actions alike."""
        return np.asarray(-np.log(self.legal[self.rows[start:stop]].sum(axis=1)))

    def assigned(self, theta: Ints) -> ActionValues:
        """Action values of each observation's candidate."""
        return ActionValues(self.plan.action_values[self.rows, :, theta], self.actions)

    def log_marginal(self, start: int, stop: int, confidence: float, log_prior: Floats) -> None:
        """No shorter way."""

    def arrived(self, start: int, stop: int) -> NDArray[np.bool_]:
        """Whether the state is the candidate, or in its set."""
        return self.at_goal[self.rows[start:stop]]

    def distance_law(self, confidence: float) -> None:
        """Actions are compared by value, not by distance."""

    @cached_property
    def optimal(self) -> NDArray[np.bool_]:
        """(U, A, G) the best actions at the observed states for each candidate, planned for when first asked.

        Where planning gave bounds, those that may be the best for all that these say.
        """
        if self.plan.half_gap is not None or not isinstance(self.mdp, TabularMDP):
            return self.plan.optimal
        return plan_subgoals(
            self.mdp, self.goal_sets, states=self.plan.states, convention=self.plan.convention, relative=True,
            allow_unconverged=True,
        ).optimal  # fmt: skip

    def planned_at(self, states: Ints) -> SubgoalPlan:
        """The same plan with action values of other states (U',)."""
        refuse_large_plan(states.size, self.mdp.n_actions, len(self.goal_sets))
        return self.planner(
            self.mdp, self.goal_sets, states=states, convention=self.plan.convention, tolerance=self.plan.tolerance,
            allow_unconverged=True,
        )  # fmt: skip

    @property
    def table(self) -> TabularMDP:
        """The world as a table. Raises ``InputError`` where it was too large to be written down."""
        if not isinstance(self.mdp, TabularMDP):
            raise InputError("world", found=f"{self.mdp!r}, planned for in part", wanted="a TabularMDP",
                             hint="planned_actions(..., world.mdp) where that fits into memory")  # fmt: skip
        return self.mdp

    @property
    def rows(self) -> Ints:
        """(N,) row of the plan of each observation."""
        return self.state_row[self.pair]

    @property
    def actions(self) -> Ints:
        """(N,) the actions taken."""
        return self.action[self.pair]

    def largest_error(self, confidence: float) -> float:
        """No log probability is further from the exact one than this: 2α times the error of the action values."""
        return 2 * confidence * self.plan.error_bound

    def told(self, confidence: float) -> str:
        """Which planner was used and how wrong it may be, in words."""
        plan, error = self.plan, self.largest_error(confidence)
        if plan.half_gap is None:
            told = "exact, for the whole world; log probabilities are wrong by at most"
            return f"{told} {error:.2g} nats; {self.mdp!r}"
        told = f"real-time dynamic programming in envelopes of up to {plan.n_inside:,} states"
        wrong = f"log probabilities are wrong by at most {error:.2g} nats, the log likelihood by"
        return f"{told}; {plan.status.value}; {wrong} {self.total_error(confidence):.2g}; {self.mdp!r}"

    def total_error(self, confidence: float) -> float:
        """No log likelihood of an assignment of all observations is further from the exact one than this."""
        gap = self.plan.half_gap
        if gap is None:
            return self.rows.size * self.largest_error(confidence)
        return float(2 * confidence * gap.max(axis=1)[self.rows].sum())


def planned_actions(
    demonstrations: Demonstrations,
    candidates: Candidates,
    mdp: TabularMDP | LocalWorld,
    *,
    confidence: float = DEFAULT_CONFIDENCE,
    convention: Convention = "continuing",
    tolerance: float | None = None,
    planner: Planner | None = None,
    dense_entries: int = DENSE_ENTRIES,
    workers: int | None = None,
    progress: Progress | None = None,
) -> LogLikelihood:
    """The table log p(a_i | s_i, g) = α·Q*(s_i, a_i) − log Σ_a exp(α·Q*(s_i, a)), equation (4.2).

    Parameters
    ----------
    demonstrations:
        States (N,) and actions (N,) of a discrete world.
    candidates:
        G states or sets of states (``goal_sets``).
    mdp:
        The world: a ``TabularMDP`` of S states, A actions, discount γ; a ``GridWorld``; or a world that is too large to
        be written down, such as an ``ImplicitGrid``. Illegal actions have no part in the sum.
    confidence:
        α, in nats per unit of the goal's reward c = 1: only the product α·c matters (thesis 4.1, 4.2).
    convention:
        "continuing": the goal is rewarded at every visit. "absorbing": once, and the episode is over; there, action
        values are smaller by the factor V*(g)/c, which is 1/(1 − γ) where the goal can be held, so α must be larger by
        it for the same table.
    tolerance:
        Largest error of an action value. Default: as in ``plan_subgoals``; where planning is by real-time dynamic
        programming, 0.01/(2α), so that no log probability is wrong by more than 0.01 nats.
    planner:
        ``subgoal.mdp.plan_subgoals`` (exact, the whole world) or ``subgoal.mdp.rtdp_subgoals`` (an envelope around the
        demonstrations, with a bound), or either with settings of its own through ``functools.partial``. None: the
        first for tables and for grids of up to 50,000 cells, the second for all others.
    dense_entries:
        Above this N·G the table is computed in tiles and never held whole; the draws are the same.
    workers, progress:
        As in ``plan_subgoals``.

    Notes
    -----
    Where a candidate cannot be reached from a state, whatever is done, all actions are equally good and the density is
    uniform over the legal ones; how many pairs of observation and candidate this concerns is noted in the source of the
    demonstrations. The planner and its error are told by ``LogLikelihood.planner`` and in reports. Memory:
    8·U·(A + 1)·G bytes for U different observed states.

    Warns
    -----
    PlanningWarning
        The error bound is above the tolerance: an envelope had reached its largest size.

    Raises
    ------
    InputError
        Positions instead of states, states or actions that the world does not have, illegal actions, candidates
        without states.
    BudgetError
        The action values would need more than 4 GiB.
    PlanningError
        Exact planning did not reach the tolerance.
    """
    check_demonstrations(demonstrations)
    mdp, planner = world_and_planner(mdp, planner)
    states, actions = checked_pairs(demonstrations, mdp)
    given: Any = candidates
    if not isinstance(given, Candidates) or given.goal_sets is None:
        found = "places in space" if isinstance(given, Candidates) else type(given).__name__
        raise InputError("candidates", found=found, wanted="Candidates that are states of the world",
                         hint="subgoal.visited(demonstrations), or Candidates.from_states(states)")  # fmt: skip
    here, row = np.unique(states, return_inverse=True)
    refuse_large_plan(here.size, mdp.n_actions, candidates.n_candidates)
    if tolerance is None and not plans_exactly(planner):
        tolerance = NATS / (2 * positive("confidence", confidence))
    plan = planner(
        mdp, candidates.goal_sets, states=here, convention=convention, tolerance=tolerance, workers=workers,
        progress=progress,
    )  # fmt: skip
    legal = np.isfinite(plan.action_values).any(axis=2)
    code, pair = np.unique(row * mdp.n_actions + actions, return_inverse=True)
    at_goal = np.stack([np.isin(here, members) for members in candidates.goal_sets], axis=1)
    single = legal.sum(axis=1)[row] == 1
    source = PlannedActions(
        plan, mdp, planner, legal, pair, code // mdp.n_actions, code % mdp.n_actions, candidates.goal_sets, at_goal,
        single,
    )  # fmt: skip
    noted = demonstrations.source.noting(
        observations_with_one_legal_action=int(single.sum()),
        pairs_of_observation_and_candidate_out_of_reach=int(plan.unreachable[row].sum()),
    )
    if plan.status is PlanStatus.BUDGET:
        error = f"log probabilities are wrong by up to {source.largest_error(confidence):.3g} nats"
        warnings.warn(f"{plan.status.value} ({error})", PlanningWarning, stacklevel=2)
    return LogLikelihood(source, confidence, candidates, replace(demonstrations, source=noted), dense_entries)


def refuse_large_plan(states: int, actions: int, candidates: int) -> None:
    """Raise ``BudgetError`` when the action values of so many states and candidates would need more than 4 GiB."""
    needed = 8.0 * states * (actions + 1) * candidates
    if needed > LARGEST_PLAN:
        raise BudgetError("action values", needed=needed, budget=LARGEST_PLAN, hint="fewer candidates, or states")
