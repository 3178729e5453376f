"""How many subgoals: over the sweeps of each chain, and as a posterior distribution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from subgoal.answers.subgoals import COUNTED_FROM, Subgoals
from subgoal.plots.style import FAINT, INK, PALETTE, SMALL, limits, new_figure, panel, whole_ticks
from subgoal.plots.words import percent, sure
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats, Ints

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_POINTS = 1_500
"""A chain is drawn with about so many points."""
CHAIN_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#332288", "#7A4B2A")


def thinned_sweeps(sweeps: int) -> Ints:
    """Which sweeps of a trace are drawn: all if few, else about 1,500 evenly spaced ones and the last."""
    return np.unique(np.linspace(0, sweeps - 1, min(sweeps, MOST_POINTS)).astype(np.int64))


def plot_subgoal_count(posterior: Posterior) -> Figure:
    """Distinct candidates in use (above) and log p(θ, O) (below) at every sweep of each chain, warm-up shaded."""
    counts, joint = posterior.traces["n_active"], posterior.traces["log_joint"]
    title = f"{posterior.n_chains} chains should look alike and show no trend after the warm-up"
    if posterior.n_chains == 1:
        title = "One chain: it should show no trend after the warm-up, but cannot show convergence"
    figure = new_figure(9.6, 6.0, title, posterior, left=0.1)
    for traces, place, across, up in (
        (counts, (0.1, 0.53, 0.75, 0.32), "", "candidates in use"),
        (joint, (0.1, 0.11, 0.75, 0.36), "sweep", "log p(θ, O)  [nats]"),
    ):
        _traces(figure, traces, place, across, up, posterior.settings.warmup)
    whole_ticks(figure.axes[0], "y")
    figure.axes[0].legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize=SMALL)
    return figure


def _traces(
    figure: Figure, traces: Floats, place: tuple[float, float, float, float], across: str, up: str, warmup: int
) -> None:
    axes = panel(figure, place, "", across, up)
    sweeps = traces.shape[1]
    rows = thinned_sweeps(sweeps)
    for chain, values in enumerate(traces):
        axes.plot(rows, values[rows], color=CHAIN_COLOURS[chain % len(CHAIN_COLOURS)], linewidth=0.6, alpha=0.8,
                  label=f"chain {chain}")  # fmt: skip
    if warmup:
        axes.axvspan(0, min(warmup, sweeps), color="#E5E7EB", zorder=0, label="warm-up", linewidth=0)
    axes.set_xlim(0, max(sweeps - 1, 1))
    late = traces[:, min(max(warmup, sweeps // 10) // 2, sweeps - 1) :]
    low, high = limits(late, 0.15)
    axes.set_ylim(low, high)


def plot_count_posterior(found: Subgoals, posterior: Posterior | None = None) -> Figure:
    """P(number of subgoals with at least 5 % of the observations | O); with ``posterior``, its status too."""
    law = found.n_subgoals_distribution
    figure = new_figure(7.0, 4.4, sure(found, posterior), posterior, left=0.12)
    axes = panel(
        figure, (0.12, 0.15, 0.84, 0.62), "", f"number of subgoals with at least {percent(COUNTED_FROM)} of the"
        " observations", "posterior probability",
    )  # fmt: skip
    numbers, chances = list(law), list(law.values())
    shades = [PALETTE[0] if k == found.n_subgoals else "#A9C6DD" for k in numbers]
    axes.bar(numbers, chances, width=0.7, color=shades)
    for k, chance in law.items():
        axes.text(k, chance + 0.015, percent(chance), ha="center", fontsize=SMALL, color=INK)
    axes.set_ylim(0, 1.1 * max(chances) + 0.02)
    axes.set_xlim(min(numbers) - 1.5, max(numbers) + 1.5)
    axes.yaxis.grid(True, color="#E5E7EB")
    axes.tick_params(axis="y", colors=FAINT)
    whole_ticks(axes, "x")
    return figure
