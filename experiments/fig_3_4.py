"""Figure 3-4: 0-1 policy loss by iteration of four variants of Bayesian IRL in Room World (thesis 3.4).

PolicyWalk; with the cooling 1/T = 25 + i/50; with cooling and a narrow or a wide relevance. Ten seeds in each of twelve
worlds: two layouts, mirrored or not, with three choices of doors. A table has other readings of what the thesis leaves
open, and every claim of the chapter a verdict.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import GREY, INK, PALETTE, Headline, Options, run, sheet
from experiments.room_claims import claims
from experiments.room_mean import of_mean
from experiments.room_study import (
    MAIN,
    READINGS,
    VARIANTS,
    Trace,
    end_of,
    settled,
    speed_ups,
    study,
)
from experiments.room_worlds import all_worlds
from subgoal.runtime.checks import Floats

SEEDS, ITERATIONS = 10, 8_000
OTHER_SEEDS, OTHER_ITERATIONS = 1, 4_000
QUICK_WORLDS, QUICK_ITERATIONS, QUICK_OTHER_ITERATIONS = 2, 1_500, 80
MARKS = (60, 200, 600, 1_200, 2_000, 4_000, 8_000)
FROM = 10
"""First iteration that is drawn."""
PRINTED_LOSS, HALF_OF_IT = 500, 250
SHADES = dict(zip(VARIANTS, (PALETTE[0], PALETTE[2], PALETTE[4], PALETTE[1]), strict=True))


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The main reading in all worlds, the other readings with one seed, and the posterior mean."""
    quick, worlds = options.quick, all_worlds()
    shown = worlds[:QUICK_WORLDS] if quick else worlds
    seeds = [options.seed + k for k in range(1 if quick else SEEDS)]
    trace = study(shown, seeds, READINGS[MAIN], QUICK_ITERATIONS if quick else ITERATIONS)
    steps = QUICK_OTHER_ITERATIONS if quick else OTHER_ITERATIONS
    others = {
        name: study(shown[:1] if quick else worlds, seeds[:OTHER_SEEDS], reading, steps)
        for name, reading in READINGS.items()
        if name != MAIN
    }
    mean = of_mean(worlds[0], options.seed, quick)
    headline = {
        "runs": len(trace.worlds),
        "worlds": len(shown),
        "variants": {name: told(trace, name) for name in VARIANTS},
        "true_reward": {kind: np.median(getattr(trace.truth, kind)) for kind in trace.truth._fields},
        "by_world": by_world(trace),
        "readings": {name: row(found) for name, found in {MAIN: trace.until(steps), **others}.items()},
        "posterior_mean": mean,
        "claims": claims(trace, mean),
    }
    return headline, picture(trace, headline)


def told(trace: Trace, name: str) -> Headline:
    """Median and quartiles over the runs: losses at some iterations, where they end, and when."""
    found = trace.losses[name]
    return {
        "loss_at": {
            str(mark): quartiles(found.even[:, int(np.searchsorted(trace.iterations, mark))])
            for mark in MARKS
            if mark <= trace.iterations[-1]
        },
        "final_loss": quartiles(end_of(found.even)),
        "final_loss_first_of_ties": quartiles(end_of(found.first)),
        "final_loss_by_state": quartiles(end_of(found.by_state)),
        "iterations_to_settle": quartiles(settled(found.even, trace.iterations)),
        "iterations_to_settle_by_state": quartiles(settled(found.by_state, trace.iterations)),
        "times_fewer_iterations_than_policywalk": quartiles(speed_ups(trace, name)),
    }


def by_world(trace: Trace) -> Headline:
    """Median of where the losses end in each world."""
    worlds = np.array(trace.worlds)
    return {
        world: {name: np.median(end_of(trace.losses[name].even[worlds == world])) for name in VARIANTS}
        for world in dict.fromkeys(trace.worlds)
    }


def row(trace: Trace) -> Headline:
    """One reading: at iteration 600 and at the end, and how much faster than PolicyWalk."""
    at = min(int(np.searchsorted(trace.iterations, 600)), len(trace.iterations) - 1)
    return {
        name: {
            f"loss_at_{trace.iterations[at]}": np.median(found.even[:, at]),
            f"loss_at_{trace.iterations[-1]}": np.median(end_of(found.even)),
            "by_state": np.median(end_of(found.by_state)),
            "times_fewer_iterations_than_policywalk": np.median(speed_ups(trace, name)),
        }
        for name, found in trace.losses.items()
    }


def quartiles(values: Floats) -> Any:
    """25, 50 and 75 %, of those that are numbers."""
    return np.nanquantile(values, [0.25, 0.5, 0.75]).round(3)


def picture(trace: Trace, headline: Headline) -> Figure:
    """Loss by iteration, by pairs and by states, and when and where each run ends."""
    figure = sheet(10.6, 7.6)
    figure.suptitle(f"Bayesian IRL in Room World: what the current reward gets wrong ({headline['runs']} runs)")
    panels: Any = figure.subplots(2, 2)
    draw_losses(panels[0, 0], trace, "even")
    panels[0, 0].axhline(PRINTED_LOSS, color=GREY, lw=1, ls="--")
    panels[0, 0].axhline(HALF_OF_IT, color=GREY, lw=1, ls=":")
    for height, word in ((PRINTED_LOSS, "thesis: PolicyWalk"), (HALF_OF_IT, "thesis: relevance")):
        panels[0, 0].annotate(word, (FROM * 1.1, height), va="bottom", fontsize=8, color=INK)
    panels[0, 0].set(ylabel="pairs of 5,000 (log scale)", yscale="log", ylim=(150, 5_000))
    panels[0, 0].set_yticks([200, 500, 1_000, 2_000, 4_000], ["200", "500", "1,000", "2,000", "4,000"])
    panels[0, 0].minorticks_off()
    panels[0, 0].set_title("Expert's actions that the learned policy does not take")
    draw_losses(panels[0, 1], trace, "by_state")
    panels[0, 1].set(ylabel="share", ylim=(0, 0.8))
    panels[0, 1].legend(loc="upper right", title="median, middle half shaded", title_fontsize=8.5)
    panels[0, 1].set_title("The same, each visited state counting once")
    draw_boxes(panels[1, 0], [settled(found.even, trace.iterations) for found in trace.losses.values()])
    panels[1, 0].set_title("Iterations until nine tenths of the way to where a run ends")
    draw_boxes(panels[1, 1], [end_of(found.even) for found in trace.losses.values()])
    panels[1, 1].set_title(f"Where a run ends, after {trace.iterations[-1]:,} iterations (pairs)")
    return figure


def draw_losses(axis: Axes, trace: Trace, kind: str) -> None:
    """Median over the runs, the middle half of them shaded."""
    for name, found in trace.losses.items():
        low, middle, high = np.quantile(getattr(found, kind), [0.25, 0.5, 0.75], axis=0)
        axis.fill_between(trace.iterations, low, high, color=SHADES[name], alpha=0.13, lw=0)
        axis.plot(trace.iterations, middle, color=SHADES[name], label=name)
    axis.set(xlabel="iteration (log scale)", xscale="log", xlim=(FROM, trace.iterations[-1]))
    ticks = [tick for tick in (10, 30, 100, 300, 1_000, 3_000, 8_000) if tick <= trace.iterations[-1]]
    axis.set_xticks(ticks, [f"{tick:,}" for tick in ticks])


def draw_boxes(axis: Axes, values: list[Floats]) -> None:
    """Medians, quartiles and the middle nine tenths of the runs."""
    boxes = axis.boxplot(
        [each[np.isfinite(each)] for each in values], orientation="horizontal", whis=(5, 95), showfliers=False,
        patch_artist=True, widths=0.55, medianprops={"color": INK, "lw": 1.6},
    )  # fmt: skip
    for box, shade in zip(boxes["boxes"], SHADES.values(), strict=True):
        box.set(facecolor=shade, alpha=0.55, edgecolor=INK)
    for height, each in enumerate(values, start=1):
        middle = float(np.nanmedian(each))
        axis.annotate(f"{middle:,.0f}", (middle, height - 0.3), ha="center", va="bottom", fontsize=8.5)
    axis.set_yticks(range(1, len(values) + 1), list(VARIANTS))
    axis.xaxis.set_major_formatter("{x:,.0f}")
    axis.set(ylim=(len(values) + 0.6, 0.25), xlim=(0, None))
    axis.grid(axis="y", visible=False)


if __name__ == "__main__":
    run("fig_3_4", experiment)
