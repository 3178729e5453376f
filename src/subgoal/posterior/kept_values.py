"""Value functions of a posterior on disk: with the world beside them, what was planned need not be planned again."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.candidates import Candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.dynamics.world import ContinuousWorld
from subgoal.gaussian.coordinates import coordinates
from subgoal.gaussian.goal_values import GoalValues
from subgoal.gaussian.smoothers import Averager, GaussianSmoother
from subgoal.gaussian.value_iteration import IterationStatus
from subgoal.likelihood.gp_values import GaussianProcessValues, checked_pairs
from subgoal.runtime.errors import StorageError

SMOOTHERS: dict[str, Any] = {"GaussianSmoother": GaussianSmoother, "Averager": Averager}
ARRAYS = ("support", "values", "best", "residuals")


def kept_values(source: GaussianProcessValues) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of a file, without the world, which is code; nothing for a smoother of one's own."""
    plan = source.plan
    kind = type(plan.smoother).__name__
    if kind not in SMOOTHERS:
        return {}, {}
    settings: Any = plan.smoother
    header = {
        "smoother": {"kind": kind, **asdict(settings)}, "width": plan.width, "discount": plan.discount,
        "gain": plan.gain, "status": plan.status.name,
    }  # fmt: skip
    return {"plan": header}, {f"plan_{name}": np.asarray(getattr(plan, name)) for name in ARRAYS}


def values_in(
    header: dict[str, Any], arrays: dict[str, NDArray[Any]], demonstrations: Demonstrations, candidates: Candidates,
    world: ContinuousWorld,
) -> GaussianProcessValues:  # fmt: skip
    """The source of a likelihood from ``kept_values`` and the world. Raises ``StorageError`` where nothing was kept."""
    if "plan" not in header:
        raise StorageError("mdp", found="a posterior without value functions of a continuous world",
                           wanted="one of gpsrl, with a smoother of this library")  # fmt: skip
    told, metric = header["plan"], candidates.metric
    smoother = dict(told["smoother"])
    states, actions = checked_pairs(demonstrations, metric.dimension, world)
    support, at = arrays["plan_support"], coordinates(metric, states)
    plan = GoalValues(
        support, coordinates(metric, candidates.points), arrays["plan_values"], arrays["plan_best"],
        SMOOTHERS[smoother.pop("kind")](**smoother), told["width"], told["discount"], told["gain"],
        arrays["plan_residuals"], IterationStatus[told["status"]],
    )  # fmt: skip
    apart = np.linalg.norm(at[:, None] - support[None], axis=2).min(axis=1)
    return GaussianProcessValues(
        plan, world, metric, states, actions, world.ahead(states, actions, metric), candidates, apart > 1e-9
    )  # fmt: skip
