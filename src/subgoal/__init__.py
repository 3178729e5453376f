"""Bayesian nonparametric reward learning from demonstration: the goals behind a recording, and how sure they are."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from subgoal.runtime.version import VERSION as __version__

_HOME = {
    "read": "demonstrations.read",
    "read_recording": "demonstrations.readers",
    "demonstrate": "demonstrations.prepare",
    "Recording": "demonstrations.records",
    "Demonstrations": "demonstrations.records",
    "Metric": "demonstrations.metric",
    "summarise": "demonstrations.summary",
    "Candidates": "candidates",
    "epsilon_net": "candidates",
    "visited": "candidates",
    "read_candidates": "candidates",
    "action_comparison": "likelihood.action_comparison",
    "planned_actions": "likelihood.planned_actions",
    "LogLikelihood": "likelihood.table",
    "sample": "posterior.sample",
    "bnirl": "irl.bnirl",
    "gpsrl": "irl.gpsrl",
    "learn": "irl.learn",
    "Posterior": "posterior.posterior",
    "Status": "posterior.diagnostics",
    "save": "posterior.archive",
    "load": "posterior.archive",
    "subgoals": "answers.subgoals",
    "segments": "answers.segments",
    "residuals": "answers.residuals",
    "co_clustering": "answers.partition",
    "point_partition": "answers.partition",
    "report": "reporting.page",
    "write_results": "reporting.results",
    "SubgoalError": "runtime.errors",
}
"""Public names and the module each lives in; nothing heavy loads before it is used."""

_ROOMS = {
    "samplers": "samplers",
    "models": "models",
    "optima": "optima",
    "filtering": "answers.filtering",
    "online": "answers.online",
    "validation": "answers.validation",
    "certainty": "answers.certainty",
    "groups": "answers.groups",
    "controllers": "likelihood.controllers",
    "mdp": "mdp",
    "continuous": "continuous",
    "dynamics": "dynamics",
    "gaussian": "gaussian",
    "episodes": "demonstrations.episodes",
    "predictions": "answers.predictions",
    "scores": "answers.scores",
    "evidence": "answers.evidence",
    "sensitivity": "irl.sensitivity",
    "single_reward": "single_reward",
    "sharded": "sharded",
    "options": "options",
    "flight": "flight",
    "streaming": "streaming",
    "teach": "teach",
    "checks": "checks",
}
"""Public modules, for what is needed now and then."""

__all__ = ["__version__", *_HOME]


def __getattr__(name: str) -> Any:
    if name in _ROOMS:
        return import_module(f"subgoal.{_ROOMS[name]}")
    if name not in _HOME:
        raise AttributeError(f"module 'subgoal' has no attribute {name!r}")
    return getattr(import_module(f"subgoal.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted([*__all__, *_ROOMS])
