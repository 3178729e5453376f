"""Drawings of grid worlds in the thesis's form: walls, arrows of actions, coloured assignments, loss against sweep."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.common import GREY, INK, PALETTE, Headline, sheet
from experiments.grid_study import Run, Setting, true_cells
from subgoal.answers.scores import top_candidates
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.grid import GridWorld
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints

WALL = "#444444"
LEAST_SHARE = 0.02


def study_picture(
    example: Run, setting: Setting, losses: dict[str, Floats], headline: Headline, *, seen: str, number: str
) -> Figure:
    """What was seen in one run, loss against sweep over all runs, what was found, and how often all of it was."""
    figure = sheet(10.5, 8.8)
    top_left, top_right, bottom_left, bottom_right = figure.subplots(2, 2).ravel()
    draw_map(top_left, example.grid)
    draw_pairs(top_left, example.grid, example.shown.demonstrations)
    top_left.set_title(f"What was seen: {seen}")
    draw_losses(top_right, losses, headline["sweeps_to_minimum_loss"])
    top_right.set_title("Actions that the sampled subgoals do not explain")
    draw_map(bottom_left, example.grid)
    draw_subgoals(bottom_left, example.grid, example.posterior, np.array(true_cells(example, setting.subgoals)))
    bottom_left.set_title("What was found: subgoals with their share (stars: the truth)")
    draw_counts(bottom_right, headline)
    bottom_right.set_title(f"In how many runs all {number} were found")
    return figure


def draw_map(axis: Axes, grid: GridWorld) -> None:
    """Walls and the frame; cells counted from one."""
    height, width = grid.free.shape
    for y, x in np.argwhere(~grid.free):
        axis.add_patch(Rectangle((x + 0.5, y + 0.5), 1, 1, color=WALL, lw=0))
    axis.set(xlim=(0.5, width + 0.5), ylim=(0.5, height + 0.5), aspect="equal")
    axis.set_xticks([1, 5, 10, 15, 20])
    axis.set_yticks([1, 5, 10, 15, 20])
    axis.grid(visible=False)
    for side in ("top", "right"):
        axis.spines[side].set_visible(True)


def draw_pairs(axis: Axes, grid: GridWorld, demos: Demonstrations, colours: Any = None) -> None:
    """An arrow along each action, a cross where it stays; pairs seen several times are drawn once per colour."""
    shades = np.full(demos.n_observations, INK) if colours is None else np.asarray(colours)
    for shade in dict.fromkeys(shades.tolist()):
        rows = np.flatnonzero(shades == shade)
        pairs = np.unique(np.column_stack([demos.states[rows], demos.actions[rows]]), axis=0)
        step = grid.directions[pairs[:, 1]].astype(float)
        step /= np.maximum(np.linalg.norm(step, axis=1, keepdims=True), 1)
        here = grid.cells[pairs[:, 0]] + 1.0
        goes = (step != 0).any(axis=1)
        axis.quiver(*(here[goes] - 0.35 * step[goes]).T, *(0.7 * step[goes]).T, color=shade, angles="xy",
                    scale_units="xy", scale=1, width=0.006, headwidth=4.5, headlength=5, zorder=3)  # fmt: skip
        axis.plot(*here[~goes].T, "x", color=shade, ms=6, mew=1.8, zorder=4)


def draw_subgoals(axis: Axes, grid: GridWorld, posterior: Posterior, true: Ints) -> None:
    """Boxes at the largest candidates in colours, the pairs in the colour of their most probable one, true cells."""
    top = [g for g in top_candidates(posterior, len(PALETTE)) if posterior.expected_shares[g] >= LEAST_SHARE]
    sets: Any = posterior.candidates.goal_sets
    likely = np.asarray(posterior.shares.argmax(axis=1)).ravel()
    colours = np.full(likely.size, GREY)
    for k, g in enumerate(top):
        colours[likely == g] = PALETTE[k]
    draw_pairs(axis, grid, posterior.demonstrations, colours)
    for k, g in enumerate(top):
        for member in sets[g]:
            x, y = grid.cells[member] + 1
            axis.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, ec=PALETTE[k], lw=2.2, zorder=5))
        axis.annotate(
            f"{posterior.expected_shares[g]:.0%}", (x, y), xytext=(9, 7), textcoords="offset points", fontsize=8.5,
            color=PALETTE[k], weight="bold", zorder=6,
            bbox={"facecolor": "white", "alpha": 0.8, "lw": 0, "pad": 0.6},
        )  # fmt: skip
    axis.plot(*(grid.cells[true] + 1).T, "*", color=INK, ms=7, zorder=6, ls="")


def draw_counts(axis: Axes, headline: Headline) -> None:
    """In how many runs exactly the true subgoals were on top, by what was changed."""
    rows = {"as drawn": headline, **headline["layouts"]}
    rows |= {f"candidates: {name}": row for name, row in headline["candidates"].items()}
    rows |= {f"stay pair: {name}": row for name, row in headline["stay_pairs"].items()}
    rows |= headline["samplers"]
    names, counts = list(rows), [row["runs_all_true_subgoals"] for row in rows.values()]
    bars = axis.barh(names, counts, color=[PALETTE[0], *[PALETTE[4]] * (len(rows) - 1)], height=0.6)
    axis.bar_label(bars, [f"{count} of {headline['runs']}" for count in counts], padding=4, fontsize=9)
    axis.set(xlim=(0, headline["runs"] * 1.2), xlabel="runs with exactly the true subgoals on top")
    axis.invert_yaxis()
    axis.grid(visible=False)


def draw_losses(axis: Axes, losses: dict[str, Floats], minimum: int, floor: float | None = None) -> None:
    """Mean 0-1 policy loss over the runs (R, T) against sweep, the middle half of the runs shaded.

    ``minimum`` is the sweep at which it is reached; ``floor`` the loss of the demonstrator's own policy, whose ties are
    broken at random.
    """
    axis.set_ylim(0, 1.25 * max(values.mean(axis=0).max() for values in losses.values()))
    for k, (name, values) in enumerate(losses.items()):
        sweeps = np.arange(1, values.shape[1] + 1)
        low, high = np.quantile(values, [0.25, 0.75], axis=0)
        axis.fill_between(sweeps, low, high, color=PALETTE[k], alpha=0.12, lw=0)
        axis.plot(sweeps, values.mean(axis=0), color=PALETTE[k], label=f"{name} (mean of {len(values)} runs)")
    if floor is not None:
        axis.axhline(floor, color=INK, lw=0.9, ls=":", label="true reward, ties at random")
    if minimum > 1:
        axis.axvline(minimum, color=INK, lw=0.9, ls="--")
        axis.annotate(f"minimum reached at sweep {minimum}", (minimum, 0.6), xycoords=("data", "axes fraction"),
                      xytext=(5, 0), textcoords="offset points", fontsize=8.5)  # fmt: skip
    axis.set(xlabel="sweep", ylabel="0-1 policy loss (pairs)")
    axis.legend(loc="upper right", fontsize=8.5)
