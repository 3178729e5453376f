"""Value functions and phase portraits of subgoals in a continuous world."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.answers.portraits import Portraits
from subgoal.answers.subgoals import Subgoals
from subgoal.plots.style import INK, SMALL, TEXT, colour, limits, new_figure, panel, plain, with_unit
from subgoal.plots.words import marker_label, percent
from subgoal.posterior.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_PANELS, ACROSS = 9, 3
PANEL, TOP, EDGE = (3.6, 3.0), 0.8, 0.75
"""Inches: width and height of a panel, and the margins above and at the side."""
VALUES = "cividis"
TITLE = "What each subgoal is worth from the states that were seen, and where it leads from there"
NOTES = ("colour: share of the discounted future that can be spent at the subgoal (ring); arrows: one step under the "
         "best test action",)  # fmt: skip


def plot_portraits(posterior: Posterior, found: Subgoals, seen: Portraits) -> Figure:
    """A panel for each of up to nine listed subgoals: observed states by their value, arrows for a step towards it."""
    goals = found.listed[:MOST_PANELS]
    columns = min(ACROSS, len(goals))
    lines = -(-len(goals) // columns)
    width = EDGE + columns * (PANEL[0] + 0.35) + 1.0
    height = TOP + lines * (PANEL[1] + 0.75) + 0.3
    figure = new_figure(width, height, TITLE, posterior, NOTES, left=EDGE / width)
    demos, (a, b) = posterior.demonstrations, seen.pair
    spans = [limits(np.append(seen.states[:, j], [goal.position[j] for goal in goals])) for j in (a, b)]
    for k, goal in enumerate(goals):
        line, column = divmod(k, columns)
        place = (
            (EDGE + column * (PANEL[0] + 0.35)) / width, 1 - (TOP + (line + 1) * (PANEL[1] + 0.75) - 0.5) / height,
            PANEL[0] / width, (PANEL[1] - 0.2) / height,
        )  # fmt: skip
        told = f"{marker_label(goal)}: {percent(goal.share)} of the time; held {seen.held[k]:.2f}"
        across = with_unit(demos.names[a], demos.units) if line == lines - 1 or k + columns >= len(goals) else ""
        axes = panel(figure, place, "", across, with_unit(demos.names[b], demos.units) if column == 0 else "")
        axes.set_title(plain(told), loc="left", fontsize=TEXT, color=colour(k), weight="bold")
        shade = axes.scatter(
            seen.states[:, a], seen.states[:, b], c=seen.values[:, k], cmap=VALUES, vmin=0, vmax=1, s=20, linewidths=0,
        )  # fmt: skip
        axes.quiver(
            *seen.states[:, [a, b]].T, *seen.moved[:, k][:, [a, b]].T, angles="xy", scale_units="xy", scale=1.0,
            width=0.0022, headwidth=4, color=INK, alpha=0.45,
        )  # fmt: skip
        axes.plot(
            *goal.position[[a, b]], "o", ms=13, markerfacecolor="none", markeredgecolor=colour(k), markeredgewidth=2.4
        )  # fmt: skip
        axes.set_xlim(*spans[0])
        axes.set_ylim(*spans[1])
    bar = figure.add_axes((1 - 0.85 / width, 0.5 / height, 0.16 / width, 1 - (TOP + 0.9) / height))
    figure.colorbar(shade, cax=bar).ax.tick_params(labelsize=SMALL)
    bar.set_title(plain("value"), fontsize=TEXT, color=INK)
    return figure
