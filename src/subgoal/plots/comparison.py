"""Methods side by side: how well each foretold trajectories that it had not seen."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.irl.compare import Comparison
from subgoal.irl.rivals import FLOORS
from subgoal.plots.style import FAINT, INK, OTHER_COLOUR, PALETTE, SMALL, new_figure, panel
from subgoal.plots.words import percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure

NORMAL = 1.96
"""Standard errors to both sides of a 95 % interval."""
SHOWN_GAP = 6.0
"""Methods further behind the best than so many bits are drawn at the edge."""


def comparison_words(found: Comparison) -> str:
    """Which method foretells best, and whether that is more than chance."""
    best = found.best
    name = best.name[0].upper() + best.name[1:]
    if len(found.methods) < 2:
        return f"{name} foretells unseen trajectories at {best.bits_per_decision:.2f} bits per decision"
    second = found.methods[1]
    gap = found.behind(second)
    low, high = gap.interval
    if low > 0:
        return (
            f"{name} foretells unseen trajectories best, {gap.bits_per_decision:.2f} bits per decision "
            f"({low:.2f} to {high:.2f}) before {second.name}"
        )
    return f"{name} and {second.name} foretell unseen trajectories best, too close to tell apart"


def one_reward_words(found: Comparison) -> str:
    """Whether one reward is enough: the best account with several subgoals against the best with one reward."""
    pair = found.one_reward()
    if pair is None:
        return "Whether one reward is enough was not asked: it takes one method with subgoals and one with one reward"
    several, single, gap = pair
    low, high = gap.interval
    told = f"{abs(gap.bits_per_decision):.2f} bits per decision, 95 % from {min(abs(low), abs(high)):.2f} to"
    told = f"{told} {max(abs(low), abs(high)):.2f}"
    if low > 0:
        return f"One reward is not enough: {several.name} foretells better than {single.name} ({told})"
    if high < 0:
        return f"One reward is enough: {single.name} foretells better than {several.name} ({told})"
    return f"One reward may be enough: {several.name} and {single.name} are too close to tell apart"


def plot_comparison(found: Comparison) -> Figure:
    """Bits per decision of each method with its 95 % interval over trajectories; floors grey, 0-1 losses beside."""
    rows = found.methods
    folds = f"{found.folds.size} trajectories in {int(found.folds.max()) + 1} folds"
    notes = ["0 bits is certainty", folds, "grey: floors", "whiskers: 95 % of each alone; the lead is a paired one"]
    height = 1.9 + 0.36 * len(rows)
    figure = new_figure(9.2, height, comparison_words(found) + ".", None, notes, left=0.29)
    axes = panel(figure, (0.29, 0.85 / height, 0.5, 1 - 1.75 / height), "", "bits per decision (higher is better)", "")
    edge = found.best.bits_per_decision - SHOWN_GAP
    for k, each in enumerate(rows):
        bits = max(each.bits_per_decision, edge)
        tint = PALETTE[0] if k == 0 else OTHER_COLOUR if each.key in FLOORS else INK
        reach = 0.0 if np.isnan(each.standard_error) or bits == edge else NORMAL * each.standard_error
        axes.errorbar(bits, k, xerr=reach, fmt="o" if bits > edge else "<", color=tint, ms=6.5, capsize=3, lw=1.4)
        wrong = f"{percent(each.loss)} wrong" + (f", {each.size:.0f} {each.unit}" if each.unit else "")
        axes.annotate(wrong, (1.02, k), xycoords=("axes fraction", "data"), va="center", fontsize=SMALL, color=FAINT)
    axes.set_yticks(range(len(rows)), [each.name for each in rows])
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.xaxis.grid(True, color="#E5E7EB")
    return figure
