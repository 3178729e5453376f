"""Gaussian processes, and dynamic programming with them for all goals at once."""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOME = {
    "fit": "regression",
    "GaussianProcess": "regression",
    "Regression": "regression",
    "fit_sparse": "sparse",
    "SparseGaussianProcess": "sparse",
    "farthest_points": "inducing",
    "k_means_centres": "inducing",
    "thin_by_regression": "trajectory_thinning",
    "thin_trajectories": "trajectory_thinning",
    "Reproduction": "trajectory_thinning",
    "Thinned": "trajectory_thinning",
    "ThinnedDemonstrations": "trajectory_thinning",
    "Fitted": "evidence",
    "Status": "factor",
    "SingularError": "factor",
    "RegressionWarning": "factor",
}
"""Public names and the module each lives in: scikit-learn loads when one is used."""

__all__ = [*_HOME]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'subgoal.gaussian' has no attribute {name!r}")
    return getattr(import_module(f"subgoal.gaussian.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
