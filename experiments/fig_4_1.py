"""Figure 4-1: three subgoals out of one demonstration in a grid world (thesis 4.7.1).

Optimal actions from (15, 1) to (10, 12), (2, 17) and (2, 2) in turn, in a 20 × 20 world with noisy transitions;
confidence 10, concentration 1, a stay pair on arrival at every subgoal. 25 runs, each with walls of its own.
"""

from __future__ import annotations

from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.grid_pictures import study_picture
from experiments.grid_study import Setting, study

SETTING = Setting((15, 1), ((10, 12), (2, 17), (2, 2)))


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The study, and a picture of its first run."""
    headline, runs, losses = study(SETTING, options.seed, options.quick)
    return headline, study_picture(
        runs[0], SETTING, {"BNIRL": losses}, headline, seen="actions (arrows), stays (crosses)", number="three"
    )


if __name__ == "__main__":
    run("fig_4_1", experiment)
