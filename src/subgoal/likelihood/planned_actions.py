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
from subgoal.likelihood.source import Confidence
from subgoal.likelihood.table import DENSE_ENTRIES, LogLikelihood
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.mdp.planners.subgoal_plan import Convention, SubgoalPlan
from subgoal.mdp.tabular import TabularMDP, check_states, check_world
from subgoal.runtime.checks import Floats, Ints
from subgoal.runtime.errors import BudgetError, InputError
from subgoal.runtime.progress import Progress

DEFAULT_CONFIDENCE = 10.0
LARGEST_PLAN = 2**32
"""Bytes that action values may take."""


@dataclass(frozen=True, eq=False, repr=False)
class PlannedActions:
    """Source of log π(a | s, g) from action values Q*(s, a) at the states that were observed.

    Attributes
    ----------
    plan:
        Values and action values at the U different states that were observed.
    mdp:
        The world they were planned in.
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
    mdp: TabularMDP
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
        legal = self.mdp.available[self.plan.states[self.rows[start:stop]]]
        return np.asarray(-np.log(legal.sum(axis=1)))

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
        """(U, A, G) the best actions at the observed states for each candidate, planned for when first asked."""
        return plan_subgoals(
            self.mdp, self.goal_sets, states=self.plan.states, convention=self.plan.convention, relative=True,
            allow_unconverged=True,
        ).optimal  # fmt: skip

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


def planned_actions(
    demonstrations: Demonstrations,
    candidates: Candidates,
    mdp: TabularMDP,
    *,
    confidence: float = DEFAULT_CONFIDENCE,
    convention: Convention = "continuing",
    tolerance: float | None = None,
    dense_entries: int = DENSE_ENTRIES,
    workers: int | None = None,
    progress: Progress | None = None,
) -> LogLikelihood:
    """The table log p(a_i | s_i, g) = α·Q*(s_i, a_i) − log Σ_a exp(α·Q*(s_i, a)), equation (4.2), with exact planning.

    Parameters
    ----------
    demonstrations:
        States (N,) and actions (N,) of a discrete world.
    candidates:
        G states or sets of states (``goal_sets``).
    mdp:
        The world: S states, A actions, discount γ. Illegal actions have no part in the sum.
    confidence:
        α, in nats per unit of the goal's reward c = 1: only the product α·c matters (thesis 4.1, 4.2).
    convention:
        "continuing": the goal is rewarded at every visit. "absorbing": once, and the episode is over; there, action
        values are smaller by the factor V*(g)/c, which is 1/(1 − γ) where the goal can be held, so α must be larger by
        it for the same table.
    tolerance:
        Largest error of an action value, as in ``plan_subgoals``.
    dense_entries:
        Above this N·G the table is computed in tiles and never held whole; the draws are the same.
    workers, progress:
        As in ``plan_subgoals``.

    Notes
    -----
    Where a candidate cannot be reached from a state, whatever is done, all actions are equally good and the density is
    uniform over the legal ones; how many pairs of observation and candidate this concerns is noted in the source of the
    demonstrations. Memory: 8·U·(A + 1)·G bytes for U different observed states.

    Raises
    ------
    InputError
        Positions instead of states, states or actions that the world does not have, illegal actions, candidates
        without states.
    BudgetError
        The action values would need more than 4 GiB.
    PlanningError
        The tolerance was not reached.
    """
    states, actions = checked_pairs(demonstrations, mdp)
    given: Any = candidates
    if not isinstance(given, Candidates) or given.goal_sets is None:
        found = "places in space" if isinstance(given, Candidates) else type(given).__name__
        raise InputError("candidates", found=found, wanted="Candidates that are states of the world",
                         hint="subgoal.visited(demonstrations), or Candidates.from_states(states)")  # fmt: skip
    here, row = np.unique(states, return_inverse=True)
    refuse_large_plan(here.size, mdp.n_actions, candidates.n_candidates)
    plan = plan_subgoals(
        mdp, candidates.goal_sets, states=here, convention=convention, tolerance=tolerance, workers=workers,
        progress=progress,
    )  # fmt: skip
    code, pair = np.unique(row * mdp.n_actions + actions, return_inverse=True)
    at_goal = np.stack([np.isin(here, members) for members in candidates.goal_sets], axis=1)
    single = mdp.available.sum(axis=1)[states] == 1
    source = PlannedActions(
        plan, mdp, pair, code // mdp.n_actions, code % mdp.n_actions, candidates.goal_sets, at_goal, single
    )
    noted = demonstrations.source.noting(
        observations_with_one_legal_action=int(single.sum()),
        pairs_of_observation_and_candidate_out_of_reach=int(plan.unreachable[row].sum()),
    )
    return LogLikelihood(source, confidence, candidates, replace(demonstrations, source=noted), dense_entries)


def refuse_large_plan(states: int, actions: int, candidates: int) -> None:
    """Raise ``BudgetError`` when the action values of so many states and candidates would need more than 4 GiB."""
    needed = 8.0 * states * (actions + 1) * candidates
    if needed > LARGEST_PLAN:
        raise BudgetError("action values", needed=needed, budget=LARGEST_PLAN, hint="fewer candidates, or states")


def checked_pairs(demonstrations: Any, mdp: Any) -> tuple[Ints, Ints]:
    """States and actions, each of the world and legal; raises ``InputError`` naming the observation."""
    if not isinstance(demonstrations, Demonstrations):
        found = type(demonstrations).__name__
        raise InputError("demonstrations", found=found, wanted="Demonstrations, then the world")
    check_world(mdp)
    if not demonstrations.is_discrete or np.ndim(demonstrations.actions) != 1:
        hint = "to_cells makes cells of positions"
        raise InputError("demonstrations", found="real numbers", wanted="states and actions (N,) integers", hint=hint)
    states = check_states("demonstrations.states", demonstrations.states, mdp.n_states)
    actions = np.asarray(demonstrations.actions)
    for bad, wanted in (
        ((actions < 0) | (actions >= mdp.n_actions), f"0 to {mdp.n_actions - 1}"),
        (~mdp.available[states, np.clip(actions, 0, mdp.n_actions - 1)], "a legal action of state {state}"),
    ):
        if bad.any():
            i = int(np.argmax(bad))
            ended = ", where episodes are over" if mdp.terminal[states[i]] else ""
            raise InputError("demonstrations.actions", where=f"observation {i}", found=int(actions[i]),
                             wanted=wanted.format(state=states[i]) + ended)  # fmt: skip
    return states, actions
