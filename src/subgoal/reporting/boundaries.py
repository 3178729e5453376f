"""How sure the cuts between segments are, step by step, along one trajectory."""

from __future__ import annotations

from typing import Any

import numpy as np

from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import Subgoals
from subgoal.plots.shown import clock_of, is_unordered
from subgoal.plots.strips import strip_bars
from subgoal.plots.style import INK
from subgoal.plots.words import counted
from subgoal.posterior.posterior import EXCHANGEABLE, Posterior
from subgoal.reporting.interactive import axis, layout, segment_bars
from subgoal.reporting.pieces import lead, section

SURE = 0.9
MOST_STEPS = 4000


def boundary_section(posterior: Posterior, found: Subgoals, cut: Segments, figures: dict[str, Any]) -> str:
    """Segments of the trajectory with the most of them over the probability of a boundary at each step."""
    if cut.boundary is None or is_unordered(posterior.demonstrations):
        return ""
    chosen = shown_trajectory(posterior, cut)
    figures["boundaries"] = boundary_figure(posterior, found, cut, chosen)
    return section("Boundaries", lead(told_of(posterior, cut, chosen)) + '<div class="plot" id="boundaries"></div>')


def shown_trajectory(posterior: Posterior, cut: Segments) -> int:
    """The one with the most segments; of several, the first."""
    owner = [segment.trajectory for segment in cut]
    return int(np.bincount(owner, minlength=posterior.demonstrations.n_trajectories).argmax())


def told_of(posterior: Posterior, cut: Segments, trajectory: int) -> str:
    """How many boundaries are expected in a trajectory, how many are sure, and how the picture is read."""
    demos = posterior.demonstrations
    start, stop = demos.offset[trajectory : trajectory + 2].tolist()
    inside = np.asarray(cut.boundary)[start + 1 : stop]
    sure = int((inside >= SURE).sum())
    steps = f"{sure or 'none'} of {counted(stop - start, 'step')} {'are' if sure > 1 else 'is'}"
    return (
        f"Trajectory {demos.trajectory_names[trajectory]}: {inside.sum():.1f} changes of subgoal are expected, and "
        f"{steps} a sure one (at least 90 %). A tall thin bar is "
        "a cut at a known moment; a low wide hill is a change whose moment is not known."
        + why_not_as_many(posterior, cut, trajectory, float(inside.sum()))
    )


def why_not_as_many(posterior: Posterior, cut: Segments, trajectory: int, expected: float) -> str:
    """Why the changes that are expected are not those between the segments; empty where they are about as many."""
    count = sum(segment.trajectory == trajectory for segment in cut)
    if abs(expected - (count - 1)) < 1:
        return ""
    loose = expected > count and posterior.settings.model.startswith((EXCHANGEABLE, "Grouped("))
    why = ", and in this model, in which nothing lasts, steps that are unsure switch to and fro" if loose else ""
    return (
        f" The {counted(count, 'segment')} above have {counted(count - 1, 'change')} between them: segments follow the "
        f"most probable subgoal of each step, while expected changes are those within a draw{why}."
    )


def boundary_figure(posterior: Posterior, found: Subgoals, cut: Segments, trajectory: int) -> dict[str, Any]:
    """The segments above, P(boundary) below, over the same time."""
    demos = posterior.demonstrations
    start, stop = demos.offset[trajectory : trajectory + 2].tolist()
    clock, across = clock_of(demos)
    bars, _ = strip_bars(posterior, cut, demos.n_trajectories)
    data = segment_bars(
        posterior, found, [bar for bar in bars if bar.row == trajectory], row=0, axes={"yaxis": "y2"}
    )  # fmt: skip
    rows = np.arange(start + 1, stop)[:MOST_STEPS]
    chance = np.round(np.asarray(cut.boundary)[rows], 4)
    width = float(np.median(np.diff(clock[start:stop]))) if stop - start > 1 else 1.0
    data.append({
        "type": "bar", "name": "P(boundary)", "x": np.round(clock[rows], 6), "y": chance,
        "width": 0.9 * width, "offset": 0, "marker": {"color": INK, "line": {"width": 0}}, "showlegend": False,
        "hovertemplate": "%{x}: %{y:.0%}<extra></extra>",
    })  # fmt: skip
    top = {"domain": [0.72, 1], "range": [0.5, -0.5], "showgrid": False, "showticklabels": False}
    return {"data": data, "layout": layout(
        300, barmode="overlay", xaxis=axis(across, anchor="y"),
        yaxis=axis("P(change here)", domain=[0, 0.64], range=[0, 1.02], tickformat=".0%"), yaxis2=axis("", **top),
        legend={"orientation": "h", "y": 1.0, "yanchor": "bottom", "x": 0},
    )}  # fmt: skip
