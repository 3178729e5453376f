"""The subgoals flown by a simulated quadrotor, in the words of the page."""

from __future__ import annotations

from pathlib import Path

from subgoal.posterior.posterior import Posterior


def save_waypoints(posterior: Posterior, path: Path) -> None:
    """Waypoints as CSV or JSON, by the ending of ``path``."""
