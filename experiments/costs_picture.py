"""Table 4.1 drawn: each cost over that of BNIRL, here and in the thesis, and what the closing cases need."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, sheet

TITLES = {
    "start": "To start",
    "iteration": "Each iteration",
    "iterations": "Iterations to converge",
    "total": "In all",
}
SHOWN = ("few pairs, many subgoals", "much data, one reward")
Told = tuple[float, float | None]
"""Worlds solved, and the share of pairs wrong."""


def picture(headline: Headline) -> Figure:
    """Four ratios above; plans to solve for in the example and in the closing cases below."""
    figure = sheet(13.0, 7.0)
    parts: Any = figure.subfigures(2, 1, height_ratios=(1.1, 1))
    above, below = parts
    above.suptitle("What the others take, in multiples of BNIRL: here (blue) and in the thesis (grey)", fontsize=11.5)
    for k, (axis, column) in enumerate(zip(above.subplots(1, 4), TITLES, strict=True)):
        draw_ratios(axis, headline["rows"], column, named=k == 0)
    below.suptitle("Worlds that have to be solved, and actions left wrong", fontsize=11.5)
    panels: dict[str, dict[str, Told]] = {
        "example of figure 4-2": {row["method"]: (row["plans"], None) for row in headline["rows"] if row["thesis"]}
    }
    for name in SHOWN:
        case = headline["closing_cases"][name]
        title = f"{name} ({case['pairs']:,.0f} pairs)"
        panels[title] = {method: (row["plans"], row["wrong"]) for method, row in case["methods"].items()}
    for k, (axis, title) in enumerate(zip(below.subplots(1, 3), panels, strict=True)):
        draw_plans(axis, panels[title], title, named=k == 0)
    return figure


def draw_ratios(axis: Axes, rows: list[Headline], column: str, *, named: bool) -> None:
    """Two bars a method, on a logarithmic axis from one."""
    rows = [row for row in rows if row["method"] != "BNIRL"]
    places = np.arange(len(rows))
    for offset, key, colour in ((-0.19, "over_bnirl", PALETTE[0]), (0.19, "thesis_over_bnirl", GREY)):
        for place, row in zip(places, rows, strict=True):
            if row[key] is None:
                continue
            ratio = row[key][column]
            axis.barh(place + offset, ratio - 1, 0.36, left=1, color=colour)
            axis.annotate(_times(ratio), (ratio, place + offset), xytext=(4 if ratio >= 1 else -4, 0), va="center",
                          textcoords="offset points", ha="left" if ratio >= 1 else "right", fontsize=8.5)  # fmt: skip
    axis.axvline(1, color=INK, lw=1)
    axis.set_xscale("log")
    low, high = axis.get_xlim()
    axis.set_xlim(low / (12 if low < 0.5 else 4), high * 6)
    axis.set_title(TITLES[column])
    axis.set_yticks(places, [row["method"].replace(", ", ",\n") for row in rows])
    axis.tick_params(labelleft=named, labelsize=8.5)
    axis.set_ylim(len(rows) - 0.5, -0.5)
    axis.grid(visible=False)


def _times(ratio: float) -> str:
    return f"×{ratio:,.0f}" if ratio >= 10 else f"×{ratio:.2g}"


def draw_plans(axis: Axes, rows: dict[str, Told], title: str, *, named: bool) -> None:
    """A bar a method, with the share of pairs wrong where that is told."""
    names = list(rows)
    plans = [rows[name][0] for name in names]
    bars = axis.barh(names, plans, 0.6, color=[PALETTE[0], *[PALETTE[4]] * (len(names) - 1)])
    told = [f"{n:.0f}" + ("" if share is None else f", {share:.0%} wrong") for n, share in rows.values()]
    axis.bar_label(bars, told, padding=4, fontsize=8.5)
    axis.set(xlim=(0, max(plans) * 1.45), xlabel="worlds solved")
    axis.set_title(title)
    axis.tick_params(labelleft=named)
    axis.invert_yaxis()
    axis.grid(visible=False)
