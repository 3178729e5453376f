"""What planning knows of each subgoal in a continuous world: what states are worth for it, and where it leads."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from subgoal.answers.subgoals import Subgoals
from subgoal.gaussian.coordinates import coordinates
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints, frozen

MOST_ROWS = 400
"""Observed states that are looked at, evenly spaced."""


@dataclass(frozen=True, eq=False)
class Portraits:
    """Values and motion under each listed subgoal, at observed states.

    Attributes
    ----------
    rows:
        (R,) which observations.
    pair:
        The two dimensions in which the listed subgoals are told apart best.
    states:
        (R, d) of these observations.
    values:
        (R, S) share of the discounted future that can be spent at listed subgoal k from there.
    moved:
        (R, S, d) by how much the state changes in one step under the best test action for it.
    held:
        (S,) share of the future that can be spent at it, once there.
    """

    rows: Ints
    pair: tuple[int, int]
    states: Floats
    values: Floats
    moved: Floats
    held: Floats


def portraits(posterior: Posterior, found: Subgoals) -> Portraits | None:
    """Of the listed subgoals; None where nothing was planned by Gaussian processes, or there is no likelihood."""
    source = None if posterior.likelihood is None else posterior.likelihood.source
    if not isinstance(source, GaussianProcessValues) or not found.listed:
        return None
    n = len(source.states)
    rows = np.unique(np.linspace(0, n - 1, min(n, MOST_ROWS)).astype(np.int64))
    states, goals = source.states[rows], np.array([goal.candidate for goal in found.listed])
    tests = source.world.test_actions
    worth = np.stack([source.tested(int(i), int(i) + 1)[0][:, goals] for i in rows])
    best = worth.argmax(axis=1)
    moved = np.empty((rows.size, goals.size, states.shape[1]))
    for k in range(goals.size):
        after = source.world.after(states, tests[best[:, k]])
        moved[:, k] = source.metric.difference(states, after) / source.metric.weights
    held = np.asarray(source.plan.values_at(coordinates(source.metric, source.candidates.points[goals])))
    return Portraits(
        frozen(rows), _clearest(posterior, found), frozen(states), frozen(worth.max(axis=1)), frozen(moved),
        frozen(np.diag(held[:, goals])),
    )  # fmt: skip


def _clearest(posterior: Posterior, found: Subgoals) -> tuple[int, int]:
    """Two dimensions, in their order, in which the nearest two listed subgoals are farthest apart; the only one twice.

    One subgoal alone is seen where the states spread most.
    """
    metric = posterior.candidates.metric
    places = np.vstack([goal.position for goal in found.listed])
    if len(places) > 1:
        rows, others = np.triu_indices(len(places), 1)
        square = metric.difference(places[rows], places[others]) ** 2
    else:
        square = (metric.difference(places[0], posterior.demonstrations.places) ** 2).mean(axis=0)[None]
    pairs = list(combinations(range(square.shape[1]), 2)) or [(0, 0)]
    return max(pairs, key=lambda pair: float(square[:, pair].sum(axis=1).min()))
