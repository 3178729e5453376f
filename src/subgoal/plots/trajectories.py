"""The main figure: trajectories, observations coloured by their subgoal, and the subgoals on top."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.answers.segments import Segments
from subgoal.answers.subgoals import Subgoal, Subgoals
from subgoal.plots.shown import Shown, clock_of, ends_of, is_unordered, places_of, shown
from subgoal.plots.style import (
    INK,
    OTHER_COLOUR,
    PATH_COLOUR,
    SMALL,
    TEXT,
    colour,
    equal_limits,
    ink_on,
    limits,
    new_figure,
    panel,
    plain,
    with_unit,
)
from subgoal.plots.words import marker_label, percent, sure
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_ARROWS = 1_000
ARROW = 0.025
"""Length of an arrow as a share of the extent."""
MOST_LISTED = 14
"""So many subgoals stand in the key; the markers show all."""


def plot_trajectories(posterior: Posterior, found: Subgoals, cut: Segments, *, y_down: bool = False) -> Figure:
    """Where the demonstrator went and what for.

    Thin grey lines are the trajectories, dots the observations in the colour of their subgoal, short arrows the
    directions of the actions (up to 1,000 observations), numbered discs the subgoals, diamonds the other candidates
    merged into them, and rings the credible sets. One dimension is drawn against time, two as a map, three or more as
    projections of the first three. ``y_down`` turns the second axis over, as in images.
    """
    demos = posterior.demonstrations
    dimension = places_of(demos).shape[1]
    part = shown(demos.offset)
    notes = [part.note] if part.note else []
    if dimension > 3:
        notes.append(f"first 3 of {dimension} dimensions")
    if dimension == 1:
        figure = new_figure(9.6, 6.0, sure(found, posterior), posterior, notes, left=0.08)
        _against_time(figure, posterior, found, cut, part)
        _key(figure, found, cut, 0.785, 0.86)
        return figure
    pairs = [(0, 1)] if dimension == 2 else [(0, 1), (0, 2), (1, 2)]
    width, key, bottom, top = (9.6, 0.785, 0.12, 0.87) if len(pairs) == 1 else (15.0, 0.865, 0.14, 0.84)
    figure = new_figure(
        width, 6.4 if len(pairs) == 1 else 5.2, sure(found, posterior), posterior, notes, left=0.9 / width
    )
    each = (key - 0.015) / len(pairs)
    for k, pair in enumerate(pairs):
        left = each * k + 0.9 / width
        axes = panel(figure, (left, bottom, each - 1.0 / width, top - bottom), "", *_labels(posterior, pair))
        _map(axes, posterior, found, cut, part, pair)
        if y_down and 1 in pair:
            (axes.invert_yaxis if pair[1] == 1 else axes.invert_xaxis)()
    _key(figure, found, cut, key, top)
    return figure


def _labels(posterior: Posterior, pair: tuple[int, int]) -> tuple[str, str]:
    demos = posterior.demonstrations
    return with_unit(demos.names[pair[0]], demos.units), with_unit(demos.names[pair[1]], demos.units)


def _map(axes: Axes, posterior: Posterior, found: Subgoals, cut: Segments, part: Shown, pair: tuple[int, int]) -> None:
    """One projection onto the dimensions ``pair``."""
    from matplotlib.collections import LineCollection

    flat, ends = (read(posterior.demonstrations)[:, pair] for read in (places_of, ends_of))
    lines = LineCollection(part.paths(flat, ends), colors=PATH_COLOUR, linewidths=0.8, zorder=1, rasterized=_many(part))
    axes.add_collection(lines, autolim=False)
    dots = flat[part.rows]
    shades = [colour(int(k)) for k in cut.labels[part.rows]]
    size = float(np.clip(9000 / max(len(dots), 1), 4, 16))
    axes.scatter(
        dots[:, 0], dots[:, 1], s=size, c=shades, linewidths=0, zorder=2, rasterized=_many(part), gid="observations"
    )
    _arrows(axes, posterior, flat, shades, part, pair)
    for goal in reversed(found.listed):
        _ring(axes, posterior, goal, pair)
    for k in reversed(range(len(found.listed))):
        _disc(axes, posterior, found.listed[k], k, pair)
    marks = np.array([goal.position for goal in found.listed]).reshape(-1, posterior.candidates.points.shape[1])
    equal_limits(axes, *np.concatenate([flat, ends, marks[:, pair]]).T)


def _many(part: Shown) -> bool:
    return part.rows.size > 2_000


def _arrows(
    axes: Axes, posterior: Posterior, flat: Floats, shades: list[str], part: Shown, pair: tuple[int, int]
) -> None:
    """Directions of the actions, where they have as many dimensions as the places and there are not too many."""
    actions = np.asarray(posterior.demonstrations.actions, float).reshape(len(flat), -1)
    if part.rows.size > MOST_ARROWS or actions.shape[1] != posterior.candidates.points.shape[1]:
        return
    there = part.rows[~np.asarray(posterior.uninformative)[part.rows]]
    speed = np.linalg.norm(actions[there], axis=1, keepdims=True)
    ways = actions[there][:, pair] / np.where(speed > 0, speed, 1.0) * ARROW * float(np.ptp(flat, axis=0).max())
    tone = [shades[k] for k in np.flatnonzero(~np.asarray(posterior.uninformative)[part.rows])]
    axes.quiver(
        *flat[there].T, *ways.T, color=tone, angles="xy", scale_units="xy", scale=1.0, width=0.0018, headwidth=4,
        headlength=5, headaxislength=4.5, alpha=0.6, zorder=2.5,
    )  # fmt: skip


def _ring(axes: Axes, posterior: Posterior, goal: Subgoal, pair: tuple[int, int]) -> None:
    """The credible set as a ring of its radius in the metric, and the other members as diamonds."""
    from matplotlib.patches import Ellipse

    shade = colour(goal.label - 1)
    weights = posterior.candidates.metric.weights
    if goal.radius > 0:
        width, height = (2 * goal.radius / float(weights[k]) for k in pair)
        centre = (float(goal.position[pair[0]]), float(goal.position[pair[1]]))
        ring = Ellipse(centre, width, height, facecolor=shade, alpha=0.10, zorder=3, gid=f"credible set {goal.label}")
        axes.add_patch(ring)
        axes.add_patch(Ellipse(centre, width, height, facecolor="none", edgecolor=shade, linewidth=1.2, zorder=3.1))
    members = posterior.candidates.points[goal.members[1:]][:, pair]
    axes.scatter(
        members[:, 0], members[:, 1], s=26, marker="D", facecolor="white", edgecolor=shade, linewidths=1.2, zorder=4
    )


def _disc(axes: Axes, posterior: Posterior, goal: Subgoal, k: int, pair: tuple[int, int]) -> None:
    """The numbered disc of one subgoal, with its name if the place has one."""
    x, y = (float(goal.position[axis]) for axis in pair)
    axes.scatter(x, y, s=270, color=colour(k), edgecolor="white", linewidths=1.6, zorder=_above(k),
                 gid=f"subgoal {k + 1}")  # fmt: skip
    axes.text(
        x, y, str(goal.label), color=ink_on(colour(k)), fontsize=TEXT, weight="bold", ha="center",
        va="center_baseline", zorder=_above(k), clip_on=True,
    )  # fmt: skip
    label = marker_label(goal)
    if label != str(goal.label):
        axes.annotate(
            plain(goal.name), (x, y), (10, 8), textcoords="offset points", fontsize=SMALL, color=INK, zorder=6,
            bbox={"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 1.0},
        )  # fmt: skip


def _above(k: int) -> float:
    """Larger subgoals lie on top, each number on its own disc."""
    return 6.0 - k / 1000


def _key(figure: Figure, found: Subgoals, cut: Segments, left: float, top: float) -> None:
    """The subgoals by number, name and share, in their colours."""
    from matplotlib.lines import Line2D

    def handle(shade: str, label: str, marker: str = "o", size: float = 9, face: str | None = None) -> Line2D:
        return Line2D([], [], linestyle="", marker=marker, markersize=size, color=shade, label=plain(label),
                      markerfacecolor=face or shade)  # fmt: skip

    handles = [
        handle(colour(k), f"{_short(marker_label(goal))} · {percent(goal.share)}")
        for k, goal in enumerate(found.listed[:MOST_LISTED])
    ]
    if len(found.listed) > MOST_LISTED:
        handles.append(handle("white", f"and {len(found.listed) - MOST_LISTED} more"))
    if (cut.labels < 0).any():
        handles.append(handle(OTHER_COLOUR, "no listed subgoal", size=5))
    if any(len(goal.members) > 1 for goal in found.listed):
        handles.append(handle("#555555", "merged candidate", "D", 5, "white"))
    if any(goal.radius > 0 for goal in found.listed):
        handles.append(handle("#777777", "95 % credible set", "o", 11, "#EEEEEE"))
    legend = figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=(left, top), frameon=False, fontsize=SMALL,
        title="Subgoal · share", title_fontsize=TEXT, labelspacing=0.65, handletextpad=0.4, borderpad=0.0,
    )  # fmt: skip
    legend.set_alignment("left")


def _short(name: str, most: int = 14) -> str:
    return name if len(name) <= most else name[: most - 1] + "…"


def _against_time(figure: Figure, posterior: Posterior, found: Subgoals, cut: Segments, part: Shown) -> None:
    """One dimension: position against time, subgoals as lines across."""
    from matplotlib.collections import LineCollection

    demos = posterior.demonstrations
    clock, label = clock_of(demos)
    if is_unordered(demos):
        clock, label = np.arange(demos.n_observations, dtype=float), "observation"
    axes = panel(figure, (0.08, 0.13, 0.69, 0.73), "", label, with_unit(demos.names[0], demos.units))
    curve = np.column_stack([clock, places_of(demos)[:, 0]])
    axes.add_collection(
        LineCollection(part.paths(curve), colors=PATH_COLOUR, linewidths=0.8, zorder=1, rasterized=_many(part)),
        autolim=False,
    )
    shades = [colour(int(k)) for k in cut.labels[part.rows]]
    axes.scatter(
        curve[part.rows, 0], curve[part.rows, 1], s=10, c=shades, linewidths=0, zorder=2, rasterized=_many(part)
    )
    end = limits(clock)
    for k in reversed(range(len(found.listed))):
        goal = found.listed[k]
        axes.axhline(float(goal.position[0]), color=colour(k), linewidth=1.2, zorder=1.5)
        reach = goal.radius / float(posterior.candidates.metric.weights[0])
        axes.axhspan(float(goal.position[0]) - reach, float(goal.position[0]) + reach, color=colour(k), alpha=0.08)
        mark = posterior.candidates.points[goal.members[1:], 0]
        axes.scatter(np.full(mark.size, end[1]), mark, s=24, marker="D", facecolor="white", edgecolor=colour(k))
        spot = (end[1], float(goal.position[0]))
        axes.scatter(*spot, s=270, color=colour(k), edgecolor="white", zorder=_above(k), clip_on=False,
                     gid=f"subgoal {k + 1}")  # fmt: skip
        axes.text(*spot, str(goal.label), color=ink_on(colour(k)), fontsize=TEXT, weight="bold", ha="center",
                  va="center_baseline", zorder=_above(k))  # fmt: skip
    axes.set_xlim(*end)
    axes.set_ylim(*limits(np.concatenate([curve[:, 1], [goal.position[0] for goal in found.listed]])))
