"""Save and load a posterior: one npz without pickle, with all that reports and answers need."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from subgoal.candidates import Candidates
from subgoal.demonstrations.metric import Metric
from subgoal.demonstrations.records import Demonstrations, Source
from subgoal.dynamics.world import ContinuousWorld
from subgoal.likelihood.action_comparison import action_comparison
from subgoal.likelihood.gp_values import GaussianProcessValues
from subgoal.likelihood.planned_actions import DEFAULT_CONFIDENCE, planned_actions
from subgoal.likelihood.source import Levels
from subgoal.likelihood.table import LogLikelihood
from subgoal.mdp.local_world import LocalWorld
from subgoal.mdp.planners.subgoal_plan import Convention
from subgoal.mdp.tabular import TabularMDP
from subgoal.posterior.checksum import checksum_of
from subgoal.posterior.diagnostics import Diagnostic, Status
from subgoal.posterior.kept_values import kept_values, values_in
from subgoal.posterior.posterior import CountDraws, Posterior, Settings
from subgoal.runtime.errors import StorageError
from subgoal.storage.archive import read_archive, write_archive

KIND = "posterior"
REMADE, PLANNED = "directions", "planned actions"
"""Kinds of likelihood that can be made again: from what is stored, and with the world beside it."""


def save(posterior: Posterior, path: str | Path) -> Path:
    """Write a posterior with the positions, actions, offsets and names it was fitted on.

    Raises ``StorageError`` for one of planned actions that was loaded without its world, whose noise is not known.
    """
    if posterior.likelihood is None and posterior.settings.likelihood == PLANNED:
        raise StorageError("posterior", found="no likelihood: it was loaded without its world",
                           wanted="one with it", hint="load(path, mdp=mdp), then save")  # fmt: skip
    demos, candidates, counts = posterior.demonstrations, posterior.candidates, posterior.counts
    arrays: dict[str, NDArray[Any]] = {
        "states": demos.states, "actions": demos.actions, "offset": demos.offset, "final_states": demos.final_states,
        "truncated": demos.truncated, "points": candidates.points, "log_prior": candidates.log_prior,
        "weights": candidates.metric.weights, "period": candidates.metric.period,
        "count_offset": counts.offset, "count_candidate": counts.candidate, "count": counts.count,
        "share_data": posterior.shares.data, "share_indices": posterior.shares.indices,
        "share_indptr": posterior.shares.indptr, "best": posterior.best_assignment, "log_joint": posterior.log_joint,
        "log_likelihood": posterior.log_likelihood, "uninformative": posterior.uninformative,
    }  # fmt: skip
    arrays |= {f"trace_{name}": trace for name, trace in posterior.traces.items()}
    arrays |= {f"parameter_{name}": values for name, values in posterior.parameters.items()}
    if demos.times is not None:
        arrays["times"] = demos.times
    if demos.coordinates is not None:
        arrays["coordinates"] = demos.coordinates
    if candidates.goal_sets is not None:
        arrays["goal_state"] = np.concatenate(candidates.goal_sets)
        arrays["goal_offset"] = np.cumsum([0, *(len(each) for each in candidates.goal_sets)])
    if posterior.assignments is not None:
        arrays["assignments"] = posterior.assignments
    if posterior.likelihood is not None:
        arrays |= _Noise.of(posterior.likelihood).arrays()
    if posterior.redraws is not None:
        drawn = posterior.redraws
        arrays |= {"redraw_offset": drawn.offset, "redraw_candidate": drawn.candidate, "redraw_count": drawn.count}
    header = {
        "settings": asdict(posterior.settings), "status": posterior.status.name, "seconds": posterior.seconds,
        "diagnostics": {name: asdict(each) for name, each in posterior.diagnostics.items()},
        "names": demos.names, "units": demos.units, "trajectory_names": demos.trajectory_names,
        "time_unit": demos.time_unit, "source": asdict(demos.source), "groups": demos.groups,
        "candidate_names": candidates.names, "radius": candidates.radius, "weight_settled": posterior.weight_settled,
    }  # fmt: skip
    source = None if posterior.likelihood is None else posterior.likelihood.source
    if isinstance(source, GaussianProcessValues):
        said, values = kept_values(source)
        header, arrays = header | said, arrays | values
    path = Path(path)
    write_archive(path, KIND, header, arrays, keep_previous=False)
    return path


def load(
    path: str | Path,
    *,
    mdp: TabularMDP | LocalWorld | ContinuousWorld | None = None,
    convention: Convention = "continuing",
) -> Posterior:
    """Read a posterior that ``save`` wrote.

    The likelihood is made again when it compares directions; when actions were planned, if the world ``mdp`` and the
    goal ``convention`` are given again; otherwise ``Posterior.likelihood`` is None. Value functions of a continuous
    world are in the file: with the ``ContinuousWorld`` beside them nothing is planned again, and options can be made.
    Raises ``StorageError`` for a torn, foreign or newer file, and for another world than that of the posterior.
    """
    header, arrays = read_archive(Path(path), KIND)
    try:
        posterior = _posterior(header, arrays)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as problem:
        raise StorageError("posterior file", where=str(path), found=f"a missing or wrong field ({problem})",
                           wanted="all fields of a posterior") from None  # fmt: skip
    if mdp is None:
        return posterior
    if isinstance(mdp, ContinuousWorld):
        source = values_in(header, arrays, posterior.demonstrations, posterior.candidates, mdp)
        table = LogLikelihood(source, 1.0, posterior.candidates, posterior.demonstrations)
        return _same(posterior, _Noise.read(arrays, posterior.settings).given_to(table))
    return _planned_again(posterior, mdp, convention, _Noise.read(arrays, posterior.settings))


def _posterior(header: dict[str, Any], arrays: dict[str, NDArray[Any]]) -> Posterior:
    demos = Demonstrations(
        states=arrays["states"], actions=arrays["actions"], offset=arrays["offset"], times=arrays.get("times"),
        final_states=arrays["final_states"], truncated=arrays["truncated"], names=tuple(header["names"]),
        units=header["units"], trajectory_names=tuple(header["trajectory_names"]), time_unit=header["time_unit"],
        source=Source(**header["source"]), coordinates=arrays.get("coordinates"),
        groups=tuple(header.get("groups", ())),
    )  # fmt: skip
    candidates = Candidates(
        points=arrays["points"], log_prior=arrays["log_prior"], names=tuple(header["candidate_names"]),
        radius=header["radius"], metric=Metric(arrays["weights"], arrays["period"]), goal_sets=_goal_sets(arrays),
    )  # fmt: skip
    settings = Settings(**header["settings"])
    shape = demos.n_observations, candidates.n_candidates
    shares = sparse.csr_array((arrays["share_data"], arrays["share_indices"], arrays["share_indptr"]), shape=shape)
    remade = None
    if settings.likelihood == REMADE:
        remade = _Noise.read(arrays, settings).given_to(action_comparison(demos, candidates))
    return Posterior(
        demonstrations=demos, candidates=candidates, settings=settings, assignments=arrays.get("assignments"),
        counts=CountDraws(arrays["count_offset"], arrays["count_candidate"], arrays["count"]), shares=shares,
        best_assignment=arrays["best"], log_joint=arrays["log_joint"], log_likelihood=arrays["log_likelihood"],
        traces=_prefixed(arrays, "trace_"), parameters=_prefixed(arrays, "parameter_"),
        diagnostics={name: Diagnostic(**each) for name, each in header["diagnostics"].items()},
        status=Status[header["status"]], uninformative=arrays["uninformative"], seconds=header["seconds"],
        likelihood=remade, redraws=_redraws(arrays), weight_settled=header.get("weight_settled"),
    )  # fmt: skip


def _planned_again(
    posterior: Posterior, mdp: TabularMDP | LocalWorld, convention: Convention, noise: _Noise
) -> Posterior:
    settings = posterior.settings
    if settings.likelihood != PLANNED:
        raise StorageError("mdp", found=f"a posterior of {settings.likelihood!r}", wanted=f"one of {PLANNED!r}")
    level = settings.confidence if isinstance(settings.confidence, float) else DEFAULT_CONFIDENCE
    fresh = planned_actions(
        posterior.demonstrations, posterior.candidates, mdp, convention=convention, confidence=level
    )
    return _same(posterior, noise.given_to(replace(fresh, demonstrations=posterior.demonstrations)))


def _same(posterior: Posterior, likelihood: LogLikelihood) -> Posterior:
    """The posterior with its likelihood, if it is that which it was sampled from."""
    if checksum_of(likelihood) != posterior.settings.data:
        raise StorageError("mdp", found="another world, discount or convention", wanted="those of the posterior")
    return replace(posterior, likelihood=likelihood)


@dataclass(frozen=True, eq=False)
class _Noise:
    """What a likelihood has beside its source: confidence (or levels and their shares), weight and background."""

    confidence: Any
    shares: Any
    weight: Any
    background: float

    @classmethod
    def of(cls, likelihood: LogLikelihood) -> _Noise:
        law = likelihood.confidence
        confidence, shares = (law.confidences, law.shares) if isinstance(law, Levels) else (law, None)
        return cls(np.asarray(confidence), shares, likelihood.weight, likelihood.background)

    @classmethod
    def read(cls, arrays: dict[str, NDArray[Any]], settings: Settings) -> _Noise:
        """As ``arrays`` of a file have it; older files have the confidence among the settings."""
        confidence = arrays.get("noise_confidence", np.asarray(settings.confidence))
        confidence = confidence.reshape(()) if confidence.size == 1 else confidence
        return cls(confidence, arrays.get("noise_shares"), arrays.get("noise_weight"), settings.background)

    def arrays(self) -> dict[str, NDArray[Any]]:
        held = {"noise_confidence": self.confidence, "noise_shares": self.shares, "noise_weight": self.weight}
        return {name: values for name, values in held.items() if values is not None}

    def given_to(self, likelihood: LogLikelihood) -> LogLikelihood:
        law = self.confidence if self.shares is None else Levels(self.confidence, self.shares)
        return replace(likelihood, confidence=law, weight=self.weight, background=self.background)


def _redraws(arrays: dict[str, NDArray[Any]]) -> CountDraws | None:
    if "redraw_count" not in arrays:
        return None
    return CountDraws(arrays["redraw_offset"], arrays["redraw_candidate"], arrays["redraw_count"])


def _goal_sets(arrays: dict[str, NDArray[Any]]) -> list[NDArray[Any]] | None:
    if "goal_state" not in arrays:
        return None
    return np.split(arrays["goal_state"], arrays["goal_offset"][1:-1])


def _prefixed(arrays: dict[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
