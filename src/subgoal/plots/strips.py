"""Segments as coloured strips over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import Subgoals
from subgoal.plots.shown import clock_of, is_unordered
from subgoal.plots.style import OTHER_COLOUR, SMALL, colour, limits, new_figure, panel, plain
from subgoal.plots.words import marker_label, trajectories
from subgoal.posterior.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_ROWS = 40


@dataclass(frozen=True)
class Bar:
    """One segment as drawn: its row (0 on top), from and to in time since the start of its trajectory."""

    row: int
    start: float
    stop: float
    subgoal: int
    probability: float


def strip_bars(posterior: Posterior, cut: Segments, rows: int = MOST_ROWS) -> tuple[list[Bar], str]:
    """Bars of the first ``rows`` trajectories, each reaching to the next one, and the label of the time axis."""
    demos = posterior.demonstrations
    clock, label = clock_of(demos)
    inside = np.setdiff1d(np.arange(1, clock.size), demos.offset)
    step = float(np.median(clock[inside] - clock[inside - 1])) if inside.size else 1.0
    bars = []
    for segment in cut:
        if segment.trajectory >= rows:
            break
        last = segment.stop == demos.offset[segment.trajectory + 1]
        stop = clock[segment.stop - 1] + step if last else clock[segment.stop]
        bars.append(
            Bar(segment.trajectory, float(clock[segment.start]), float(stop), segment.subgoal, segment.probability)
        )
    return bars, label


def plot_segments(posterior: Posterior, found: Subgoals, cut: Segments) -> Figure:
    """Which part of each trajectory serves which subgoal: one row each (40 at most), pale where it is uncertain."""
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba

    demos = posterior.demonstrations
    rows = min(demos.n_trajectories, MOST_ROWS)
    bars, label = strip_bars(posterior, cut, rows)
    left_out = demos.n_trajectories - rows
    notes = [f"{left_out:,} more trajectories are not shown"] if left_out else []
    if is_unordered(demos):
        notes.append("unordered observations: each is a segment of its own")
    height = 1.9 + 0.22 * max(rows, 4)
    title = f"{len(cut):,} segments in {trajectories(demos.n_trajectories)}: the paler, the less sure"
    figure = new_figure(9.6, height, title, posterior, notes, left=0.13)
    place = (0.13, 0.85 / height, 0.69, 1 - 1.5 / height)
    axes = panel(figure, place, "", label, "")
    boxes = [
        ((b.start, b.row - 0.4), (b.stop, b.row - 0.4), (b.stop, b.row + 0.4), (b.start, b.row + 0.4)) for b in bars
    ]
    shades = [to_rgba(colour(b.subgoal), 0.15 + 0.85 * b.probability**2) for b in bars]
    axes.add_collection(PolyCollection(boxes, facecolors=shades, edgecolors="white", linewidths=0.4), autolim=False)
    axes.set_xlim(0, limits([b.stop for b in bars], 0)[1])
    axes.set_ylim(rows - 0.4, -0.6)
    axes.set_yticks(range(rows), [plain(name[:14]) for name in demos.trajectory_names[:rows]])
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0, labelsize=SMALL if rows <= 20 else 7.5)
    _legend(figure, found, cut, 1 - 0.62 / height)
    return figure


def _legend(figure: Figure, found: Subgoals, cut: Segments, top: float) -> None:
    from matplotlib.patches import Patch

    handles = [Patch(color=colour(k), label=plain(marker_label(goal)[:18])) for k, goal in enumerate(found.listed)]
    if (cut.labels < 0).any():
        handles.append(Patch(color=OTHER_COLOUR, label="none listed"))
    legend = figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(0.835, top), frameon=False, fontsize=SMALL, title="Subgoal",
        ncols=1 + (len(handles) > 12), labelspacing=0.4, handlelength=1.2, columnspacing=0.8,
    )  # fmt: skip
    legend.set_alignment("left")
