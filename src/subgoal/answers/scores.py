"""Scores: how well actions are predicted and subgoals recovered. Bits per decision: higher is better; loss: lower."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import comb

from subgoal.likelihood.planned_actions import PlannedActions
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.planners.policy_iteration import policy_evaluation, policy_iteration
from subgoal.mdp.tabular import TabularMDP, check_world
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Bools, Floats, Ints, positive, real_array, whole
from subgoal.runtime.errors import InputError

TIE = 1e-9
"""Probabilities within this of the largest, relative to it, are tied."""


def bits_per_decision(probabilities: Any, actions: Any, *, counted: Any = None) -> float:
    """Mean log₂ p(action) over the observations: 0 is certainty, −log₂ A is chance among A actions.

    ``probabilities`` (N, A), ``actions`` (N,); ``counted`` (N,) booleans leave decisions out, such as those with one
    legal action. −inf if an action that was taken had no probability. Raises ``InputError`` for rows that do not sum
    to one.
    """
    table, taken, rows = _predicted(probabilities, actions, counted)
    with np.errstate(divide="ignore"):
        return float(np.log2(table[rows, taken[rows]]).mean())


def zero_one_loss(probabilities: Any, actions: Any, *, counted: Any = None) -> float:
    """Mean 0-1 loss of predicting the most probable action, under uniform tie-breaking; arguments as above."""
    table, taken, rows = _predicted(probabilities, actions, counted)
    return float(losses(likeliest(table[rows]), taken[rows]).mean())


def likeliest(probabilities: Floats) -> Bools:
    """(N, A) the most probable actions of each row, ties included."""
    return np.asarray(probabilities >= probabilities.max(axis=1, keepdims=True) * (1 - TIE))


def losses(best: Bools, actions: Ints) -> Floats:
    """(N,) 1 − 1[a best] / (number of best): the expected 0-1 loss of each action, ties split evenly."""
    return np.asarray(1 - best[np.arange(len(best)), actions] / best.sum(axis=1))


def policy_loss(optimal: Bools, actions: Any, *, ties: str = "uniform") -> float:
    """0-1 policy loss (thesis 4.7): how many actions are not those of the policy.

    Parameters
    ----------
    optimal:
        (N, A) booleans: the best actions in the state of each observation.
    actions:
        (N,) the actions taken.
    ties:
        "uniform": 1 − 1[a best] / (number of best), the expected loss of a policy that breaks ties at random, so that
        a constant reward scores 1 − 1/A for each observation and not 0. "first": the policy takes the best action of
        lowest index.
    """
    optimal = np.asarray(optimal)
    if optimal.dtype != bool or optimal.ndim != 2 or not optimal.any(axis=1).all():
        found = f"{optimal.dtype} of shape {optimal.shape}"
        raise InputError("optimal", found=found, wanted="booleans (N, A) with a best action in every row")
    actions = _whole_numbers("actions", actions, len(optimal), optimal.shape[1])
    if ties == "uniform":
        return float(losses(optimal, actions).sum())
    if ties != "first":
        raise InputError("ties", found=repr(ties), wanted="'uniform' or 'first'")
    return float((optimal.argmax(axis=1) != actions).sum())


def assignment_loss(likelihood: LogLikelihood, assignment: Any, *, ties: str = "uniform") -> float:
    """0-1 policy loss of a draw: each action against the best ones for the candidate it is assigned to.

    ``assignment`` (N,) is a draw θ. This is the loss of the thesis's figures 4-1 to 4-3; since θ_i was drawn with a_i
    in view it is no prediction.
    """
    source: Any = likelihood.source
    if not isinstance(source, PlannedActions):
        raise InputError("likelihood", found=source.kind, wanted="planned actions")
    theta = _labels("assignment", assignment, likelihood)
    return policy_loss(source.optimal[source.rows, :, theta], source.actions, ties=ties)


def top_candidates(posterior: Posterior, count: int) -> Ints:
    """The ``count`` candidates of largest expected share (all, if there are fewer), the largest first."""
    order = np.argsort(-posterior.expected_shares, kind="stable")
    return np.asarray(order[: whole("count", count)])


@dataclass(frozen=True)
class Recovery:
    """Found places matched to true ones, one to one: precision, recall, and which pairs (found, true) were matched."""

    precision: float
    recall: float
    pairs: tuple[tuple[int, int], ...]


def recovery(found: Any, true: Any, *, radius: float = 0.0) -> Recovery:
    """Match places (F, d) to true ones (T, d) within ``radius``, as many as possible, then as close as possible.

    Precision is the share of the found that have a partner, recall that of the true; 0 of 0 counts as 1.
    """
    first, second = _points("found", found), _points("true", true)
    radius = positive("radius", radius, zero=True)
    if not len(first) or not len(second):
        return Recovery(float(not len(first)), float(not len(second)), ())
    if first.shape[1] != second.shape[1]:
        raise InputError("found", found=f"{first.shape[1]} dimensions", wanted=f"{second.shape[1]}, as the true places")
    distance = np.linalg.norm(first[:, None] - second[None], axis=-1)
    near = distance <= radius * (1 + 1e-12)
    far = 1.0 + min(distance.shape) * max(radius, 1e-300)
    rows, columns = linear_sum_assignment(np.where(near, distance, far))
    pairs = tuple((int(f), int(t)) for f, t in zip(rows, columns, strict=True) if near[f, t])
    return Recovery(len(pairs) / len(first), len(pairs) / len(second), pairs)


def adjusted_rand(first: Any, second: Any) -> float:
    """Adjusted Rand index of two partitions given as labels (N,): 1 is equality, 0 is chance (Hubert & Arabie 1985)."""
    shapes = [np.shape(labels) for labels in (first, second)]
    if shapes[0] != shapes[1] or len(shapes[0]) != 1 or not shapes[0][0]:
        raise InputError("labels", found=f"shapes {shapes[0]} and {shapes[1]}", wanted="(N,) twice, N at least 1")
    a, b = (np.unique(np.asarray(labels), return_inverse=True)[1] for labels in (first, second))
    table = np.zeros((a.max() + 1, b.max() + 1))
    np.add.at(table, (a, b), 1)
    together = comb(table, 2).sum()
    rows, columns = comb(table.sum(axis=1), 2).sum(), comb(table.sum(axis=0), 2).sum()
    expected = rows * columns / max(comb(a.size, 2), 1)
    most = (rows + columns) / 2
    return 1.0 if most == expected else float((together - expected) / (most - expected))


def identified(likelihood: LogLikelihood, true: Any, assigned: Any, *, within: float = 1e-6) -> NDArray[np.bool_]:
    """(N,) observations whose label can be told: the true and the assigned candidate do not explain them equally well.

    Where both give the action the same log probability (``within`` nats), no method can tell which it served, and the
    pair is left out of scores of assignment (an observation assigned to its true candidate always counts).
    """
    rows = np.arange(likelihood.n_observations)
    within = positive("within", within, zero=True)
    true, assigned = (_labels(what, each, likelihood) for what, each in (("true", true), ("assigned", assigned)))
    values = np.empty((2, rows.size))
    for start, tile in likelihood.tiles():
        block = rows[start : start + len(tile)]
        values[0, block], values[1, block] = tile[block - start, true[block]], tile[block - start, assigned[block]]
    return np.asarray((true == assigned) | (np.abs(values[0] - values[1]) > within))


def expected_value_difference(mdp: TabularMDP, reward: Any, policy: Any, *, start: Any = None) -> float:
    """Value lost by following ``policy`` under the true ``reward``: E[V*(s₀)] − E[V^π(s₀)] over ``start`` (S,).

    ``policy`` is (S,) actions or (S, A) probabilities; ``start`` defaults to the world's, or to all states alike.
    """
    check_world(mdp)
    begin = mdp.start if start is None else real_array("start", start, ndim=1)
    begin = np.full(mdp.n_states, 1 / mdp.n_states) if begin is None else begin
    if begin.shape != (mdp.n_states,) or not ((begin >= 0).all() and abs(begin.sum() - 1) <= 1e-8):
        found = f"{begin.size} numbers that sum to {begin.sum():.12g}"
        raise InputError("start", found=found, wanted=f"{mdp.n_states} probabilities that sum to 1")
    best = policy_iteration(mdp, reward).value
    return float(begin @ (best - policy_evaluation(mdp, policy, reward)))


def _predicted(probabilities: Any, actions: Any, counted: Any) -> tuple[Floats, Ints, Ints]:
    table = real_array("probabilities", probabilities, ndim=2)
    taken = _whole_numbers("actions", actions, len(table), table.shape[1])
    bad = (np.abs(table.sum(axis=1) - 1) > TIE * 10) | (table < 0).any(axis=1)
    if bad.any():
        i = int(np.argmax(bad))
        raise InputError("probabilities", where=f"observation {i}", found=f"{table[i]}",
                         wanted="probabilities that sum to 1")  # fmt: skip
    kept = np.ones(taken.size, bool) if counted is None else np.asarray(counted)
    if kept.dtype != bool or kept.shape != taken.shape:
        found = f"{kept.dtype} of shape {kept.shape}"
        raise InputError("counted", found=found, wanted=f"booleans of shape {taken.shape}")
    rows = np.flatnonzero(kept)
    if not rows.size:
        raise InputError("counted", found="no decision", wanted="at least one")
    return table, taken, rows


def _labels(what: str, labels: Any, likelihood: LogLikelihood) -> Ints:
    return _whole_numbers(what, labels, likelihood.n_observations, likelihood.n_candidates)


def _whole_numbers(what: str, values: Any, count: int, below: int) -> Ints:
    """``values`` as (count,) integers from 0 to ``below`` − 1; raises ``InputError`` naming the first that is not."""
    array = np.asarray(values)
    if array.dtype.kind not in "iu" or array.shape != (count,) or not count:
        raise InputError(what, found=f"{array.dtype} of shape {array.shape}", wanted=f"integers of shape ({count},)")
    outside = (array < 0) | (array >= below)
    if outside.any():
        i = int(np.argmax(outside))
        raise InputError(what, where=f"observation {i}", found=int(array[i]), wanted=f"0 to {below - 1}")
    return array.astype(np.int64)


def _points(what: str, places: Any) -> Floats:
    array = np.asarray(places, float)
    return real_array(what, array[:, None] if array.ndim == 1 else array, ndim=2)
