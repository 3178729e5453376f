"""Drawings of figures 4-2 and 4-3 with the rivals: loss by iteration, and what is wrong in the end."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter, StrMethodFormatter

from experiments.common import GREY, INK, PALETTE, Headline, sheet
from experiments.grid_pictures import draw_map, draw_pairs, draw_subgoals
from experiments.grid_study import Run, Setting, true_cells
from experiments.linear_world import Shown
from experiments.rivals import ABBEEL, BAYESIAN, MARGIN
from subgoal.runtime.checks import Floats

TRUTH = "true reward"
COLOURS = {"BNIRL, subgoals that last": PALETTE[5]} | dict(zip(
    ("BNIRL, state subgoals", "BNIRL, feature subgoals", ABBEEL, MARGIN, BAYESIAN), PALETTE, strict=False,
))  # fmt: skip


def one_reward_picture(case: Shown, losses: dict[str, Floats], headline: Headline, reading: str) -> Figure:
    """Figure 4-2: what was seen, loss by iteration, and the end by both readings."""
    figure = sheet(13.5, 5.2)
    left, middle, right = figure.subplots(1, 3, width_ratios=(1, 1.15, 1.25))
    draw_map(left, case.grid)
    draw_pairs(left, case.grid, case.demonstrations)
    left.set_title("What was seen: five walks, one reward")
    ending = f", {reading}"
    drawn = {name.removesuffix(ending): values for name, values in losses.items() if name.endswith(ending)}
    draw_curves(middle, drawn)
    floor = headline["readings"][reading][TRUTH]["in_sample"]
    middle.axhline(floor, color=INK, lw=0.9, ls=":")
    middle.annotate("true reward, ties at random", (1, floor), xytext=(2, -10), textcoords="offset points", fontsize=8)
    middle.set(ylabel="pairs wrong, of 75", ylim=(0, None))
    middle.set_title("Wrong in sample, by iteration (mean)")
    draw_ends(right, headline, reading)
    return figure


def draw_curves(axis: Axes, losses: dict[str, Floats]) -> None:
    """Mean over the runs (R, T) by iteration, on a logarithmic axis of iterations."""
    for name, values in losses.items():
        iterations = np.arange(1, values.shape[1] + 1)
        axis.plot(iterations, values.mean(axis=0), color=COLOURS[name], label=name)
    axis.set_xscale("log")
    axis.set_xlabel("iteration")
    axis.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.legend(fontsize=8.5)


def draw_ends(axis: Axes, headline: Headline, reading: str) -> None:
    """In sample and held out in the end; ticks for the other reading, a band of three pairs above the best."""
    methods = {name: row for name, row in headline["readings"][reading].items() if name != TRUTH}
    other = next(rows for name, rows in headline["readings"].items() if name != reading)
    best = min(row["in_sample"] for row in methods.values())
    axis.axvspan(best, best + 3, color=PALETTE[5], alpha=0.25, lw=0, label="within 3 pairs of the best in sample")
    rows = np.arange(len(methods))
    for offset, key, shade, label in ((-0.19, "in_sample", 1.0, "in sample"), (0.19, "held_out", 0.4, "fresh walks")):
        values = [row[key] for row in methods.values()]
        colours = [COLOURS[name] for name in methods]
        bars = axis.barh(rows + offset, values, 0.36, color=colours, alpha=shade)
        axis.barh([0], [0], color=GREY, alpha=shade, label=label)
        axis.bar_label(bars, [f"{value:.1f}" for value in values], label_type="edge", padding=-24, fontsize=8.5,
                       color="white" if shade == 1 else INK)  # fmt: skip
        axis.plot([other[name][key] for name in methods], rows + offset, "|", color=INK, ms=11, mew=1.6)
    axis.plot([], [], "|", color=INK, ms=11, mew=1.6, ls="", label="as first set; bars: as chosen elsewhere")
    axis.set_yticks(rows, [name.replace(", ", ",\n") for name in methods])
    axis.set(xlabel="pairs wrong, of 75", ylim=(len(methods) + 1.1, -0.6))
    axis.grid(visible=False)
    axis.set_title(f"In the end, mean of {headline['runs']} runs")
    axis.legend(loc="lower left", fontsize=8.5)


def loop_picture(example: Run, setting: Setting, losses: dict[str, Floats], headline: Headline) -> Figure:
    """Figure 4-3: what was seen and found, loss by iteration, and the shares wrong in the end."""
    figure = sheet(11.5, 9.0)
    top_left, top_right, bottom_left, bottom_right = figure.subplots(2, 2).ravel()
    draw_map(top_left, example.grid)
    draw_pairs(top_left, example.grid, example.shown.demonstrations)
    top_left.set_title("What was seen: five rounds of a loop")
    draw_curves(top_right, losses)
    top_right.set(ylabel="share of pairs wrong", ylim=(0, 1))
    top_right.yaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    top_right.set_title("Wrong in sample, by iteration (mean)")
    draw_map(bottom_left, example.grid)
    draw_subgoals(bottom_left, example.grid, example.posterior, np.array(true_cells(example, setting.subgoals)))
    found = f"all four in {headline['runs_all_true_subgoals']} of {headline['runs']} runs"
    bottom_left.set_title(f"What was found, with shares ({found}; stars: the truth)")
    draw_shares(bottom_right, headline)
    return figure


def draw_shares(axis: Axes, headline: Headline) -> None:
    """Shares of pairs wrong in sample and held out, with the bounds of both sides."""
    shares = headline["wrong"]
    rows = np.arange(len(shares))
    for offset, key, shade, label in ((-0.19, "in_sample", 1.0, "in sample"), (0.19, "held_out", 0.4, "fresh rounds")):
        values = [row[key] for row in shares.values()]
        bars = axis.barh(rows + offset, values, 0.36, color=[COLOURS[name] for name in shares], alpha=shade)
        axis.barh([0], [0], color=GREY, alpha=shade, label=label)
        axis.bar_label(bars, [f"{value:.0%}" for value in values], padding=3, fontsize=8.5,
                       bbox={"facecolor": "white", "lw": 0, "pad": 0.6})  # fmt: skip
    for bound in (0.05, 0.20):
        axis.axvline(bound, color=INK, lw=0.9, ls="--", zorder=0)
        axis.annotate(
            f"{bound:.0%}", (bound, len(shares) - 0.45), xytext=(3, 0), textcoords="offset points", fontsize=8
        )
    axis.set_yticks(rows, [name.replace(", ", ",\n") for name in shares])
    axis.set(xlim=(0, 1.08), xlabel="share of pairs wrong", ylim=(len(shares) - 0.4, -0.6))
    axis.xaxis.set_major_formatter(PercentFormatter(1, decimals=0))
    axis.grid(visible=False)
    axis.set_title(f"In the end, mean of {headline['runs_compared']} runs")
    axis.legend(loc="upper right", fontsize=8.5)
