"""The likelihood of thesis 6.3 in a continuous world, with its denominator mended: planning by Gaussian processes."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from subgoal.candidates.record import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.planning import plan_world
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.goal_values import GoalValues
from subgoal.gaussian.smoothers import Averager, GaussianSmoother, Smoother
from subgoal.gaussian.value_iteration import MOST_SWEEPS, TOLERANCE, IterationStatus
from subgoal.likelihood.gp_values import GaussianProcessValues, checked_pairs
from subgoal.likelihood.table import DENSE_ENTRIES, LogLikelihood
from subgoal.mdp.planners.outcome import PlanningWarning
from subgoal.runtime.checks import Floats
from subgoal.runtime.errors import InputError, PlanningError, StoppedError
from subgoal.runtime.progress import Progress

DEFAULT_CONFIDENCE = 15.0
WIDTH = 0.7
GAUSSIAN = GaussianSmoother()
HOLD = {GaussianSmoother: 0.4, Averager: 0.32}
"""Share of the future that must be possible at a candidate, by the smoother."""
TOGETHER = 32
"""Goals whose states are looked at at once."""


def gp_actions(
    demonstrations: Demonstrations,
    candidates: Candidates,
    world: ContinuousWorld,
    *,
    confidence: float = DEFAULT_CONFIDENCE,
    support: Candidates | None = None,
    smoother: Smoother = GAUSSIAN,
    width: float = WIDTH,
    hold: float | None = None,
    refinements: int = 0,
    tolerance: float = TOLERANCE,
    most_sweeps: int = MOST_SWEEPS,
    allow_unconverged: bool = False,
    dense_entries: int = DENSE_ENTRIES,
    place: Callable[[Floats], Any] = np.asarray,
    progress: Progress | None = None,
) -> LogLikelihood:
    """The table log p(a_i | s_i, g) = αQ_g(s_i, a_i) − log ∫ exp(αQ_g(s_i, u)) du.

    Parameters
    ----------
    demonstrations:
        States (N, d) and held actions (N, k), a step of the world apart; see ``hold_actions`` for faster recordings.
    candidates:
        G places, and the metric: distances in it decide what is near.
    world:
        Dynamics, bounds, test actions, step and horizon.
    confidence:
        α in nats per whole future: Q is the share of the discounted future spent at the subgoal, so that a number means
        the same for every step and horizon (errata E29).
    support:
        Where values are known (thesis 6.4); the candidates if None.
    smoother:
        ``GaussianSmoother``, or ``Averager``, with which planning is a contraction.
    width:
        Of the reward of a subgoal (6.1), in units of the metric.
    hold:
        Candidates of which less than this share of the future can be spent there are dropped, and counted in the source
        of the demonstrations. Default 0.4 (0.32 with an averager); 0 keeps all.
    refinements:
        How often the best test action of each support state and candidate is refined among its neighbours, at half the
        spacing each time; planning then goes on with it. 0: the test actions alone, enough to tell goals apart.
    tolerance, most_sweeps, progress:
        Of value iteration.
    place:
        Takes NumPy arrays to those of the library that is to plan, by the array API standard, such as
        ``lambda array: torch.asarray(array, device="cuda")``. What follows planning runs in main memory.
    allow_unconverged:
        Go on, with a ``PlanningWarning``, where values still change after the last sweep.
    dense_entries:
        Above this N·G the table is computed in tiles and never held whole; the draws are the same.

    Raises
    ------
    InputError
        States of a discrete world, actions outside the bounds, dynamics that give NaN or another shape, fewer support
        states than dimensions, no candidate that can be held.
    StoppedError
        Ctrl-C while planning.
    PlanningError
        Values still change after the last sweep.
    BudgetError
        Weights and rewards would need more than 4 GiB.
    """
    states, actions = _checked(demonstrations, candidates, world)
    if hold is not None and not 0 <= hold <= 1:
        raise InputError("hold", found=hold, wanted="a share of the future, 0 to 1")
    metric = candidates.metric
    base = (candidates if support is None else support).points
    if len(base) <= states.shape[1]:
        raise InputError(
            "support states", found=f"{len(base)} in {states.shape[1]} dimensions",
            wanted="more states than dimensions",
            hint="a smaller radius, or a longer recording",
        )  # fmt: skip
    _refuse_idle(world, base, metric)
    plan = plan_world(
        world, metric, base, candidates.points, smoother=smoother, width=width, refinements=refinements,
        tolerance=tolerance, most_sweeps=most_sweeps, place=place, progress=progress,
    )  # fmt: skip
    if plan.status is IterationStatus.STOPPED:
        raise StoppedError(f"stopped after {plan.residuals.size} sweeps of planning: there is no likelihood yet")
    if plan.status is not IterationStatus.CONVERGED:
        said = f"{plan.status.value} (residual {plan.residual:.1e} after {plan.residuals.size} sweeps)"
        if not allow_unconverged:
            raise PlanningError(said)
        warnings.warn(said, PlanningWarning, stacklevel=2)
    share = held_share(plan, candidates.points, world, metric)
    least = HOLD.get(type(smoother), 0.0) if hold is None else hold
    kept = share >= least
    if not kept.any():
        found = f"none of {len(kept)} can be held: at most {share.max():.2f} of the future"
        hint = (f"a shorter horizon= (it is {world.horizon:g}, a step is {world.step:g}), a smaller hold=, or a better "
                "model; in Python also a larger width=")  # fmt: skip
        raise InputError("candidates", found=found, wanted=f"{least:g} of it", hint=hint)
    source = GaussianProcessValues(
        plan.only(np.flatnonzero(kept)), world, metric, states, actions, world.ahead(states, actions, metric),
        candidates.some(kept),
        ~(metric.distance(states[:, None], base[None]) < 1e-9).any(axis=1),
    )  # fmt: skip
    noted = demonstrations.source.noting(candidates_dropped_that_cannot_be_held=int((~kept).sum()))
    return LogLikelihood(
        source, confidence, source.candidates, replace(demonstrations, source=noted), dense_entries
    )  # fmt: skip


def _refuse_idle(world: ContinuousWorld, states: Floats, metric: Metric) -> None:
    """Raise ``InputError`` for a world in which it makes no difference what is done."""
    some = states[:TOGETHER]
    after = world.ahead_of_tests(some, metric).points[-1].reshape(len(some), len(world.test_actions), -1)
    if not np.ptp(after, axis=1).max() > 1e-9 * (1 + np.abs(after).max()):
        raise InputError("dynamics", found="the same next state whatever is done", wanted="actions that do something",
                         hint="look at the order of states and actions in the function, or wider bounds")  # fmt: skip


def held_share(plan: GoalValues, points: Floats, world: ContinuousWorld, metric: Any) -> Floats:
    """(G,) which share of the discounted future can be spent at each goal, once there: max_u Q_g(s_g, u)."""
    m, ahead = len(world.test_actions), world.ahead_of_tests(points, metric)
    share = np.empty(len(points))
    for first in range(0, len(points), TOGETHER):
        rows = np.arange(first, min(first + TOGETHER, len(points)))
        values = np.asarray(plan.action_values(ahead.some(slice(first * m, (rows[-1] + 1) * m))))
        share[rows] = values.reshape(rows.size, m, -1)[np.arange(rows.size), :, rows].max(axis=1)
    return share


def _checked(demonstrations: Any, candidates: Any, world: Any) -> tuple[Floats, Floats]:
    if not isinstance(candidates, Candidates) or candidates.goal_sets is not None:
        raise InputError("candidates", found=type(candidates).__name__, wanted="Candidates that are places in space")
    if not isinstance(world, ContinuousWorld):
        raise InputError("world", found=type(world).__name__, wanted="a ContinuousWorld",
                         hint="ContinuousWorld(dynamics, low, high, step)")  # fmt: skip
    return checked_pairs(demonstrations, candidates.metric.dimension, world)
