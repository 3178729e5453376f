"""A posterior as ArviZ takes it: label-invariant summaries with named dimensions, data and provenance."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from subgoal.likelihood.source import Levels
from subgoal.posterior.posterior import Posterior
from subgoal.posterior.trajectories import is_weighted, trajectory_log_likelihood
from subgoal.runtime.errors import InputError, MissingExtraError

RANKS = 10
"""So many of the largest shares are given."""
BY_TRAJECTORY = "trajectory_actions"
Named = dict[str, tuple[tuple[str, ...], NDArray[Any]]]
"""Arrays with the names of their dimensions."""


def to_arviz(posterior: Posterior, *, log_likelihood: bool = False, seed: int = 0) -> Any:
    """See ``Posterior.to_arviz``."""
    try:
        from arviz_base import from_dict
    except ImportError:
        raise MissingExtraError("arviz-base", "arviz") from None
    draws: dict[str, Named] = {"posterior": _posterior(posterior), "sample_stats": {"lp": ((), posterior.log_joint)}}
    if log_likelihood:
        draws["log_likelihood"] = _by_trajectory(posterior, seed)
    groups: dict[str, Named] = {**draws, "observed_data": _observed(posterior), "constant_data": _constant(posterior)}
    dims = {name: list(own) for group in groups.values() for name, (own, _) in group.items()}
    return from_dict(
        {group: {name: values for name, (_, values) in variables.items()} for group, variables in groups.items()},
        dims=dims, coords=_coordinates(posterior), attrs=dict.fromkeys(["/", *groups], _provenance(posterior)),
    )  # fmt: skip


def _posterior(posterior: Posterior) -> Named:
    """Number of subgoals, largest shares, log likelihood and everything else that was sampled, each (chain, draw, ...).

    Nothing here hangs on which candidate is which, but for what the model has one of for each.
    """
    shape, n, counts = posterior.log_joint.shape, posterior.n_observations, posterior.counts
    ranks = min(RANKS, posterior.candidates.n_candidates)
    found: Named = {
        "n_subgoals": ((), np.diff(counts.offset).reshape(shape)),
        "share": (("rank",), (counts.largest(ranks) / n).reshape(*shape, ranks)),
        "log_likelihood_total": ((), posterior.log_likelihood),
    }
    if posterior.settings.background:
        served = counts.by_group(np.zeros(posterior.candidates.n_candidates, np.int64), 1)
        found["background_share"] = (), (1 - served / n).reshape(shape)
    for name, values in posterior.parameters.items():
        found[_variable(name)] = _dimensions(posterior, name, values.ndim - 2, values.shape[-1]), values
    return found


def _dimensions(posterior: Posterior, name: str, count: int, last: int) -> tuple[str, ...]:
    """Names of the dimensions of a parameter after chain and draw, of which ``last`` is the length of the last."""
    if count == 0:
        return ()
    own = [f"{_variable(name)}_{k}" for k in range(count)]
    if name == "noise levels":
        own[-1] = "confidence_level"
    elif name == "group counts":
        own[0], own[-1] = "group", "candidate_or_background" if posterior.settings.background else "candidate"
    elif last == posterior.candidates.n_candidates:
        own[-1] = "candidate"
    return tuple(own)


def _by_trajectory(posterior: Posterior, seed: int) -> Named:
    if is_weighted(posterior):
        raise InputError(
            "log_likelihood", found="observations that are weighted", wanted="observations that count as one each: "
            "likelihoods that are raised to a power are no probabilities",
            hint="subgoal.validation.leave_one_out(posterior), which weighs draws by the one and scores by the other",
        )  # fmt: skip
    every = np.arange(posterior.log_joint.size)
    values = trajectory_log_likelihood(posterior, every, seed=seed)
    return {BY_TRAJECTORY: (("trajectory",), values.reshape(*posterior.log_joint.shape, -1))}


def _observed(posterior: Posterior) -> Named:
    actions = np.asarray(posterior.demonstrations.actions)
    return {"action": (("observation", "action_dimension")[: actions.ndim], actions)}


def _constant(posterior: Posterior) -> Named:
    demos, candidates = posterior.demonstrations, posterior.candidates
    states = np.asarray(demos.states)
    found: Named = {
        "state": (("observation", "state_dimension")[: states.ndim], states),
        "trajectory_of_observation": (("observation",), demos.trajectory),
        "uninformative": (("observation",), np.asarray(posterior.uninformative)),
        "candidate_position": (("candidate", "place_dimension"), np.asarray(candidates.points)),
        "candidate_log_prior": (("candidate",), np.asarray(candidates.log_prior)),
    }
    if demos.times is not None:
        found["time"] = ("observation",), demos.times
    return found


def _coordinates(posterior: Posterior) -> dict[str, Any]:
    demos, candidates = posterior.demonstrations, posterior.candidates
    found: dict[str, Any] = {
        "rank": np.arange(1, min(RANKS, candidates.n_candidates) + 1),
        "candidate": np.arange(candidates.n_candidates),
        "candidate_or_background": np.append(np.arange(candidates.n_candidates), -1),
        "trajectory": list(demos.trajectory_names),
        "observation": np.arange(demos.n_observations),
    }
    if not demos.is_discrete:
        found["state_dimension"] = list(demos.names)
    law: Any = None if posterior.likelihood is None else posterior.likelihood.confidence
    if isinstance(law, Levels):
        found["confidence_level"] = law.confidences
    return found


def _provenance(posterior: Posterior) -> dict[str, Any]:
    settings, source = posterior.settings, posterior.demonstrations.source
    return {
        "inference_library": "subgoal", "inference_library_version": settings.version, "seed": settings.seed,
        "data_checksum": settings.data, "data_source": source.name, "data_source_checksum": source.checksum,
        "sampler": settings.sampler, "model": settings.model, "concentration": settings.concentration,
        "confidence": settings.confidence, "background": settings.background, "likelihood": settings.likelihood,
        "warmup": settings.warmup, "thin": settings.thin, "status": posterior.status.name,
        "sampling_time": posterior.seconds,
    }  # fmt: skip


def _variable(name: str) -> str:
    """A name as variables have it: no spaces."""
    return name.replace(" ", "_")
