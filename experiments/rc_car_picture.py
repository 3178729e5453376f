"""Pictures of a car driven by hand: path, strips over time and a phase portrait in the colours of the subgoals."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.common import GREY, INK, MARKERS, PALETTE, sheet
from experiments.recorded_car import Recorded
from experiments.recorded_study import Answer
from subgoal.continuous import held_rows
from subgoal.runtime.checks import Floats, Ints

STILL, FAST, TURNING = 0.3, 1.75, 0.5
"""m/s, m/s and rad/s: below, above and above which a state is called still, fast and turning."""


def words(state: Floats) -> str:
    """A state (yaw rate, wheel speed) in words, such as "fast left"."""
    rate, wheels = state
    if abs(wheels) < STILL and abs(rate) < TURNING:
        return "stop"
    pace = "reverse" if wheels < -STILL else "fast" if wheels > FAST else "slow"
    return f"{pace} {'straight' if abs(rate) < TURNING else 'left' if rate > 0 else 'right'}"


def page(car: Recorded, every: dict[str, Answer], headline: dict[str, Any], hold: int) -> Figure:
    """Path, phase portrait, and the cut of the whole beside those of the halves."""
    figure = sheet(13.0, 10.2)
    whole = every["whole"]
    grid = figure.add_gridspec(3, 2, height_ratios=(3.6, 1.5, 1.0), width_ratios=(1, 1.45))
    label = whole.label[held_rows(car.demonstrations(headline["settings"]["state"]), hold)]
    drawn_path(figure.add_subplot(grid[0, 0]), car, label)
    portrait(figure.add_subplot(grid[0, 1]), every, headline)
    over_time(figure.add_subplot(grid[1, :]), car, label)
    strips(figure.add_subplot(grid[2, :]), car, every, hold)
    figure.suptitle(
        f"{headline['seconds_recorded']:.0f} seconds of a car driven by hand, no labels and no model: "
        f"{whole.goals.n_candidates} subgoals", x=0.01, ha="left",
    )  # fmt: skip
    return figure


def drawn_path(axes: Axes, car: Recorded, label: Ints) -> None:
    """From above, in the colours of the subgoals."""
    for begin, end in zip(car.offset[:-1], car.offset[1:], strict=True):
        xy = car.path[begin:end]
        pieces = np.stack([xy[:-1], xy[1:]], axis=1)
        axes.add_collection(LineCollection(list(pieces), colors=[PALETTE[k] for k in label[begin:end]], linewidths=2.2))
    axes.plot(*car.path[0], "o", color=INK, ms=7, zorder=5)
    axes.annotate("start", car.path[0], xytext=(8, -4), textcoords="offset points")
    axes.autoscale()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title="The path, in the colours of the subgoals", xlabel="x (m)", ylabel="y (m)")


def portrait(axes: Axes, every: dict[str, Answer], headline: dict[str, Any]) -> None:
    """Pairs by wheel speed and yaw rate; large marks are subgoals of the whole, rings those of the halves."""
    whole = every["whole"]
    states = np.asarray(whole.pairs.states)
    axes.scatter(states[:, 1], states[:, 0], s=9, c=[PALETTE[k] for k in whole.label], alpha=0.5, lw=0)
    handles = []
    for k in np.argsort(-whole.shares):
        point = whole.goals.points[k]
        axes.plot(point[1], point[0], "o", color=PALETTE[k], mec="white", mew=1.2, ms=14, zorder=5)
        told = f"{words(point)}: {whole.shares[k]:.0%} ({point[1]:.1f} m/s, {round(point[0], 1) + 0.0:.1f} rad/s)"
        handles.append(Line2D([], [], marker="o", ls="", color=PALETTE[k], ms=10, label=told))
    for which, marker in zip(("first half", "second half"), (MARKERS[1], MARKERS[2]), strict=True):
        points = every[which].goals.points
        axes.plot(points[:, 1], points[:, 0], marker, mfc="none", mec=INK, mew=1.4, ms=17, zorder=6)
        handles.append(
            Line2D([], [], marker=marker, ls="", mfc="none", mec=INK, ms=10, label=f"learned on the {which}")
        )
    axes.legend(handles=handles, loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8.5)
    axes.set(title="Where it drives, and where it wants to be", xlabel="speed of the wheels (m/s)",
             ylabel="yaw rate (rad/s), left is up")  # fmt: skip


def over_time(axes: Axes, car: Recorded, label: Ints) -> None:
    """Yaw rate in the colours of the subgoals, wheel speed in grey."""
    for begin, end in zip(car.offset[:-1], car.offset[1:], strict=True):
        rows = slice(begin, end)
        line = np.stack([car.times[rows], car.states["yaw rate"][rows]], axis=1)
        pieces = np.stack([line[:-1], line[1:]], axis=1)
        axes.add_collection(LineCollection(list(pieces), colors=[PALETTE[k] for k in label[rows]], linewidths=1.8))
        axes.plot(car.times[rows], car.states["wheels"][rows], color=GREY, lw=1)
    axes.autoscale()
    axes.set_xlim(0, car.times[-1])
    axes.set_title("Yaw rate (coloured, rad/s) and speed of the wheels (grey, m/s)")


def strips(axes: Axes, car: Recorded, every: dict[str, Answer], hold: int) -> None:
    """The cut of the whole above, those of the halves below, each in the colour of the nearest subgoal of the whole."""
    metric = every["whole"].found.candidates.metric
    goals = every["whole"].goals.points
    names = tuple(every["whole"].pairs.names)
    for row, which, pieces in ((1, "whole", None), (0, "first half", (0,)), (0, "second half", (1,))):
        given = every[which]
        nearest = metric.distance(given.goals.points[:, None], goals[None]).argmin(axis=1)
        demos = car.demonstrations(names, pieces)
        times, label = np.asarray(demos.times), nearest[given.label[held_rows(demos, hold)]]
        cuts = np.flatnonzero((np.diff(label) != 0) | (np.diff(times) > 0.5)) + 1
        for start, stop in zip([0, *cuts], [*cuts, len(label)], strict=True):
            axes.barh(row, times[stop - 1] - times[start] + 0.05, left=times[start], height=0.8,
                      color=PALETTE[label[start]], lw=0)  # fmt: skip
    axes.set_yticks([1, 0], ["learned on all", "each half alone"])
    axes.set_xlim(0, car.times[-1])
    axes.grid(False)
    axes.set_title("Which subgoal when; of the halves in the colour of the nearest subgoal of the whole")
    axes.set_xlabel("time (s)")
