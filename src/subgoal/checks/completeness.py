"""Whether p(a | s, g) sums to one over the legal actions of a state, over the test actions, or around the circle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.checks.report import Found
from subgoal.demonstrations.records import Demonstrations
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.likelihood.planned_actions import PlannedActions
from subgoal.likelihood.sources import ControllerActions, Directions
from subgoal.likelihood.table import LogLikelihood
from subgoal.runtime.checks import Floats, Ints

Remake = Callable[[Demonstrations], LogLikelihood]
"""Demonstrations -> the same likelihood of other pairs."""

WITHIN = 1e-4
ANGLES = 2**14
"""Directions around the circle; enough for confidences up to about 100."""
MOST_CONFIDENCE = 100.0
PLACES = 3
"""Observations whose densities are integrated."""
STATES = 50
BLOCK = 1024


def complete(likelihood: LogLikelihood, remake: Remake | None) -> Found:
    """Largest departure from one over candidates, and over some of the observed states."""
    source: Any = likelihood.source
    plain = replace(likelihood, weight=None)
    if remake is None and isinstance(source, PlannedActions):
        return _verdict(_over_actions(plain, source))
    if remake is None and isinstance(source, GaussianProcessValues):
        return _verdict(_over_tests(plain, source))
    if not likelihood.demonstrations.is_discrete and np.shape(likelihood.demonstrations.states)[1] == 2:
        if np.max(_largest(likelihood.confidence)) > MOST_CONFIDENCE:
            return None, f"not run: a confidence above {MOST_CONFIDENCE:g}; try at() a lower one"
        if remake is not None:
            return _verdict(_around_remade(likelihood, remake))
        if isinstance(source, Directions) or (
            isinstance(source, ControllerActions) and source.compare == "direction" and source.actions.shape[1] == 2
        ):
            return _verdict(_around(plain, source))
    return None, "not run: no rule for this kind of action" + (", give remake=" if remake is None else "")


def _verdict(totals: Iterator[Floats]) -> Found:
    worst = max(float(np.abs(total - 1).max()) for total in totals)
    return bool(worst <= WITHIN), f"sums are off by at most {worst:.1e}"


def _largest(confidence: Any) -> float:
    return float(np.max(getattr(confidence, "confidences", confidence)))


def _some(count: int, most: int) -> Ints:
    return np.unique(np.linspace(0, count - 1, most).astype(np.int64))


def _over_actions(likelihood: LogLikelihood, source: PlannedActions) -> Iterator[Floats]:
    """Sums over the legal actions of observed states."""
    for row in _some(source.plan.states.size, STATES).tolist():
        legal = np.flatnonzero(source.legal[row])
        each = np.arange(legal.size)
        asked = replace(source, pair=each, state_row=np.full(legal.size, row), action=legal)
        yield np.exp(replace(likelihood, source=asked).rows(0, legal.size)).sum(axis=0)


def _over_tests(likelihood: LogLikelihood, source: GaussianProcessValues) -> Iterator[Floats]:
    """Means over the test actions of observed states, times the volume of the actions: how their integral is taken."""
    tests = source.world.test_actions
    for i in _some(len(source.states), PLACES).tolist():
        here = Demonstrations.from_arrays(np.tile(source.states[i], (len(tests), 1)), tests)
        asked = replace(likelihood, source=source.again(here), demonstrations=here)
        yield np.exp(asked.rows(0, len(tests)) + source.world.log_volume).mean(axis=0)


def _circle() -> Floats:
    angle = (np.arange(ANGLES) + 0.5) * 2 * np.pi / ANGLES
    return np.column_stack([np.cos(angle), np.sin(angle)])


def _integral(likelihood: LogLikelihood) -> Floats:
    """(G,) integral over the circle, of a likelihood whose actions go round it."""
    blocks = (np.exp(likelihood.rows(k, k + BLOCK)).sum(axis=0) for k in range(0, ANGLES, BLOCK))
    return np.asarray(sum(blocks) * 2 * np.pi / ANGLES)


def _around(likelihood: LogLikelihood, source: Any) -> Iterator[Floats]:
    """Integrals over the circle of unit directions, in weighted units."""
    circle, never = _circle(), np.zeros(ANGLES, bool)
    for i in _some(len(source.states), PLACES).tolist():
        here = np.tile(source.states[i], (ANGLES, 1))
        if isinstance(source, Directions):
            asked: Any = replace(source, units=circle, states=here, slow=never)
        else:
            pace = replace(source.pace, slow=never)
            asked = replace(source, actions=circle / source.pace.weights, states=here, pace=pace)
        yield _integral(replace(likelihood, source=asked))


def _around_remade(likelihood: LogLikelihood, remake: Remake) -> Iterator[Floats]:
    for i in _some(likelihood.n_observations, PLACES).tolist():
        here = np.tile(np.asarray(likelihood.demonstrations.states)[i], (ANGLES, 1))
        yield _integral(remake(Demonstrations.from_arrays(here, _circle())))
