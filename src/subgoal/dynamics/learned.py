"""Learning where actions lead, for those who have demonstrations and no model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.learned_dynamics import GaussianDynamics, HeldOut, LearnedDynamics
from subgoal.dynamics.learned_models import Model, learn_affine, learn_neighbours, learn_processes
from subgoal.dynamics.learned_pairs import Transitions, held_out, inputs, transitions
from subgoal.runtime.checks import Bools, Floats, frozen
from subgoal.runtime.errors import InputError

Kind = Literal["linear", "gp", "neighbours", "best"]
_LEARN: dict[str, Callable[[Floats, Floats, int], Model]] = {
    "linear": learn_affine, "gp": learn_processes, "neighbours": learn_neighbours
}  # fmt: skip


def learn_dynamics(
    demonstrations: Demonstrations,
    *,
    kind: Kind = "best",
    step: float | None = None,
    metric: Metric | None = None,
    holdout: float = 0.2,
    seed: int = 0,
) -> LearnedDynamics:
    """Learn where states (N, d) go under actions (N, k) in one step, and by how much that is wrong.

    Parameters
    ----------
    kind:
        "linear": an affine map. "neighbours": the five nearest observations. "gp": a Gaussian process for each
        dimension, which also has variances (``GaussianDynamics``). "best": the one of the three that errs least on what
        was held out.
    step:
        Duration of a step, a multiple of the time between two pairs; not given: that time. Actions are averaged over
        it, and taken as held. In short steps noise hides what changes; in long ones actions that are not held do.
    metric:
        For its periods: dimensions that wrap.
    holdout:
        Share of the transitions that is held out at a time, in whole stretches; every transition once. What is
        returned has been learned from all of them afterwards.
    seed:
        Of the stretches, and of the observations that Gaussian processes are made of where there are over 600.

    Raises
    ------
    InputError
        States of a discrete world, times that are missing or uneven, a step that is no multiple, a dimension that never
        changes, too few transitions.
    """
    if kind not in (*_LEARN, "best"):
        raise InputError("kind", found=repr(kind), wanted=", ".join(map(repr, (*_LEARN, "best"))))
    width = np.shape(demonstrations.states)[-1] if not demonstrations.is_discrete else 1
    plain = Metric.of(width, None, None if metric is None else tuple(metric.period))
    moves = transitions(demonstrations, step, plain)
    folds, at = held_out(moves, holdout, seed), inputs(plain, moves.states, moves.actions)
    tried = {each: _errors(_LEARN[each], moves, at, folds, seed) for each in (_LEARN if kind == "best" else (kind,))}
    taken = min(tried, key=lambda each: tried[each].overall)
    model: Any = _LEARN[taken](at, moves.increments, seed)
    low = np.where(np.min(demonstrations.states, axis=0) >= 0, 0.0, -plain.period / 2)
    record = GaussianDynamics if taken == "gp" else LearnedDynamics
    return record(
        taken, moves.step, model, plain, tried, demonstrations.names, demonstrations.time_unit, frozen(low),
        moves.actions.shape[1],
    )  # fmt: skip


def _errors(
    learn: Callable[[Floats, Floats, int], Model], moves: Transitions, at: Floats, folds: list[tuple[Bools, Bools]],
    seed: int,
) -> HeldOut:  # fmt: skip
    """Of models learned without each fold in turn, over all of them."""
    off = np.concatenate([
        learn(at[train], moves.increments[train], seed).increments(at[test]) - moves.increments[test]
        for train, test in folds
    ])  # fmt: skip
    true = np.concatenate([moves.increments[test] for _, test in folds])
    error, stays = (np.sqrt(np.mean(values**2, axis=0)) for values in (off, true))
    spread = np.maximum(true.std(axis=0), 1e-12 * (1 + np.abs(moves.states).max(axis=0)))
    return HeldOut(frozen(error), frozen(stays), frozen(error / spread), len(true))
