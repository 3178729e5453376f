"""Figure 4-3: four subgoals out of five rounds of a loop (thesis 4.7.3), with state and with feature subgoals.

From (10, 1) to (19, 9), (10, 17), (2, 9) and back, five times, in a 20 × 20 world with noisy transitions; distance
features (4.16) at the four subgoals; confidence 10, concentration 1, a stay pair on arrival at every subgoal. 25 runs,
each with walls of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.grid_pictures import study_picture
from experiments.grid_study import Run, Setting, study, true_cells
from experiments.grid_worlds import demonstrate, held_out_loss, loss_by_sweep, posterior_of, table
from subgoal.answers.scores import top_candidates
from subgoal.candidates import feature_subgoals
from subgoal.mdp.grids.features import feature_groups, manhattan

SETTING = Setting((10, 1), ((19, 9), (10, 17), (2, 9), (10, 1)), loops=5)
STATES, FEATURES = "BNIRL, state subgoals", "BNIRL, feature subgoals"


def experiment(options: Options) -> tuple[Headline, Figure]:
    """The study with state subgoals, and the same runs with feature subgoals."""
    headline, runs, losses = study(SETTING, options.seed, options.quick)
    outcomes = [with_features(each, options.seed + k) for k, each in enumerate(runs)]
    feature_losses = np.stack([outcome["losses"] for outcome in outcomes])
    headline["final_loss"] = {STATES: float(losses[:, -1].mean()), FEATURES: float(feature_losses[:, -1].mean())}
    headline["held_out_loss"] = {
        STATES: headline["held_out_loss"]["BNIRL"],
        FEATURES: float(np.mean([outcome["held_out"] for outcome in outcomes])),
    }
    headline["features"] = {
        "runs_all_true_subgoals": sum(outcome["found"] for outcome in outcomes),
        "feature_vectors": float(np.mean([outcome["vectors"] for outcome in outcomes])),
        "free_cells": float(np.mean([each.grid.n_states for each in runs])),
    }
    both = {STATES: losses, FEATURES: feature_losses}
    return headline, study_picture(runs[0], SETTING, both, headline, seen="five rounds of a loop", number="four")


def with_features(each: Run, seed: int) -> dict[str, Any]:
    """The same pairs with feature subgoals: those met, with anchors at the true subgoals."""
    grid, demos = each.grid, each.shown.demonstrations
    groups = feature_groups(manhattan(grid, [(x - 1, y - 1) for x, y in SETTING.subgoals]))
    likelihood = table(demos, grid, feature_subgoals(groups, demos, coordinates=grid.mdp.coordinates))
    posterior = posterior_of(likelihood, seed, draws=300, warmup=200, thin=2)
    sets: Any = posterior.candidates.goal_sets
    true = {int(groups.group[goal]) for goal in true_cells(each, SETTING.subgoals)}
    found = {int(groups.group[sets[g][0]]) for g in top_candidates(posterior, len(true))}
    fresh = demonstrate(grid, SETTING.start, SETTING.subgoals, loops=SETTING.loops, seed=seed + 500)
    return {
        "found": found == true, "vectors": len(groups.vectors), "losses": loss_by_sweep(likelihood, seed),
        "held_out": held_out_loss(posterior, fresh.demonstrations),
    }  # fmt: skip


if __name__ == "__main__":
    run("fig_4_3", experiment)
