"""The labyrinth with what was found in it, and how well the held-out turns were predicted."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, sheet
from experiments.labyrinth_world import HOME, Maze
from subgoal.posterior.posterior import Posterior

WATER, AT_HOME, OTHER = PALETTE[0], PALETTE[1], GREY
NAMED_FROM = 0.03


def picture(maze: Maze, posterior: Posterior, headline: Headline) -> Figure:
    """Maze on the left, bits on the right."""
    figure = sheet(12.5, 6.4)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    _draw_maze(left, maze, headline)
    _draw_bits(right, headline)
    figure.suptitle("Where a thirsty mouse is heading, learned from its turns alone", x=0.01, ha="left")
    return figure


def _draw_maze(axis: Axes, maze: Maze, headline: Headline) -> None:
    for node in range(HOME):
        parent = (node - 1) // 2 if node else HOME
        axis.plot(*maze.places[[node, parent]].T, color="#dcdcdc", lw=7, solid_capstyle="round", zorder=1)
    marks = {maze.water: ("water port", WATER, 27), HOME: ("home", AT_HOME, -24)}
    told = {name: f"{name}: not found" for name, _, _ in marks.values()}
    for rank, item in enumerate(headline["subgoals"], start=1):
        node, share = item["node"], item["share"]
        name, shade, _ = marks.get(node, ("", OTHER, 0))
        x, y = maze.places[node]
        axis.scatter(x, y, s=4500 * share, color=shade, alpha=0.85, lw=0, zorder=3)
        if name:
            told[name] = f"{name}: {share:.0%}, rank {rank}"
        elif share >= NAMED_FROM:
            axis.annotate(f"{share:.0%}", maze.places[node], ha="center", va="center", fontsize=8, zorder=4)
    for node, (name, shade, up) in marks.items():
        axis.plot(*maze.places[node], "+", color="white", ms=9, mew=2, zorder=5)
        axis.annotate(told[name], maze.places[node], xytext=(0, up), textcoords="offset points", ha="center",
                      va="center", color=shade, weight="bold", fontsize=10.5, zorder=6,
                      bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 1})  # fmt: skip
    axis.set(xlim=(-2.2, 16.4), ylim=(-0.8, 14.8), aspect="equal")
    axis.set_axis_off()
    training = headline["training"]
    axis.set_title(
        f"Session {headline['session']}: what {training['decisions']} turns of {training['bouts']} bouts were after"
        " (area: share of the walk)"
    )


def _draw_bits(axis: Axes, headline: Headline) -> None:
    values, errors = headline["bits_per_decision"], headline["standard_error"]
    names = [name for name in values if name != "chance"]
    gains = [values[name] - values["chance"] for name in names]
    bars = axis.barh(
        names, gains, color=[WATER if name.startswith("BNIRL") else GREY for name in names], height=0.6,
        xerr=[errors[name] for name in names], error_kw={"ecolor": INK, "lw": 1, "capsize": 3},
    )  # fmt: skip
    for bar, name, gain in zip(bars, names, gains, strict=True):
        right = gain + errors[name] if gain > 0 else 0.0
        axis.annotate(f"{values[name]:.3f}", (right, bar.get_y() + bar.get_height() / 2), xytext=(6, 0),
                      textcoords="offset points", va="center", fontsize=9)  # fmt: skip
    axis.axvline(0, color=INK, lw=1)
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    axis.margins(x=0.15)
    axis.set_xlabel(f"bits gained on chance ({values['chance']:.3f}) per turn; the line is one standard error")
    held_out = headline["held_out"]
    axis.set_title(
        f"How well {held_out['decisions']} turns of {held_out['bouts']} later bouts are foretold (bits per turn)"
    )
