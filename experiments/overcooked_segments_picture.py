"""F-scores of the ways to cut a cook's games, and a stretch of one game with what each found."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, sheet
from subgoal.runtime.checks import Floats

LEARNED, OTHER, TRIVIAL = PALETTE[0], PALETTE[1], GREY
STEPS_SHOWN = 90
TOLD = ("ruptures", "hidden Markov")


class Strip(NamedTuple):
    """One game: the model shown, times of the rows, P(boundary after the row), true and found change points."""

    model: str
    times: Floats
    probability: Floats
    true: Floats
    found: dict[str, Floats]


def picture(conditions: dict[str, Headline], strips: dict[str, Strip]) -> Figure:
    """A column per condition: scores above, the stretch of a game below."""
    figure = sheet(13.0, 7.2)
    axes = figure.subplots(2, len(conditions), height_ratios=(1.25, 1), squeeze=False)
    everything = list(dict.fromkeys(name for row in conditions.values() for name in row["methods"]))
    for column, (keys, row) in enumerate(conditions.items()):
        _scores(axes[0][column], row, everything)
        _strip(axes[1][column], strips[keys])
        axes[0][column].set_title(_told(keys, row), fontsize=11)
        axes[1][column].set_title(f"A stretch of the first of {row['games']} test games, the right cook")
        if column:
            axes[0][column].set_yticklabels([])
            axes[1][column].set_yticklabels([])
    figure.suptitle("When does a cook turn to another tile? Learned change points against the true times of use",
                    x=0.01, ha="left")  # fmt: skip
    return figure


def _told(keys: str, row: Headline) -> str:
    """What was found in a few words: the model that was best in the training games, and the best trivial rule."""
    score = {name: each["f_score"] for name, each in row["methods"].items()}
    rule = max((name for name in score if colour(name) == TRIVIAL), key=lambda name: score[name])
    return f"{keys.capitalize()}: subgoals {score[row['best_model_in_training']]:.2f}, {rule} {score[rule]:.2f}"


def colour(name: str) -> str:
    """Blue for subgoals, orange for the other learners, grey for trivial rules."""
    if name.startswith("subgoals"):
        return LEARNED
    return OTHER if name.startswith(TOLD) else TRIVIAL


def _scores(axis: Axes, row: Headline, everything: list[str]) -> None:
    for k, name in enumerate(everything):
        if name not in row["methods"]:
            axis.annotate("hidden here", (0.01, k), va="center", fontsize=8.5, color=GREY)
            continue
        each = row["methods"][name]
        value, low, high = each["f_score"], each["low"], each["high"]
        axis.barh(k, value, 0.62, color=colour(name), alpha=0.85, lw=0)
        axis.plot([low, high], [k, k], color=INK, lw=1.6, solid_capstyle="butt")
        axis.annotate(f"{value:.2f}", (max(high, value), k), xytext=(5, 0), textcoords="offset points", va="center")
    axis.set_yticks(range(len(everything)), everything)
    axis.set(
        xlim=(0, 1.08),
        ylim=(len(everything) - 0.4, -0.6),
        xlabel="F-score within ± 3 game steps (line: 95 % interval over games)",
    )
    axis.grid(visible=False, axis="y")


def _strip(axis: Axes, strip: Strip) -> None:
    """Rows of ticks, and the learned probability as stems."""
    begin = float(strip.times[strip.times.size // 2])
    end = begin + STEPS_SHOWN
    inside = (strip.times[:-1] >= begin) & (strip.times[:-1] <= end)
    axis.vlines(strip.times[:-1][inside], 1, 1 + 1.6 * strip.probability[:-1][inside], color=LEARNED, lw=2.2)
    axis.axhline(1, color=LEARNED, lw=0.8)
    rows = [("truly used", strip.true, INK)]
    others = [name for name in strip.found if name.startswith(TOLD)]
    rows += [("", np.empty(0), LEARNED)] + [(name, strip.found[name], OTHER) for name in others]
    heights = [3.2, 1.0, *(-0.3 - 1.1 * k for k in range(len(others)))]
    for (_, points, ink), height in zip(rows, heights, strict=True):
        shown = points[(points >= begin) & (points <= end)]
        axis.vlines(shown, height, height + 0.8, color=ink, lw=2.2)
    for point in strip.true[(strip.true >= begin) & (strip.true <= end)]:
        axis.axvline(point, color=GREY, lw=0.6, ls=":", zorder=0)
    axis.set_yticks(
        [heights[0] + 0.4, 1.8, *(height + 0.4 for height in heights[2:])],
        ["truly used", "learned: chance of a boundary", *(name.split(" (")[0] for name in others)],
    )
    axis.set(xlim=(begin - 1, end + 1), ylim=(min(heights) - 0.2, 4.2), xlabel="game step (0.15 s)")
    axis.grid(visible=False)
