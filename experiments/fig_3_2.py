"""Figure 3-2: the prior of rewards (3.8), as the thesis prints it and in a unit in which its three peaks show.

As printed, 0.001 stands before a square of rewards of at most 0.01: a peak is 22.4 wide, 2,236 times the largest
reward, and the prior says nothing. The thesis calls its picture "scaled"; with rewards of magnitude 100 the same number
is 10 per squared R_max, and rewards are most likely zero and else at an end.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.common import INK, PALETTE, Headline, Options, run, sheet
from subgoal.irl.reward_priors import PRINTED_STEEPNESS, SCALED_STEEPNESS, ThreePeaks

MAGNITUDE = 0.01
REACH = 1.5
"""In units of R_max."""
POINTS = np.linspace(-REACH, REACH, 1_201)
PRINTED, SCALED = ThreePeaks(-MAGNITUDE, MAGNITUDE), ThreePeaks.scaled(MAGNITUDE)


def experiment(options: Options) -> tuple[Headline, Figure]:
    """Both densities, and how much each distinguishes rewards of zero from rewards at an end."""
    headline = {"as_printed": told(PRINTED), "scaled": told(SCALED), "claims": [claim()]}
    figure = sheet(9.4, 4.0)
    figure.suptitle("What is believed of a state's reward before anything is seen (3.8)")
    left, right = figure.subplots(1, 2, sharey=True)
    _draw(left, PRINTED, PALETTE[1])
    left.set_title(f"As printed: {PRINTED_STEEPNESS}·R², and R_max = {MAGNITUDE}")
    left.annotate("flat: all rewards alike", (0, 0.9), ha="center", color=PALETTE[1])
    _draw(right, SCALED, PALETTE[0])
    right.set_title(f"Scaled: {SCALED_STEEPNESS:g}·(R/R_max)²")
    for place, height, name in ((-1, 0.47, "smallest"), (0, 1.04, "most likely none"), (1, 0.47, "largest")):
        right.annotate(name, (place, height), ha="center", color=INK)
    left.set(ylim=(0, 1.15), ylabel="density, its largest value being 1")
    return headline, figure


def densities(prior: ThreePeaks) -> Any:
    """Relative to the largest, at ``POINTS``."""
    log = prior.log_density(MAGNITUDE * POINTS)
    return np.exp(log - log.max())


def told(prior: ThreePeaks) -> Headline:
    """Numbers of one prior: by how much a reward of zero is more likely than others, and where a chain begins."""
    low, none, half, high = prior.log_density(MAGNITUDE * np.array([-1, 0, 0.5, 1]))
    return {
        "steepness_per_squared_reward": prior.steepness,
        "deviation_of_a_peak_in_R_max": 1 / np.sqrt(2 * prior.steepness) / MAGNITUDE,
        "zero_against_R_max": np.exp(none - high),
        "zero_against_R_min": np.exp(none - low),
        "zero_against_half_R_max": np.exp(none - half),
        "start": prior.start,
    }


def claim() -> Headline:
    """The prior of the thesis is said to make zero likeliest and the ends likelier than what is between."""
    low, none, half, high = PRINTED.log_density(MAGNITUDE * np.array([-1, 0, 0.5, 1]))
    holds = min(none - high, none - low) > 0.01 and high > half
    return {
        "name": "the prior says that most rewards are zero and others at an end",
        "verdict": "holds" if holds else "does not hold",
        "measured": f"density at zero over that at R_max: 1 + {np.expm1(none - high):.0e} as printed; "
        f"{np.exp(np.subtract(*SCALED.log_density([0.0, MAGNITUDE]))):.1f} scaled",
        "thesis": "most likely zero, and if not then the minimum or maximum reward value (3.2.2)",
    }


def _draw(axis: Axes, prior: ThreePeaks, tint: str) -> None:
    axis.fill_between(POINTS, densities(prior), color=tint, alpha=0.15, lw=0)
    axis.plot(POINTS, densities(prior), color=tint)
    axis.set(xlim=(-REACH, REACH), xlabel="reward R / R_max")
    axis.set_xticks([-1, 0, 1], ["R_min", "0", "R_max"])


if __name__ == "__main__":
    run("fig_3_2", experiment)
