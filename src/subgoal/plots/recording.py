"""What a recording looks like before anything is learned from it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.demonstrations.records import Demonstrations, Recording
from subgoal.plots.shown import Shown, clock_of, places_of, shown
from subgoal.plots.style import FAINT, PALETTE, SMALL, TEXT, equal_limits, limits, new_figure, panel, with_unit
from subgoal.plots.words import counted, trajectories
from subgoal.runtime.checks import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BINS = 40
EVEN = 1e-6
"""A relative spread below this is rounding: the values are one value."""
FULL = 0.99
"""Histograms end at this quantile; what lies above is told."""


def plot_recording(data: Recording | Demonstrations, *, y_down: bool = False) -> Figure:
    """Paths with their starts and ends, the time steps, and the speeds between samples."""
    places, part = places_of(data), shown(data.offset)
    notes = [part.note] if part.note else []
    if places.shape[1] > 2:
        notes.append(f"first 2 of {places.shape[1]} dimensions")
    title = f"{data.source.name}: {trajectories(data.n_trajectories)}, {counted(len(places), 'sample')}"
    figure = new_figure(12.0, 6.0, title, None, notes, left=0.07)
    clock, label = clock_of(data)
    if places.shape[1] == 1:
        flat, across = np.column_stack([clock, places[:, 0]]), label
        up = with_unit(data.names[0], data.units)
    else:
        flat = places[:, :2]
        across, up = (with_unit(name, data.units) for name in data.names[:2])
    axes = panel(figure, (0.07, 0.13, 0.5, 0.76), "", across, up)
    _paths(axes, data, flat, part)
    if places.shape[1] > 1:
        equal_limits(axes, flat[:, 0], flat[:, 1])
    else:
        axes.set_xlim(*limits(flat[:, 0]))
        axes.set_ylim(*limits(flat[:, 1]))
    if y_down:
        axes.invert_yaxis()
    inside = np.setdiff1d(np.arange(1, len(places)), data.offset)
    steps = clock[inside] - clock[inside - 1] if data.times is not None else np.empty(0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        speeds = np.linalg.norm(places[inside] - places[inside - 1], axis=1) / (steps if steps.size else 1.0)
    _histogram(figure, (0.645, 0.57, 0.33, 0.32), steps, f"time between samples [{data.time_unit}]")
    per = data.time_unit if steps.size else "sample"
    _histogram(figure, (0.645, 0.13, 0.33, 0.30), speeds, f"speed [{data.units or 'units'}/{per}]")
    return figure


def _paths(axes: Axes, data: Recording | Demonstrations, flat: Floats, part: Shown) -> None:
    from matplotlib.collections import LineCollection

    many = part.rows.size > 2_000
    alpha = float(np.clip(30 / len(part.trajectory), 0.25, 0.9))
    axes.add_collection(
        LineCollection(part.paths(flat), colors="#5B6470", linewidths=0.8, alpha=alpha, rasterized=many), autolim=False
    )
    size = float(np.clip(3000 / len(part.trajectory), 6, 36))
    first, last = data.offset[part.trajectory], data.offset[part.trajectory + 1] - 1
    for rows, marker, shade, name in ((first, "o", PALETTE[2], "start"), (last, "s", PALETTE[1], "end")):
        axes.scatter(flat[rows, 0], flat[rows, 1], s=size, marker=marker, color=shade, edgecolor="white", label=name,
                     linewidths=0.4, zorder=3)  # fmt: skip
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False, fontsize=SMALL, borderpad=0.1)


def _histogram(figure: Figure, place: tuple[float, float, float, float], values: Floats, label: str) -> None:
    axes = panel(figure, place, "", label, "share of steps")
    values = values[np.isfinite(values)]
    if not values.size:
        axes.text(0.5, 0.5, "nothing to measure", transform=axes.transAxes, ha="center", color=FAINT, fontsize=TEXT)
        axes.set_xticks([])
        axes.set_yticks([])
        return
    top = float(np.quantile(values, FULL))
    top = float(values.max()) if values.max() <= 1.5 * top else top
    inside = values[values <= top]
    even = np.ptp(inside) <= EVEN * abs(top)
    low, high = limits(np.array([top]), 0.02) if even else (float(inside.min()), top)
    heights, edges = np.histogram(inside, BINS, (low, high))
    axes.bar(edges[:-1], heights / values.size, np.diff(edges), align="edge", color="#A9C6DD", edgecolor="white",
             linewidth=0.4)  # fmt: skip
    beyond = values.size - inside.size
    told = f"median {np.median(values):.4g}" + (f"; {beyond:,} above, up to {values.max():.4g}" if beyond else "")
    axes.set_title(told, fontsize=SMALL, color=FAINT, loc="right")
