"""Figure 4-1: three subgoals out of one demonstration in a grid world (thesis 4.7.1).

Optimal actions from (15, 1) to (10, 12), (2, 17) and (2, 2) in turn, in a 20 × 20 world with noisy transitions;
confidence 10, concentration 1, a stay pair on arrival at every subgoal. 25 runs, each with walls of its own.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run, sheet
from experiments.grid_pictures import draw_counts, draw_losses, draw_map, draw_pairs, draw_subgoals
from experiments.grid_study import Run, Setting, study, true_cells
from subgoal.runtime.checks import Floats

SETTING = Setting((15, 1), ((10, 12), (2, 17), (2, 2)))


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The study, and a picture of its first run."""
    headline, runs, losses = study(SETTING, options.seed, options.quick)
    return headline, picture(runs[0], losses, headline)


def picture(example: Run, losses: Floats, headline: Headline) -> Figure:
    """Observed pairs, loss against sweep, and what was found."""
    figure = sheet(10.5, 8.8)
    top_left, top_right, bottom_left, bottom_right = figure.subplots(2, 2).ravel()
    draw_map(top_left, example.grid)
    draw_pairs(top_left, example.grid, example.shown.demonstrations)
    top_left.set_title("What was seen: actions (arrows), stays (crosses)")
    draw_losses(top_right, {"BNIRL": losses}, headline["sweeps_to_minimum_loss"])
    top_right.set_title("Actions that the sampled subgoals do not explain")
    draw_map(bottom_left, example.grid)
    true = np.array(true_cells(example, SETTING.subgoals))
    draw_subgoals(bottom_left, example.grid, example.posterior, true)
    bottom_left.set_title("What was found: subgoals with their share (stars: the truth)")
    draw_counts(bottom_right, headline)
    bottom_right.set_title("In how many runs all three were found")
    return figure


if __name__ == "__main__":
    run("fig_4_1", experiment)
