"""Figures 3-1 and 3-3: Room World with its rewards and a demonstration, and how relevant each state is.

Relevance (3.10) of 100 demonstrations with a narrow and a wide squared exponential covariance function, σ = 0.1 and 1
cell, each visited state counting once; both layouts, since the walls of the thesis are known only in words.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from experiments.common import INK, Headline, Options, run, sheet
from experiments.room_pictures import (
    NEGATIVE,
    NONE,
    PATH,
    POSITIVE,
    RELEVANCE,
    WALL,
    draw_paths,
    draw_relevance,
    draw_world,
)
from experiments.room_worlds import demonstrate
from subgoal.demonstrations.records import Demonstrations
from subgoal.irl.relevance import relevance, squared_exponential
from subgoal.mdp.grids.rooms import DRAWINGS, RoomWorld, room_world
from subgoal.runtime.checks import Floats

WIDTHS = {"narrow": 0.1, "wide": 1.0}
SHOWN, QUICK_SHOWN = 100, 10
NOTABLE = 0.01
"""States from this relevance on are proposed now and then."""


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Both layouts: the world, and relevance with either width."""
    headline: Headline = {}
    figure = sheet(10.4, 7.6)
    figure.suptitle("Room World (left), and the states that 100 demonstrations say something about")
    panels: Any = figure.subplots(2, 3)
    for row, layout in zip(panels, DRAWINGS, strict=True):
        world = room_world(layout)
        demos = demonstrate(world, options.seed)
        draw_world(row[0], world)
        draw_paths(row[0], world, demos, 1, 1.8)
        row[0].set_title(f"Layout {layout}: one demonstration")
        found = {name: relevance(demos, world.grid.mdp, squared_exponential(width)) for name, width in WIDTHS.items()}
        for axis, (name, width) in zip(row[1:], WIDTHS.items(), strict=True):
            draw_relevance(axis, world, found[name])
            draw_paths(axis, world, demos, QUICK_SHOWN if options.quick else SHOWN, 0.35)
            axis.set_title(f"Relevance, {name} (σ = {width:g})")
        headline[f"layout_{layout}"] = told(world, demos, found)
    _legends(figure, panels)
    headline["claims"] = claims(headline)
    return headline, figure


def told(world: RoomWorld, demos: Demonstrations, found: dict[str, Floats]) -> Headline:
    """How many states were visited, how many are relevant, and how much those of the far room are."""
    visited = np.unique(np.asarray(demos.states))
    far = world.rooms["upper right"]
    return {
        "states": world.grid.n_states,
        "visited": visited.size,
        "relevant": {name: int((values >= NOTABLE).sum()) for name, values in found.items()},
        "visits_of_upper_right": int(np.isin(np.asarray(demos.states), far).sum()),
        "largest_relevance_of_upper_right": {name: values[far].max() for name, values in found.items()},
        "narrow_is_visited_only": bool((np.flatnonzero(found["narrow"] >= NOTABLE) == visited).all()),
        "least_relevance_of_visited": {name: values[visited].min() for name, values in found.items()},
    }


def claims(headline: Headline) -> list[Headline]:
    """Of the text of 3.3.1 and 3.4."""
    rows = [headline[f"layout_{layout}"] for layout in DRAWINGS]
    narrow = all(row["narrow_is_visited_only"] for row in rows)
    wide = all(row["relevant"]["wide"] > row["relevant"]["narrow"] for row in rows)
    far = all(row["visits_of_upper_right"] == 0 for row in rows)
    counts = "; ".join(f"{row['visited']} visited of {row['states']}, {row['relevant']} relevant" for row in rows)
    return [
        _claim("a wide covariance function is high over more states than a narrow one", narrow and wide, counts,
               "high value over a wider set of states around the demonstrations"),
        _claim("nothing is seen of the upper right room", far, f"{[row['visits_of_upper_right'] for row in rows]}",
               "no observed state-action pairs near that area (3.2.2)"),
    ]  # fmt: skip


def _claim(name: str, holds: bool, measured: str, thesis: str) -> Headline:
    return {"name": name, "verdict": "holds" if holds else "does not hold", "measured": measured, "thesis": thesis}


def _legends(figure: Figure, panels: Any) -> None:
    kinds = {"wall": WALL, "reward +0.01": POSITIVE, "reward −0.01": NEGATIVE, "no reward": NONE}
    handles: list[Any] = [Patch(facecolor=tint, edgecolor="#bbbbbb", label=name) for name, tint in kinds.items()]
    handles.append(Line2D([], [], color=PATH, label="demonstration"))
    handles.append(Line2D([], [], color=INK, marker="o", ls="", mfc="white", mew=1.4, label="start"))
    figure.legend(handles=handles, loc="outside lower left", ncols=6)
    figure.colorbar(ScalarMappable(cmap=RELEVANCE), ax=panels[:, 2], label="relevance ρ(s)", shrink=0.6)


if __name__ == "__main__":
    run("fig_3_3", experiment)
