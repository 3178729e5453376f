"""Action comparison (thesis 5.1.2): the demonstrated action against what a controller would do for each goal."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.controllers import Controller
from subgoal.likelihood.sources import Compare, ControllerActions, Directions, Pace
from subgoal.likelihood.table import DENSE_ENTRIES, LogLikelihood
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError

DEFAULT_CONFIDENCE = 3.0
SLOW = 0.01
LEAST_SPAN, MOST_SPAN = 1e-140, 1e140
"""Ranges of positions and actions whose squares are still numbers."""


def action_comparison(
    demonstrations: Demonstrations,
    candidates: Candidates,
    *,
    confidence: float = DEFAULT_CONFIDENCE,
    controller: Controller | None = None,
    compare: Compare | None = None,
    dense_entries: int = DENSE_ENTRIES,
) -> LogLikelihood:
    """The table log p(a_i | s_i, g) = −α‖a_i − a_CL(s_i, g)‖ − log Z(α), equation (5.1) with its normaliser.

    Parameters
    ----------
    demonstrations:
        Positions (N, d) and actions (N, k).
    candidates:
        G places; their metric weighs the dimensions and wraps angles, half their radius counts as being there.
    confidence:
        α in nats per unit: of a unit direction (0 to 2), or of the median demonstrated speed.
    controller:
        (state, goal) -> action. None is straight to the goal (5.2), compared by direction, compiled.
    compare:
        "direction": both actions scaled by the weights and normalised, density over the unit sphere, uniform where the
        candidate is within radius/2. "action": density over R^k with the median demonstrated speed as scale, a_CL = 0
        within radius/2. Default: direction for straight to the goal, else action.
    dense_entries:
        Above this N·G the table is computed in tiles and never held whole; the draws are the same.

    Notes
    -----
    Pairs slower than 1 % of the median speed (over the pairs that move) say nothing of a goal: their row is uniform
    (over the sphere, or over the ball of the fastest demonstrated speed). They are kept, and counted in the result.

    Raises
    ------
    InputError
        Discrete data, dimensions that do not fit, a controller whose actions have the wrong shape, nothing that moves.
    """
    given: tuple[Any, Any] = demonstrations, candidates
    if not isinstance(given[0], Demonstrations) or not isinstance(given[1], Candidates):
        found = f"{type(given[0]).__name__}, {type(given[1]).__name__}"
        raise InputError("action_comparison", found=found, wanted="Demonstrations, then Candidates")
    states, actions = np.asarray(demonstrations.states), np.asarray(demonstrations.actions)
    for what, array in (("states", states), ("actions", actions)):
        if array.ndim != 2:
            raise InputError(f"demonstrations.{what}", found="integers", wanted="real numbers of shape (N, d)")
    if candidates.points.shape[1] != states.shape[1]:
        raise InputError(
            "candidates", found=f"{candidates.points.shape[1]} dimensions", wanted=f"{states.shape[1]}, as the states"
        )
    compare = compare or ("direction" if controller is None else "action")
    if compare not in ("direction", "action"):
        raise InputError("compare", found=repr(compare), wanted="'direction' or 'action'")
    if controller is None and compare == "action":
        raise InputError("controller", found="None", wanted="a controller, to compare whole actions with")
    _check_magnitudes(candidates, states, actions)
    pace = _pace(actions, _action_weights(candidates.metric, actions.shape[1], compare))
    if controller is None:
        source: Directions | ControllerActions = Directions.of(states, actions, candidates, pace)
    else:
        source = ControllerActions.of(states, actions, candidates, pace, controller, compare)
    return LogLikelihood(source, confidence, candidates, demonstrations, dense_entries)


def _check_magnitudes(candidates: Candidates, states: Floats, actions: Floats) -> None:
    """Refuse numbers whose squares overflow or vanish: directions between them would be wrong without a word."""
    weights = candidates.metric.weights
    places = np.vstack([states, candidates.points]) * weights
    spans = {"positions": float(np.ptp(places, axis=0).max()), "actions": float(np.abs(actions).max())}
    for what, span in spans.items():
        if span > 0 and not LEAST_SPAN < span < MOST_SPAN:
            raise InputError(
                what, found=f"a range of {span:.3g}", wanted=f"between {LEAST_SPAN:g} and {MOST_SPAN:g}",
                hint="other units",
            )  # fmt: skip


def _action_weights(metric: Metric, width: int, compare: Compare) -> Floats:
    if metric.dimension == width:
        return metric.weights
    if (metric.weights == metric.weights[0]).all() and compare == "action":
        return np.full(width, metric.weights[0])
    raise InputError(
        "demonstrations.actions", found=f"{width} columns", wanted=f"{metric.dimension}, as the states, to compare with"
    )


def _pace(actions: Floats, weights: Floats) -> Pace:
    speed = np.linalg.norm(actions * weights, axis=1)
    moving = speed[speed > 0]
    if not moving.size:
        raise InputError("demonstrations.actions", found="only zeros", wanted="at least one action that moves")
    median = float(np.median(moving))
    return Pace(weights, median, float(speed.max()), speed < SLOW * median)
