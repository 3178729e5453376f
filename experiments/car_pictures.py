"""Pictures of drives: the path in the colours of its subgoals, the subgoals as little cars, methods side by side."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from experiments.car_study import LEAST_SHARE, Labels, Run
from experiments.common import GREY, INK, PALETTE, sheet
from subgoal.dynamics.driver import path
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints

WORDS = {
    "AWD n1": "all wheels driven", "AWD n2": "all wheels,\nnoise doubled", "AWD open": "all wheels,\nno feedback",
    "AWD shuffled": "all wheels,\nany order", "RWD n1": "rear wheels driven:\nunstable drift",
    "RWD n1.5": "rear wheels,\nnoise × 1.5", "RWD shuffled": "rear wheels,\nany order",
    "RWD friction −15 %": "rear wheels, planner's\nfriction 15 % low",
}  # fmt: skip
SHOWN = {
    "temporal": ("o", PALETTE[0]), "exchangeable": ("s", PALETTE[4]), "thesis, with filter": ("^", PALETTE[1]),
    "thesis": ("v", PALETTE[3]), "oracle: the six true places": ("_", INK),
}  # fmt: skip


def manoeuvre_page(run: Run, found: Posterior, rows: dict[str, Any], rival: str) -> Figure:
    """The drive, its subgoals, script and answer over time, and V by condition and method."""
    figure = sheet(13.0, 9.4)
    grid = figure.add_gridspec(3, 2, height_ratios=(3.4, 0.8, 2.6), width_ratios=(1.25, 1))
    names = list(run.driven.places)
    label, number = found.best_assignment, named(run, found)
    drawn_path(figure.add_subplot(grid[0, 0]), run, np.array([number.get(int(g), -1) for g in label]))
    subgoal_cars(figure.add_subplot(grid[0, 1]), run, found, number)
    strips(figure.add_subplot(grid[1, :]), run, np.array([number.get(int(g), -1) for g in label]), names)
    by_condition(figure.add_subplot(grid[2, :]), rows, rival)
    told = len([g for g in number if g in set(main_subgoals(label).tolist())])
    figure.suptitle(f"Thirty seconds at the wheel, never segmented: {told} subgoals found, and what they are",
                    x=0.01, ha="left")  # fmt: skip
    return figure


def main_subgoals(label: Labels) -> Ints:
    """Candidates that serve at least 3 % of the pairs, by first use."""
    used, first, count = np.unique(label, return_index=True, return_counts=True)
    kept = count >= LEAST_SHARE * label.size
    return np.asarray(used[kept][np.argsort(first[kept])])


def named(run: Run, found: Posterior) -> dict[int, int]:
    """For each main subgoal the number of the nearest true steady state, which gives colour and name."""
    main = main_subgoals(found.best_assignment)
    distance = run.metric.distance(found.candidates.points[main][:, None], run.truth[None])
    return dict(zip(main.tolist(), distance.argmin(axis=1).tolist(), strict=True))


def colour(number: int) -> str:
    """Of a manoeuvre; grey for what serves less than 3 % of the time."""
    return PALETTE[number] if number >= 0 else GREY


def drawn_path(axes: Axes, run: Run, label: Ints) -> None:
    """The path from above, in the colours of the subgoals."""
    demos = run.driven.demonstrations
    xy = path(demos.states, demos.times)[:, :2]
    fine = run.at_full_rate(label)
    pieces = np.stack([xy[:-1], xy[1:]], axis=1)
    axes.add_collection(LineCollection(list(pieces), colors=[colour(k) for k in fine[:-1]], linewidths=2.4))
    axes.plot(*xy[0], "o", color=INK, ms=7, zorder=5)
    axes.annotate("start", xy[0], xytext=(6, 6), textcoords="offset points")
    axes.autoscale()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(title="The path, in the colours of the subgoals", xlabel="x (m)", ylabel="y (m)")


def subgoal_cars(axes: Axes, run: Run, found: Posterior, number: dict[int, int]) -> None:
    """Each subgoal as a car: the arrow is its velocity, the turned outline its yaw rate in a quarter of a second."""
    names = list(run.driven.places)
    for place, (g, k) in enumerate(sorted(number.items(), key=lambda item: item[1])):
        vx, vy, rate, wheel = found.candidates.points[g]
        at = np.array([place % 3, 1 - place // 3]) * np.array([2.6, 2.9])
        axes.add_patch(Polygon(at + _outline(0.0), closed=True, facecolor="#eeeeee", edgecolor=GREY))
        axes.add_patch(Polygon(at + _outline(rate / 4), closed=True, fill=False, edgecolor=colour(k), lw=2))
        if np.hypot(vx, vy) > 0.05:
            axes.annotate(
                "", at + 0.55 * np.array([vx, vy]), at,
                arrowprops={"arrowstyle": "-|>", "color": colour(k), "lw": 2.4, "mutation_scale": 16},
            )  # fmt: skip
        axes.text(at[0] + 0.15, at[1] - 0.78, names[k], ha="center", va="top", weight="bold", color=colour(k))
        told = f"{vx:.1f}, {vy:.1f} m/s; {rate:.1f} rad/s\nwheels {wheel:.1f} m/s"
        axes.text(at[0] + 0.15, at[1] - 1.06, told, ha="center", va="top", fontsize=8)
    axes.set_xlim(-1.2, 6.9)
    axes.set_ylim(-1.9, 3.9)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title("The subgoals: velocity (arrow), turning (coloured outline)")


def _outline(turn: float) -> Floats:
    corners = np.array([[0.42, 0.16], [0.42, -0.16], [-0.42, -0.16], [-0.42, 0.16]])
    spin = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    return np.asarray(corners @ spin)


def strips(axes: Axes, run: Run, label: Ints, names: list[str]) -> None:
    """Script above, answer below, over time."""
    times = np.asarray(run.driven.demonstrations.times)
    for row, values in ((1, run.driven.labels), (0, run.at_full_rate(label))):
        cuts = np.flatnonzero(np.diff(values)) + 1
        for start, stop in zip([0, *cuts], [*cuts, len(values)], strict=True):
            begin, end = times[start], times[stop - 1] + times[1] - times[0]
            axes.barh(row, end - begin, left=begin, height=0.8, color=colour(int(values[start])), lw=0)
            if row == 1:
                axes.text((begin + end) / 2, 1, names[values[start]], ha="center", va="center", color="white",
                          fontsize=8.5)  # fmt: skip
    axes.set_yticks([1, 0], ["script", "found"])
    axes.set_xlim(times[0], times[-1])
    axes.grid(False)
    axes.set_xlabel("time (s)")


def by_condition(axes: Axes, rows: dict[str, Any], rival: str) -> None:
    """V-measure of every method in every condition, mean and range over drivers; runs with six beside the temporal."""
    shown = {**SHOWN, rival: ("x", GREY)}
    for x, (_, row) in enumerate(rows.items()):
        for shift, (method, (marker, ink)) in enumerate(shown.items()):
            if method in row:
                at = x + 0.11 * (shift - 2.5)
                axes.plot([at, at], [row[method]["v_measure_min"], row[method]["v_measure"]], color=ink, lw=1)
                axes.plot(
                    at, row[method]["v_measure"], marker, color=ink, ms=8, label=_legend(method) if not x else None
                )
        six, runs = row["temporal"]["six_of"]
        axes.text(x - 0.275, row["temporal"]["v_measure"] + 0.05, f"six in {six}/{runs}", ha="center", fontsize=8.5)
    axes.set_xticks(range(len(rows)), [WORDS[name] for name in rows])
    axes.set_xlim(-0.6, len(rows) - 0.4)
    axes.set_ylim(0, 1.1)
    axes.set_ylabel("V-measure")
    axes.set_title("Agreement with the script: mean over drivers, down to the least")
    axes.legend(ncols=2, loc="lower right", bbox_to_anchor=(1.0, 0.1), fontsize=8.5)


def _legend(method: str) -> str:
    forms = ("temporal", "exchangeable", "thesis")
    return f"GPSRL, {method}" if method.startswith(forms) else method
