"""The same likelihood for other demonstrations: same candidates, noise and background."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.planned_actions import PlannedActions, planned_actions
from subgoal.likelihood.sources import ControllerActions, Directions
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.errors import InputError


def same_likelihood(likelihood: LogLikelihood, demonstrations: Demonstrations) -> LogLikelihood:
    """The table of ``demonstrations`` under the candidates and the noise of ``likelihood``; no weights.

    Raises ``InputError`` for a table of given numbers, and what making the table raises.
    """
    source: Any = likelihood.source
    candidates = likelihood.candidates
    if isinstance(source, PlannedActions):
        fresh = planned_actions(
            demonstrations, candidates, source.mdp, convention=source.plan.convention, tolerance=source.plan.tolerance
        )
    elif isinstance(source, Directions):
        fresh = action_comparison(demonstrations, candidates)
    elif isinstance(source, ControllerActions):
        fresh = action_comparison(demonstrations, candidates, controller=source.controller, compare=source.compare)
    else:
        raise InputError("likelihood", found=f"{source.kind!r}", wanted="one that can be made for other demonstrations")
    return replace(fresh, confidence=likelihood.confidence, background=likelihood.background)
