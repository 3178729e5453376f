"""How many subgoals there are at each confidence (thesis Figure 7-8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.irl.sweep_record import Sweep
from subgoal.plots.style import ALARM, FAINT, PALETTE, SMALL, new_figure, panel, whole_ticks
from subgoal.plots.words import counted, percent

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def settled_number(found: Sweep) -> int | None:
    """The number above one that lasts over the widest range of levels; None if none lasts for two of them."""
    numbers = sorted({int(k) for k in np.rint(found.mean) if k > 1})
    widest = max(numbers, key=lambda k: found.plateau(k).ratio, default=None)
    return widest if widest is not None and found.plateau(widest).ratio > 1 else None


def sweep_words(found: Sweep) -> str:
    """One up to where, and which number lasts over which range."""
    one, number = found.last_with_one, settled_number(found)
    told = "More than one subgoal at every confidence" if np.isnan(one) else f"One subgoal up to confidence {one:.3g}"
    if number is None:
        return f"{told}; no other number lasts"
    place = found.plateau(number)
    wide = f"from {place.low:.3g} to {place.high:.3g}, a factor of {place.ratio:.3g}"
    return f"{told}; {counted(number, 'subgoal')} {wide}"


def plot_sweep(found: Sweep, second: float | None = None) -> Figure:
    """Mean number of subgoals ± two standard deviations over trials against α; ``second`` is that of the score test."""
    trials = found.counts.shape[1]
    least = percent(found.settings.get("least_share", 0.0))
    notes = [f"{trials} trials at each level, bars ± 2 standard deviations", f"subgoals with at least {least}"]
    figure = new_figure(8.4, 4.6, sweep_words(found) + ".", None, notes, left=0.1)
    axes = panel(figure, (0.1, 0.2, 0.86, 0.58), "", "confidence α", "number of subgoals")
    number = settled_number(found)
    if number is not None:
        place = found.plateau(number)
        axes.axvspan(place.low, place.high, color="#E5F0F7", lw=0, zorder=0)
        axes.axhline(number, color="#A9C6DD", lw=1)
    axes.errorbar(found.confidences, found.mean, yerr=2 * found.sd, color=PALETTE[0], fmt="o-", capsize=3, lw=1.4, ms=5)
    if second is not None and np.isfinite(second) and second > 0:
        axes.axvline(second, color=ALARM, lw=1.2, ls="--")
        axes.annotate("a second subgoal is likelier", (second, 1.0), xycoords=("data", "axes fraction"), ha="left",
                      xytext=(4, -2), textcoords="offset points", va="top", fontsize=SMALL, color=ALARM)  # fmt: skip
    axes.set_xscale("log")
    axes.set_ylim(0, float((found.mean + 2 * found.sd).max()) * 1.1 + 0.5)
    axes.yaxis.grid(True, color="#E5E7EB")
    axes.tick_params(axis="both", colors=FAINT)
    whole_ticks(axes, "y")
    return figure
