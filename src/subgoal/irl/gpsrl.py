"""Gaussian process subgoal reward learning (thesis Algorithm 5): several goals of one continuous demonstration."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from subgoal.candidates.places import epsilon_net
from subgoal.candidates.record import Candidates
from subgoal.demonstrations.held import UNEVEN, time_step
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.protocol import Dynamics
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.coordinates import spread_metric
from subgoal.gaussian.smoothers import Smoother
from subgoal.gaussian.value_iteration import MOST_SWEEPS
from subgoal.likelihood.gp_actions import DEFAULT_CONFIDENCE, GAUSSIAN, WIDTH, gp_actions
from subgoal.partition.annealed import annealed
from subgoal.partition.persistence import Persistent
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.sample import sample
from subgoal.runtime.checks import positive
from subgoal.runtime.errors import InputError
from subgoal.runtime.progress import Progress

RADIUS = 0.35
CONCENTRATION = 0.001
STEPS_KEPT = 20
EXCHANGEABLE_CONFIDENCE = 30.0


def gpsrl(
    demonstrations: Demonstrations,
    world: ContinuousWorld | Dynamics,
    *,
    bounds: tuple[Any, Any] | None = None,
    metric: Metric | None = None,
    candidates: Candidates | None = None,
    radius: float = RADIUS,
    support: Candidates | None = None,
    confidence: float | None = None,
    concentration: float = CONCENTRATION,
    dwell: float | None = None,
    smoother: Smoother = GAUSSIAN,
    width: float = WIDTH,
    hold: float | None = None,
    refinements: int = 0,
    most_sweeps: int = MOST_SWEEPS,
    planning_progress: Progress | None = None,
    **sampling: Any,
) -> Posterior:
    """The subgoals of a continuous demonstration, their number not given, thesis Algorithm 5 with its errors mended.

    Thins the demonstration to candidates and support states (lines 2-7), plans for every candidate at once by Gaussian
    processes (8-10), tabulates the density of the actions (6.2), and samples which subgoal explains which pair (11-19).

    Parameters
    ----------
    demonstrations:
        States (N, d) and held actions (N, k); ``hold_actions`` makes them of a faster recording.
    world:
        A ``ContinuousWorld``, or dynamics: then decisions are a step of the demonstrations apart.
    bounds:
        (low, high), (k,) each, of the actions, for dynamics alone: by default those that the dynamics name, else the
        range of the demonstrated ones.
    metric:
        What is near; by default each dimension in units of its standard deviation. Give a floor, the least difference
        that matters, where a dimension may carry noise alone: ``spread_metric(states, floor=...)``.
    candidates, radius:
        By default an ε-net of the states with ``radius`` in units of the metric.
    support:
        States at which values are known; the candidates if None.
    confidence:
        α in nats per whole future spent at the subgoal: 15, or 30 for the exchangeable model.
    concentration:
        η (2.8).
    dwell:
        Mean time for which a subgoal is kept, in the unit of the step: 20 steps by default. 0: pairs are exchangeable,
        as in the thesis, and their order says nothing; chains are then ``annealed``, unless a sampler is given, since
        from one cluster they would not get anywhere.
    smoother, width, hold, refinements, most_sweeps:
        As in ``gp_actions``.
    sampling:
        Settings of ``sample``: chains, draws, warmup, thin, seed, model, sampler, workers and so on.

    Raises
    ------
    What ``gp_actions`` and ``sample`` raise; ``InputError`` for a dimension that never changes.
    """
    step = _step(demonstrations, world)
    known = continuous_world(demonstrations, world, step, bounds)
    if candidates is None:
        states = np.asarray(demonstrations.states)
        candidates = epsilon_net(demonstrations, radius, metric=metric or spread_metric(states))
    elif metric is not None:
        raise InputError("metric", found="given", wanted="None beside candidates, which have one")
    if confidence is None:
        confidence = EXCHANGEABLE_CONFIDENCE if dwell == 0 else DEFAULT_CONFIDENCE
    likelihood = gp_actions(
        demonstrations, candidates, known, confidence=confidence, support=support, smoother=smoother, width=width,
        hold=hold, refinements=refinements, most_sweeps=most_sweeps, progress=planning_progress,
    )  # fmt: skip
    return sample(likelihood, concentration=concentration, **(lasting(step, dwell, sampling) | sampling))


def lasting(step: float, dwell: float | None, given: Any = ()) -> dict[str, Any]:
    """The model or the sampler for subgoals that are kept for ``dwell`` on average; none where one is ``given``."""
    if "model" in given or (dwell == 0 and "sampler" in given):
        return {}
    if dwell == 0:
        return {"sampler": annealed}
    kept = STEPS_KEPT * step if dwell is None else positive("dwell", dwell, zero=True)
    return {"model": Persistent(keep=math.exp(-step / kept))}


def _step(demonstrations: Demonstrations, world: ContinuousWorld | Dynamics) -> float:
    """Of the world; the times of the demonstrations, where there are any, must be as far apart."""
    if not isinstance(world, ContinuousWorld):
        return time_step(demonstrations)
    if demonstrations.times is not None and (np.diff(demonstrations.offset) > 1).any():
        own = time_step(demonstrations)
        if not abs(own - world.step) <= UNEVEN * world.step:
            raise InputError("world.step", found=world.step, wanted=f"{own:g}, the time between two pairs",
                             hint="hold_actions(demonstrations, k), or a world with that step")  # fmt: skip
    return world.step


def continuous_world(
    demonstrations: Demonstrations, world: ContinuousWorld | Dynamics, step: float, bounds: tuple[Any, Any] | None
) -> ContinuousWorld:
    """The world as it is, or one made of dynamics and bounds."""
    if isinstance(world, ContinuousWorld):
        if bounds is not None:
            raise InputError("bounds", found="given", wanted="None beside a ContinuousWorld, which has some")
        return world
    return ContinuousWorld(world, *(bounds_of(demonstrations, world) if bounds is None else bounds), step=step)


def bounds_of(demonstrations: Demonstrations, dynamics: Dynamics) -> tuple[Any, Any]:
    """Least and most of each action: as the dynamics name them, or the range of the demonstrated ones.

    Raises ``InputError`` for codes of discrete actions and for actions that never change.
    """
    named = getattr(dynamics, "bounds", None)
    if named is not None:
        low, high = named
        return low, high
    actions = np.asarray(demonstrations.actions)
    if actions.ndim != 2:
        raise InputError("actions", found="codes of discrete actions", wanted="numbers (N, k)",
                         hint="demonstrations whose actions are floats, if their size means something")  # fmt: skip
    low, high = actions.min(axis=0), actions.max(axis=0)
    if not (low < high).all():
        k = int(np.argmin(low < high))
        hint = "leave it out, or bounds= of what could have been done"
        raise InputError("actions", where=f"dimension {k}", found=f"{low[k]:g} throughout",
                         wanted="actions that change", hint=hint)  # fmt: skip
    return low, high
