"""Kitchens with the tiles that were found and those that were truly used."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from experiments.common import GREY, INK, PALETTE, Headline, sheet
from subgoal.mdp.grids.maps import TextMap

FOUND, TRUE, WALKED = PALETTE[0], PALETTE[1], PALETTE[4]
KINDS = {"O": "onions", "D": "dishes", "P": "pot", "S": "serving", "X": "counter"}
LISTED_FROM, LEAST_SHARE = 0.01, 0.05


def picture(kitchens: dict[str, tuple[TextMap, Any]], headline: Headline) -> Figure:
    """A map and a comparison of shares for each layout: the scored one above, the other below."""
    figure = sheet(12.5, 8.6)
    axes = figure.subplots(len(kitchens), 2, width_ratios=(1.25, 1))
    for (layout, (drawn, sides)), (left, right) in zip(kitchens.items(), axes, strict=True):
        _draw_map(left, drawn, sides)
        _draw_shares(right, sides)
        games = sides[0].seen.demonstrations.n_trajectories
        left.set_title(f"{layout}: {games} games of two cooks, a room each")
    told = (
        "tiles: precision {precision:.2f}, recall {recall:.2f}\n"
        "steps: adjusted Rand {assignment_ari:.2f} ({assignment_ari_identified:.2f} where it can be told)"
    )
    figure.suptitle("Which tiles the cooks are after, learned from their steps alone", x=0.01, ha="left")
    axes[0][1].set_title(told.format(**headline), fontsize=9.5)
    axes[1][1].set_title(told.format(**headline["illustration"]), fontsize=9.5)
    return figure


def _draw_map(axis: Axes, drawn: TextMap, sides: Any) -> None:
    height, width = drawn.free.shape
    kinds = {(int(x), int(y)): kind for kind, cells in drawn.tiles.items() for x, y in cells}
    for y, x in np.ndindex(height, width):
        free = bool(drawn.free[y, x])
        axis.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, fc="white" if free else "#ececec", ec="#cfcfcf", lw=0.8))
        if not free:
            axis.annotate(KINDS[kinds[x, y]] if (x, y) in kinds else "", (x, y - 0.31), ha="center",
                          va="center", fontsize=7.5, color=INK, zorder=5)  # fmt: skip
    for side in sides:
        _draw_visits(axis, side)
        for g, (x, y) in enumerate(side.room.candidates.points):
            shift = _shift(side, sides, g)
            if side.seen.use_shares[g] >= LEAST_SHARE:
                axis.add_patch(Rectangle((x - 0.47, y - 0.47), 0.94, 0.94, fill=False, ec=TRUE, lw=2.2, zorder=4))
            if side.shares[g] >= LISTED_FROM:
                axis.scatter(x + shift, y + 0.02, s=1300 * side.shares[g], color=FOUND, alpha=0.85, lw=0, zorder=3)
            if side.shares[g] >= LEAST_SHARE:
                axis.annotate(f"{side.shares[g]:.0%}", (x + shift, y + 0.34), ha="center", va="center", fontsize=7.5,
                              color=FOUND, weight="bold", zorder=6)  # fmt: skip
    axis.set(xlim=(-0.6, width - 0.4), ylim=(height - 0.4, -0.6), aspect="equal")
    axis.set_axis_off()
    dot = Line2D([], [], marker="o", ls="", color=FOUND, ms=9, label="found: its share of the steps")
    frame = Patch(fill=False, ec=TRUE, lw=2.2, label=f"truly used: {LEAST_SHARE:.0%} of the uses")
    floor = Patch(color=WALKED, alpha=0.6, label="floor: where cooks acted")
    axis.legend(handles=[dot, frame, floor], loc="upper center", bbox_to_anchor=(0.5, 0.0), ncols=3, fontsize=8.5)


def _shift(side: Any, sides: Any, g: int) -> float:
    """Tiles that both cooks can reach show each cook's share on the cook's side."""
    place = side.room.candidates.points[g]
    others = [
        other for other in sides if other is not side and (other.room.candidates.points == place).all(axis=1).any()
    ]
    if not others:
        return 0.0
    own = np.mean([x for x, _ in side.room.cells])
    return 0.245 if own > place[0] else -0.245


def _draw_visits(axis: Axes, side: Any) -> None:
    places, visits = np.unique(side.seen.demonstrations.places, axis=0, return_counts=True)
    for (x, y), count in zip(places, visits, strict=True):
        axis.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, color=WALKED, alpha=0.75 * count / visits.max(), lw=0))


def _draw_shares(axis: Axes, sides: Any) -> None:
    """Found and true share of every tile that has 1 % of either."""
    rows = []
    for side, name in zip(sides, _names(sides), strict=True):
        listed = np.flatnonzero(np.maximum(side.shares, side.seen.use_shares) >= LISTED_FROM)
        order = listed[np.argsort(-side.seen.use_shares[listed])]
        rows += [(f"{name}: {_told(side.room.candidates.names[g])}", side.shares[g], side.seen.use_shares[g])
                 for g in order]  # fmt: skip
    place = np.arange(len(rows))
    axis.barh(place - 0.19, [found for _, found, _ in rows], 0.36, color=FOUND, label="found: share of the steps")
    axis.barh(place + 0.19, [true for *_, true in rows], 0.36, color=TRUE, label="true: share of the uses")
    axis.axvline(LEAST_SHARE, color=GREY, lw=1, ls="--")
    axis.set_yticks(place, [name for name, *_ in rows], fontsize=8)
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:.0%}")
    axis.legend(loc="lower right", fontsize=8.5)


def _names(sides: Any) -> list[str]:
    """Which room is the left one."""
    middle = [np.mean([x for x, _ in side.room.cells]) for side in sides]
    return ["left" if own == min(middle) else "right" for own in middle]


def _told(tile: str) -> str:
    kind, x, y = tile.split(":")
    return f"{KINDS[kind]} ({x}, {y})"
