"""Sentences that say what was found, the same in figures and in the report."""

from __future__ import annotations

import numpy as np

from subgoal.answers.residuals import Residuals
from subgoal.answers.subgoals import COUNTED_FROM, Subgoal, Subgoals
from subgoal.plots.shown import places_of
from subgoal.posterior.diagnostics import Status
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats

OFF_CENTRE = 0.05
"""A mean transform this far from one half is told as more or less precise."""
OFF_SHAPE = 0.1
"""A distribution function this far from the diagonal is told as another shape."""


def counted(number: int, noun: str) -> str:
    """ "1 subgoal", "3 subgoals", "2,054 observations"."""
    return f"{number:,} {noun}" + ("" if number == 1 else "s")


def percent(share: float) -> str:
    """ "95 %", and at the ends "over 99 %", "under 1 %"; exactly 0 and 1 as they are."""
    if 0.99 < share < 1:
        return "over 99 %"
    if 0 < share < 0.01:
        return "under 1 %"
    return f"{100 * share:.0f} %"


def sure(found: Subgoals, posterior: Posterior | None = None) -> str:
    """ "3 subgoals, 95 % sure of the number; 1 smaller place below 5 %"."""
    return f"{counted(found.n_subgoals, 'subgoal')}, {certainty(found, posterior)}"


def certainty(found: Subgoals, posterior: Posterior | None = None) -> str:
    """ "95 % sure of the number; 1 smaller place below 5 %"; no certainty from chains that have not converged.

    Where another number is more probable than that of the places with 5 % in expectation, it is told instead.
    """
    chances = found.n_subgoals_distribution
    likeliest = max(chances, key=lambda k: chances[k])
    told = f"{percent(min(chances.get(found.n_subgoals, 0.0), 0.999))} sure of the number"
    if likeliest != found.n_subgoals:
        told = f"on average; {likeliest} at a time is the most probable ({percent(chances[likeliest])})"
    if posterior is not None and posterior.status is not Status.CONVERGED:
        told = "not settled: the chains have not converged"
    small = len(found) - found.n_subgoals
    return f"{told}; {counted(small, 'smaller place')} below {percent(COUNTED_FROM)}" if small else told


def headline(posterior: Posterior, found: Subgoals) -> str:
    """ "3 subgoals in 7 trajectories (357 observations)"."""
    demos = posterior.demonstrations
    rows = counted(demos.n_observations, "observation")
    if demos.n_trajectories == demos.n_observations:
        return f"{counted(found.n_subgoals, 'subgoal')} in {rows}"
    return f"{counted(found.n_subgoals, 'subgoal')} in {trajectories(demos.n_trajectories)} ({rows})"


def trajectories(number: int) -> str:
    """ "1 trajectory", "7 trajectories"."""
    return f"{number:,} trajector" + ("y" if number == 1 else "ies")


def marker_label(goal: Subgoal) -> str:
    """The number, and the name where the place has one of its own."""
    return str(goal.label) if goal.name == f"subgoal {goal.label}" else f"{goal.label} {goal.name}"


def compact(values: Floats, extent: float) -> str:
    """Coordinates "(12.3, 4.0)" to a three-hundredth of the extent of the data."""
    digits = decimals(extent)
    return "(" + ", ".join(f"{round(float(v), digits) + 0.0:.{digits}f}" for v in values) + ")"


def extent_of(posterior: Posterior) -> float:
    """Largest range of the places over the dimensions."""
    return float(np.ptp(places_of(posterior.demonstrations), axis=0).max())


def decimals(extent: float, parts: float = 300.0) -> int:
    """Digits after the point that tell ``parts`` parts of ``extent`` apart."""
    if not extent > 0 or not np.isfinite(extent):
        return 3
    return int(np.clip(np.ceil(np.log10(parts / extent)), 0, 9))


def reading(posterior: Posterior, residuals: Residuals) -> str:
    """What the residuals say of the confidence, in one sentence."""
    confidence = f"confidence {posterior.confidence:g}"
    if not residuals.transform.size:
        return "No observation says anything of its distance."
    ordered = np.sort(residuals.transform)
    mean = float(ordered.mean())
    if mean < 0.5 - OFF_CENTRE:
        return f"The demonstrator is more precise than {confidence} says: a higher one would fit better."
    if mean > 0.5 + OFF_CENTRE:
        return f"The demonstrator is less precise than {confidence} says: a lower one would fit better."
    steps = np.arange(1, ordered.size + 1) / ordered.size
    if np.abs(ordered - steps).max() > OFF_SHAPE:
        return f"On average the distances are those of {confidence}, but their shape is another."
    return f"The distances are about what {confidence} expects."
