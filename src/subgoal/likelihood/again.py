"""The same likelihood for other demonstrations, whole recordings or one step at a time: same noise, same scale.

What counts as standing still, and the speed that distances are measured in, stay those of the demonstrations that the
likelihood was made for, so that nothing is taken from demonstrations that are to be foretold.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import SLOW
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.likelihood.pairs import checked_pairs
from subgoal.likelihood.planned_actions import PlannedActions, planned_actions
from subgoal.likelihood.sources import ControllerActions, Directions, Pace
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError


def same_likelihood(likelihood: LogLikelihood, demonstrations: Demonstrations) -> LogLikelihood:
    """The table of ``demonstrations`` under the candidates, noise, background and scale of ``likelihood``; no weights.

    Raises ``InputError`` for a table of given numbers, for demonstrations that do not fit, and what planning raises.
    """
    source: Any = likelihood.source
    if isinstance(source, (Directions, ControllerActions)):
        return _compared(likelihood, demonstrations, pace_of(likelihood))
    if isinstance(source, GaussianProcessValues):
        return replace(likelihood, source=source.again(demonstrations), demonstrations=demonstrations, weight=None)
    if not isinstance(source, PlannedActions):
        raise _cannot(likelihood)
    fresh = planned_actions(
        demonstrations, likelihood.candidates, source.mdp, convention=source.plan.convention,
        tolerance=source.plan.tolerance, planner=source.planner,
    )  # fmt: skip
    return replace(fresh, confidence=likelihood.confidence, background=likelihood.background)


def pace_of(likelihood: LogLikelihood) -> Pace:
    """Weights of the action dimensions, median and top speed of the demonstrations that a comparison was made for."""
    source: Any = likelihood.source
    if isinstance(source, ControllerActions):
        return source.pace
    weights = likelihood.candidates.metric.weights
    speed = np.linalg.norm(likelihood.demonstrations.actions * weights, axis=1)
    return Pace(weights, float(np.median(speed[speed > 0])), float(speed.max()), source.slow)


def _compared(likelihood: LogLikelihood, demonstrations: Demonstrations, pace: Pace) -> LogLikelihood:
    """The same comparison of actions for other demonstrations, slow where they are below 1 % of the median ``pace``."""
    source: Any = likelihood.source
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions)
    known = source.states.shape[1], pace.weights.size
    if states.ndim != 2 or actions.ndim != 2 or (states.shape[1], actions.shape[1]) != known:
        found = f"states and actions of shapes {states.shape} and {actions.shape}"
        wanted = f"{known[0]} and {known[1]} dimensions, as those of the posterior"
        raise InputError("demonstrations", found=found, wanted=wanted)
    pace = replace(pace, slow=np.linalg.norm(actions * pace.weights, axis=1) < SLOW * pace.median)
    candidates, fresh = likelihood.candidates, source
    if isinstance(source, Directions):
        fresh = Directions.of(states, actions, candidates, pace)
    else:
        fresh = ControllerActions(states, actions, candidates, pace, source.controller, source.compare)
    return replace(likelihood, source=fresh, demonstrations=demonstrations, weight=None)


class Steps:
    """Tables of one observation each, from states and actions that come one at a time.

    Action values of a discrete world are planned for all its states once, here. Raises ``InputError`` as
    ``same_likelihood``, and ``BudgetError`` where all action values would need more than 4 GiB.
    """

    def __init__(self, likelihood: LogLikelihood) -> None:
        self._likelihood = likelihood
        self._pace: Pace | None = None
        source: Any = likelihood.source
        if isinstance(source, PlannedActions):
            self._everywhere = _planned_everywhere(source)
        elif isinstance(source, (Directions, ControllerActions)):
            self._pace = pace_of(likelihood)
        elif not isinstance(source, GaussianProcessValues):
            raise _cannot(likelihood)

    def table(self, state: Any, action: Any) -> LogLikelihood:
        """The table (1, G) of an action in a state."""
        one = Demonstrations.from_arrays(np.asarray(state)[None], np.asarray(action)[None], np.array([0, 1]))
        if self._pace is not None:
            return _compared(self._likelihood, one, self._pace)
        if isinstance(self._likelihood.source, GaussianProcessValues):
            return same_likelihood(self._likelihood, one)
        states, actions = checked_pairs(one, self._everywhere.mdp)
        single = self._everywhere.table.available[states].sum(axis=1) == 1
        zero = np.zeros(1, np.int64)
        source = replace(self._everywhere, pair=zero, state_row=states, action=actions, uninformative=single)
        return replace(self._likelihood, source=source, demonstrations=one, weight=None)


def _planned_everywhere(source: PlannedActions) -> PlannedActions:
    """The same plan with the action values of all states kept."""
    every = np.arange(source.table.n_states)
    plan = source.planned_at(every)
    at_goal = np.stack([np.isin(every, members) for members in source.goal_sets], axis=1)
    return replace(source, plan=plan, legal=source.table.available, at_goal=at_goal)


def _cannot(likelihood: LogLikelihood) -> InputError:
    return InputError("likelihood", found=f"{likelihood.source.kind!r}",
                      wanted="one that can be made for other demonstrations")  # fmt: skip
