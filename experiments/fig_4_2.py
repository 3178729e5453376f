"""Figure 4-2: one linear reward, which subgoals are not (thesis 4.7.2), with state and with feature subgoals.

Six Manhattan-distance features (4.16) at random cells, weights uniform in [−1, 1]; five demonstrations of 15 optimal
actions from (15, 1) in a 20 × 20 world with noisy transitions; confidence 10, concentration 1. 25 runs, each with walls
and a reward of its own.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run, sheet
from experiments.grid_pictures import draw_losses, draw_map, draw_pairs, draw_subgoals
from experiments.grid_worlds import held_out_loss, loss_by_sweep, posterior_of, state, sweeps_to_minimum, table, world
from subgoal.answers.scores import policy_loss, top_candidates
from subgoal.candidates import Candidates, feature_subgoals, visited
from subgoal.demonstrations.records import Demonstrations
from subgoal.mdp.grids.features import FeatureGroups, feature_groups, manhattan
from subgoal.mdp.grids.grid import GridWorld
from subgoal.mdp.planners.iteration import action_values
from subgoal.mdp.planners.policy import greedy_actions, uniform_policy
from subgoal.mdp.planners.policy_iteration import policy_iteration
from subgoal.mdp.simulation import simulate
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats
from subgoal.runtime.seeds import stream

START = (15, 1)
DEMONSTRATIONS, STEPS, ANCHORS = 5, 15, 6
RUNS, QUICK_RUNS = 25, 4
STATES, FEATURES, TRUTH = "BNIRL, state subgoals", "BNIRL, feature subgoals", "true reward"


@dataclass(frozen=True, eq=False)
class Shown:
    """One run's world, reward, and optimal demonstrations: to learn from, and fresh ones."""

    grid: GridWorld
    groups: FeatureGroups
    policy: Floats
    demonstrations: Demonstrations
    fresh: Demonstrations

    @property
    def floor(self) -> float:
        """0-1 loss of the demonstrator's own policy, its ties broken at random."""
        return policy_loss(self.policy[self.demonstrations.states] > 0, self.demonstrations.actions)


def shown(seed: int) -> Shown:
    """A random linear reward and optimal actions for it."""
    grid = world(seed)
    generator = stream(seed, 42)
    anchors = grid.cells[generator.choice(grid.n_states, ANCHORS, replace=False)]
    features = manhattan(grid, anchors)
    reward = features @ generator.uniform(-1, 1, size=ANCHORS)
    plan = policy_iteration(grid.mdp, reward)
    values = action_values(grid.mdp, plan.value, reward)
    policy = uniform_policy(greedy_actions(values, 1e-9 * float(np.abs(plan.value).max())))
    acted = {"steps": STEPS, "trajectories": DEMONSTRATIONS, "start": state(grid, START)}
    made = [simulate(grid.mdp, policy, seed=each, **acted) for each in (seed, seed + 1_000)]
    return Shown(grid, feature_groups(features), policy, *made)


def experiment(options: Options) -> tuple[Headline, Figure]:
    """All runs with both kinds of subgoals."""
    count = QUICK_RUNS if options.quick else RUNS
    cases = [shown(options.seed + k) for k in range(count)]
    losses: dict[str, Floats] = {}
    held_out, seconds, posteriors = {}, {}, {}
    for name in (STATES, FEATURES):
        begin = time.perf_counter()
        likelihoods = [table(case.demonstrations, case.grid, candidates(name, case)) for case in cases]
        losses[name] = np.stack([loss_by_sweep(each, options.seed + k) for k, each in enumerate(likelihoods)])
        seconds[name] = (time.perf_counter() - begin) / count
        posteriors[name] = [posterior_of(each, options.seed + k, draws=300, warmup=200, thin=2)
                            for k, each in enumerate(likelihoods)]  # fmt: skip
        pairs = zip(posteriors[name], cases, strict=True)
        held_out[name] = float(np.mean([held_out_loss(posterior, case.fresh) for posterior, case in pairs]))
    headline = {
        "runs": count,
        "sweeps_to_minimum_loss": {name: sweeps_to_minimum(values) for name, values in losses.items()},
        "final_loss": {name: float(values[:, -1].mean()) for name, values in losses.items()}
        | {TRUTH: float(np.mean([case.floor for case in cases]))},
        "held_out_loss": held_out,
        "seconds_per_run": seconds,
        "subgoals": _listed(posteriors[STATES][0], cases[0].grid),
        "layouts": count,
        "pairs": DEMONSTRATIONS * STEPS,
        "feature_vectors_per_free_cell": float(np.mean([len(c.groups.vectors) / c.grid.n_states for c in cases])),
    }
    return headline, picture(cases[0], posteriors[STATES][0], losses, headline)


def candidates(name: str, case: Shown) -> Candidates:
    """Visited states, or the features met."""
    if name == STATES:
        return visited(case.demonstrations)
    return feature_subgoals(case.groups, case.demonstrations, coordinates=case.grid.mdp.coordinates)


def _listed(posterior: Posterior, grid: GridWorld) -> list[Headline]:
    top = [g for g in top_candidates(posterior, 6) if posterior.expected_shares[g] > 0.02]
    return [{"cell": (posterior.candidates.points[g] + 1).tolist(), "share": posterior.expected_shares[g]} for g in top]


def picture(case: Shown, posterior: Posterior, losses: dict[str, Floats], headline: Headline) -> Figure:
    """Observed pairs, what subgoals they are explained with, and loss against sweep."""
    figure = sheet(12.5, 4.6)
    left, middle, right = figure.subplots(1, 3)
    draw_map(left, case.grid)
    draw_pairs(left, case.grid, case.demonstrations)
    left.set_title("What was seen: five walks, one reward")
    draw_map(middle, case.grid)
    draw_subgoals(middle, case.grid, posterior, np.empty(0, np.int64))
    middle.set_title("The subgoals that explain it")
    draw_losses(right, losses, max(headline["sweeps_to_minimum_loss"].values()), headline["final_loss"][TRUTH])
    right.set_title("Actions left unexplained, of 75")
    return figure


if __name__ == "__main__":
    run("fig_4_2", experiment)
