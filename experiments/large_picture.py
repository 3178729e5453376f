"""The picture of figure 5-3: seconds and loss against the number of states."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, MARKERS, PALETTE, Headline, sheet
from experiments.large_methods import ABBEEL, ABBEEL_RTDP, EXACT, PARALLEL, RTDP, SWEEPS
from subgoal.runtime.checks import Floats

COLOURS = {
    SWEEPS: PALETTE[1], EXACT: PALETTE[2], RTDP: PALETTE[0], PARALLEL: PALETTE[4], ABBEEL: PALETTE[6],
    ABBEEL_RTDP: PALETTE[3],
}  # fmt: skip
MARKER = dict(zip(COLOURS, MARKERS, strict=False))
LEAST_LOSS = 0.01
"""Losses below it are drawn there."""
APART = 0.075
"""Of the height of a panel, between labels."""


def picture(headline: Headline) -> Figure:
    """Two panels with lines that carry their names."""
    rows = headline["rows"]
    most = max(row["cells"] for row in rows)
    figure = sheet(14.4, 6.4)
    figure.suptitle(f"Planning around the demonstration does not ask how large the world is: up to {most:,} cells")
    cost, fit = figure.subplots(1, 2)
    clock = f"{PARALLEL},\nby the clock, not alone"
    name_lines(cost, [draw_line(cost, rows, name, "seconds", clock if name == PARALLEL else name) for name in COLOURS])
    losses = [draw_line(fit, rows, name, "loss", name) for name in COLOURS if name not in (PARALLEL, RTDP)]
    losses.append(draw_line(fit, rows, RTDP, "loss_of_the_middle", RTDP))
    losses.append(
        draw_line(fit, rows, RTDP, "loss", "BNIRL, RTDP, if what its bounds\nleave open is drawn by lot", "--")
    )
    name_lines(fit, losses)
    cost.set(title="Seconds from a demonstration to what is learned", xlabel="states of the world")
    fit.set(title="Share of the actions that the learned policy has wrong", xlabel="states of the world")
    fit.text(0.02, 0.02, f"{LEAST_LOSS} or less at the foot", transform=fit.transAxes, fontsize=8.5, color=INK)
    draw_words(cost, headline)
    return figure


End = tuple[float, float, str, str]
"""Where a line ends, its name, its colour."""


def draw_line(axis: Axes, rows: list[Headline], method: str, field: str, name: str, style: str = "-") -> End | None:
    """One method; what was scaled up is hollow and dotted."""
    axis.set(xscale="log", yscale="log")
    some = [row for row in rows if row["method"] == method and row[field] is not None]
    if not some:
        return None
    colour, least = COLOURS[method], 0.0 if field == "seconds" else LEAST_LOSS
    x, y = np.array([[row["states"], max(row[field], least)] for row in some]).T
    scaled = np.array([row["scaled_from_candidates"] is not None for row in some])
    first = max(int((~scaled).sum()) - 1, 0)
    axis.plot(x[~scaled], y[~scaled], style, color=colour, lw=1.8)
    axis.plot(x[first:], y[first:], ":", color=colour, lw=1.5)
    axis.plot(x[~scaled], y[~scaled], MARKER[method], color=colour, ms=5.5)
    axis.plot(x[scaled], y[scaled], MARKER[method], color=colour, ms=6, mfc="white")
    return float(x[-1]), float(y[-1]), name, colour


def name_lines(axis: Axes, drawn: list[End | None]) -> None:
    """Names in a column at the right, in the order of the ends of the lines, none over another."""
    ends = [end for end in drawn if end is not None]
    low, high = axis.get_ylim()
    heights = [np.log(y / low) / np.log(high / low) for _, y, _, _ in ends]
    order = np.argsort(heights)
    placed: Floats = np.array(heights)[order]
    for k in range(1, placed.size):
        placed[k] = max(placed[k], placed[k - 1] + APART)
    placed -= max(0.0, float(placed[-1]) - 0.98)
    for k in range(placed.size - 2, -1, -1):
        placed[k] = min(placed[k], placed[k + 1] - APART)
    for k, height in zip(order, placed, strict=True):
        x, y, name, colour = ends[k]
        axis.annotate(
            name, (x, y), xytext=(1.03, height), textcoords="axes fraction", color=colour, weight="bold", va="center",
            fontsize=9, annotation_clip=False, arrowprops={"arrowstyle": "-", "color": colour, "lw": 0.4},
        )  # fmt: skip


def draw_words(axis: Axes, headline: Headline) -> None:
    """How many times RTDP is faster, and from where on."""
    told = "\n".join(f"{states:,.0f} states: {ratio:,.0f}" for states, ratio in headline["value_iteration_over_rtdp"])
    axis.text(
        0.98, 0.02, f"value iteration takes so many\ntimes as long as RTDP:\n{told}", transform=axis.transAxes,
        ha="right", va="bottom", fontsize=8.5, color=COLOURS[SWEEPS],
    )  # fmt: skip
    axis.text(0.02, 0.98, "hollow: timed on a few\ncandidates and scaled up", transform=axis.transAxes, va="top",
              fontsize=8.5, color=COLOURS[SWEEPS])  # fmt: skip
    where: Any = headline["crossover_with_first_passage_in_states"]
    if where is not None:
        axis.axvline(where, color=GREY, lw=1, ls="--")
        axis.annotate(
            f"from about {float(f'{where:.2g}'):,.0f} states on\nRTDP is faster than first passage", (where, 0.34),
            xycoords=("data", "axes fraction"), xytext=(5, 0), textcoords="offset points", va="top", fontsize=8.5,
            color=INK,
        )  # fmt: skip
