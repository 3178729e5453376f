"""The likelihood of a posterior for other demonstrations, whole recordings or one step at a time: one scale, its own.

What counts as standing still, and the speed that distances are measured in, are those of the demonstrations that the
posterior is from, so that nothing is taken from the demonstrations that are to be foretold.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood import normalisers
from subgoal.likelihood.action_comparison import SLOW
from subgoal.likelihood.again import same_likelihood
from subgoal.likelihood.planned_actions import PlannedActions, checked_pairs, refuse_large_plan
from subgoal.likelihood.source import Confidence
from subgoal.likelihood.sources import ControllerActions, Directions, Pace
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.planners.first_passage import plan_subgoals
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError


def held_out_table(posterior: Posterior, demonstrations: Demonstrations) -> LogLikelihood:
    """The table of ``demonstrations`` under the candidates, noise, background and scale of a posterior; no weights.

    Raises ``InputError`` for a posterior without its likelihood, for a table of given numbers, and for demonstrations
    that do not fit.
    """
    likelihood = likelihood_of(posterior)
    if isinstance(likelihood.source, (Directions, ControllerActions)):
        return _remade(likelihood, demonstrations, pace_of(posterior))
    return same_likelihood(likelihood, demonstrations)


def likelihood_of(posterior: Posterior) -> LogLikelihood:
    """That of a posterior; raises ``InputError`` where it is lost."""
    if posterior.likelihood is None:
        raise InputError("posterior", found="no likelihood", wanted="one with it", hint="load(path, mdp=mdp)")
    return posterior.likelihood


def pace_of(posterior: Posterior) -> Pace:
    """Weights of the action dimensions, median and top speed of the demonstrations that a posterior is from."""
    source: Any = likelihood_of(posterior).source
    if isinstance(source, ControllerActions):
        return source.pace
    weights = posterior.candidates.metric.weights
    speed = np.linalg.norm(posterior.demonstrations.actions * weights, axis=1)
    return Pace(weights, float(np.median(speed[speed > 0])), float(speed.max()), source.slow)


def _remade(likelihood: LogLikelihood, demonstrations: Demonstrations, pace: Pace) -> LogLikelihood:
    """The same comparison of actions for other demonstrations, slow where they are below 1 % of the median ``pace``."""
    source: Any = likelihood.source
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions)
    known = source.states.shape[1], pace.weights.size
    if states.ndim != 2 or actions.ndim != 2 or (states.shape[1], actions.shape[1]) != known:
        found = f"states and actions of shapes {states.shape} and {actions.shape}"
        wanted = f"{known[0]} and {known[1]} dimensions, as those of the posterior"
        raise InputError("demonstrations", found=found, wanted=wanted)
    slow = np.linalg.norm(actions * pace.weights, axis=1) < SLOW * pace.median
    pace = replace(pace, slow=slow)
    fresh: Any
    if isinstance(source, Directions):
        fresh = _KnownNormalisers.of(states, actions, likelihood.candidates, pace)
    else:
        candidates = likelihood.candidates
        fresh = ControllerActions(states, actions, candidates, pace, source.controller, source.compare)
    return replace(likelihood, source=fresh, demonstrations=demonstrations, weight=None)


class _KnownNormalisers(Directions):
    """Directions whose normalisers are integrated once for each confidence and not once for each block of rows."""

    def _constants(self, confidence: Confidence) -> tuple[Floats, Floats, float]:
        dimension = self.states.shape[1]
        each = np.full(self.goals.shape[1], confidence, float)
        if np.ndim(confidence) == 0:
            logs = np.full(each.size, _log_normaliser(float(each[0]), dimension))
        else:
            logs = np.array([_log_normaliser(alpha, dimension) for alpha in each.tolist()])
        return each, logs, -normalisers.log_sphere_area(dimension)


@lru_cache(maxsize=2**16)
def _log_normaliser(confidence: float, dimension: int) -> float:
    return normalisers.log_direction_normaliser(confidence, dimension)


class Steps:
    """Tables of one observation each, from states and actions that come one at a time.

    Action values of a discrete world are planned for all its states once, here. Raises ``InputError`` as
    ``held_out_table``, and ``BudgetError`` where all action values would need more than 4 GiB.
    """

    def __init__(self, posterior: Posterior) -> None:
        self._likelihood = likelihood_of(posterior)
        self._pace: Pace | None = None
        source: Any = self._likelihood.source
        if isinstance(source, PlannedActions):
            self._everywhere = _planned_everywhere(source)
        elif isinstance(source, (Directions, ControllerActions)):
            self._pace = pace_of(posterior)
        else:
            raise InputError("posterior", found=f"likelihood {source.kind!r}",
                             wanted="one that can be made for other demonstrations")  # fmt: skip

    def table(self, state: Any, action: Any) -> LogLikelihood:
        """The table (1, G) of an action in a state."""
        one = Demonstrations.from_arrays(np.asarray(state)[None], np.asarray(action)[None], np.array([0, 1]))
        if self._pace is not None:
            return _remade(self._likelihood, one, self._pace)
        states, actions = checked_pairs(one, self._everywhere.mdp)
        single = self._everywhere.mdp.available[states].sum(axis=1) == 1
        zero = np.zeros(1, np.int64)
        source = replace(self._everywhere, pair=zero, state_row=states, action=actions, uninformative=single)
        return replace(self._likelihood, source=source, demonstrations=one, weight=None)


def _planned_everywhere(source: PlannedActions) -> PlannedActions:
    """The same plan with the action values of all states kept."""
    mdp, every = source.mdp, np.arange(source.mdp.n_states)
    refuse_large_plan(every.size, mdp.n_actions, len(source.goal_sets))
    plan = plan_subgoals(
        mdp, source.goal_sets, states=every, convention=source.plan.convention, tolerance=source.plan.tolerance
    )
    at_goal = np.stack([np.isin(every, members) for members in source.goal_sets], axis=1)
    return replace(source, plan=plan, at_goal=at_goal)
