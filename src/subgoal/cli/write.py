"""Results written to a folder, with the answers under other settings if these are asked for."""

from __future__ import annotations

from pathlib import Path

from subgoal.answers.subgoals import subgoals
from subgoal.irl.sensitivity import sensitivity
from subgoal.posterior.posterior import Posterior
from subgoal.reporting.results import Results, write_results
from subgoal.runtime.progress import progress_display


def write(
    posterior: Posterior, folder: Path, *, merge_radius: float | None, y_down: bool, sensitive: bool, quiet: bool
) -> Results:
    """``write_results``, after ``sensitivity`` if ``sensitive``; the results stand in the folder before that begins."""
    found = subgoals(posterior, merge_radius=merge_radius)
    results = write_results(posterior, folder, found=found, y_down=y_down)
    if not sensitive:
        return results
    seen = sensitivity(posterior, found=found, progress=progress_display("sensitivity", quiet=quiet))
    if not quiet:
        print(seen)
    return write_results(posterior, folder, found=found, y_down=y_down, sensitivity=seen)
