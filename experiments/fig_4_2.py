"""Figure 4-2: one linear reward, which subgoals are not (thesis 4.7.2), learned by BNIRL and by methods of one reward.

Six Manhattan-distance features (4.16) at random cells, weights uniform in [−1, 1]; five demonstrations of 15 optimal
actions from (15, 1) in a 20 × 20 world with noisy transitions. 25 runs, each with walls and a reward of its own. In
sample, BNIRL's loss is that of each action under the subgoal it is assigned to, with the action in view: no prediction.
Two readings of what the thesis leaves open: ``FIRST_SET``, confidence 10 and the policy that each method returns; and
``CHOSEN``, with what loses least on fresh demonstrations in other worlds.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from experiments.common import Headline, Options, run
from experiments.grid_worlds import (
    CONFIDENCE,
    held_out_loss,
    loss_by_sweep,
    posterior_of,
    sweeps_to_minimum,
)
from experiments.linear_world import PAIRS, Shown, shown
from experiments.rival_choices import nearby_loss, tried
from experiments.rival_pictures import one_reward_picture
from experiments.rivals import ABBEEL, BAYESIAN, RIVALS, Learned, Lengths, abbeel, abbeel_both, bayesian, curve, wrong
from subgoal.answers.scores import top_candidates
from subgoal.candidates import Candidates, feature_subgoals, visited
from subgoal.likelihood.planned_actions import planned_actions
from subgoal.mdp.grids.grid import GridWorld
from subgoal.posterior.posterior import Posterior
from subgoal.runtime.checks import Floats

RUNS, QUICK_RUNS = 25, 2
QUICK = Lengths(60, 20, 10, 1)
WITHIN = 3.0
"""Pairs of 75."""
STATES, FEATURES, TRUTH = "BNIRL, state subgoals", "BNIRL, feature subgoals", "true reward"
FIRST_SET, CHOSEN = "as first set", "chosen in other worlds"
CHOSEN_CONFIDENCE = 10_000.0


def experiment(options: Options) -> tuple[Headline, Figure]:
    """All runs with both kinds of subgoals and all rivals, by both readings."""
    count = QUICK_RUNS if options.quick else RUNS
    cases = [shown(options.seed + k) for k in range(count)]
    readings: dict[str, dict[str, Headline]] = {FIRST_SET: {}, CHOSEN: {}}
    losses: dict[str, Floats] = {}
    first: Any = None
    for name in (STATES, FEATURES):
        for reading, confidence in ((FIRST_SET, CONFIDENCE), (CHOSEN, CHOSEN_CONFIDENCE)):
            rows = [subgoals_on(case, options.seed + k, name, confidence) for k, case in enumerate(cases)]
            losses[f"{name}, {reading}"] = np.stack([row["losses"] for row in rows])
            keys = ("in_sample", "held_out", "in_sample_predicted")
            means = {key: float(np.mean([row[key, reading] for row in rows])) for key in keys}
            readings[reading][name] = means
            first = first or rows[0]["posterior"]
    for name, learned in rivals_on(cases, options).items():
        for reading in readings:
            policies = [each.returned if reading == FIRST_SET else each.best for each in learned]
            readings[reading][name] = scores(cases, policies)
            so_far = reading == CHOSEN and name != BAYESIAN
            losses[f"{name}, {reading}"] = PAIRS * np.stack([curve(each, so_far=so_far) for each in learned])
    for methods in readings.values():
        methods[TRUTH] = scores(cases, [case.policy for case in cases])
    headline: Headline = {
        "runs": count, "layouts": count, "pairs": PAIRS, "readings": readings,
        "spread": {reading: spread(methods) for reading, methods in readings.items()},
        "iterations_to_minimum": {name: sweeps_to_minimum(values) for name, values in losses.items()},
        "abbeel_by_its_quadratic_program_alone": scores(cases, [quadratic(case).best for case in cases]),
        "tried_elsewhere": tried(options.quick),
        "subgoals": _listed(first, cases[0].grid),
        "feature_vectors_per_free_cell": float(np.mean([len(c.groups.vectors) / c.grid.n_states for c in cases])),
    }  # fmt: skip
    headline["met"] = {reading: {key: row[key] <= WITHIN for key in row} for reading, row in headline["spread"].items()}
    example = max(cases, key=lambda case: np.unique(case.demonstrations.states).size)
    return headline, one_reward_picture(example, losses, headline, CHOSEN)


def subgoals_on(case: Shown, seed: int, name: str, confidence: float) -> dict[Any, Any]:
    """One run of BNIRL: pairs wrong by sweep; in sample through the last sweep; held out, by each reading's rule.

    Weights of the subgoals in predictions are those of all pairs, or of those nearby where that is what was chosen.
    """
    demos, fresh = case.demonstrations, case.fresh
    likelihood = planned_actions(demos, candidates(name, case), case.grid.mdp, confidence=confidence)
    posterior = posterior_of(likelihood, seed, draws=300, warmup=200, thin=2)
    by_sweep = loss_by_sweep(likelihood, seed)
    made: dict[Any, Any] = {"posterior": posterior, "losses": by_sweep}
    for reading, loss in ((FIRST_SET, held_out_loss), (CHOSEN, nearby_loss)):
        made["in_sample", reading] = float(by_sweep[-1])
        made["held_out", reading] = PAIRS * loss(posterior, fresh)
        made["in_sample_predicted", reading] = PAIRS * loss(posterior, demos)
    return made


def rivals_on(cases: list[Shown], options: Options) -> dict[str, list[Learned]]:
    """What each rival makes of each run; Abbeel and Ng's is let choose from the policies of both their programs."""
    made: dict[str, list[Learned]] = {}
    for name, rival in (RIVALS | {ABBEEL: abbeel_both}).items():
        more: Any = {"lengths": QUICK} if options.quick and rival is bayesian else {}
        made[name] = [
            rival(case.demonstrations, case.grid.mdp, case.features, options.seed + k, **more)
            for k, case in enumerate(cases)
        ]
    return made


def quadratic(case: Shown) -> Learned:
    """Abbeel and Ng's quadratic program, without the policies of the projection."""
    return abbeel(case.demonstrations, case.grid.mdp, case.features)


def scores(cases: list[Shown], policies: list[Floats]) -> Headline:
    """Mean pairs wrong, of 75."""
    pairs = list(zip(cases, policies, strict=True))
    return {
        "in_sample": PAIRS * float(np.mean([wrong(policy, case.demonstrations) for case, policy in pairs])),
        "held_out": PAIRS * float(np.mean([wrong(policy, case.fresh) for case, policy in pairs])),
    }


def spread(methods: dict[str, Headline]) -> dict[str, float]:
    """Pairs between the best and the worst method; the true reward is none."""
    learned = [row for name, row in methods.items() if name != TRUTH]
    return {
        key: max(row[key] for row in learned) - min(row[key] for row in learned) for key in ("in_sample", "held_out")
    }


def candidates(name: str, case: Shown) -> Candidates:
    """Visited states, or the features met."""
    if name == STATES:
        return visited(case.demonstrations)
    return feature_subgoals(case.groups, case.demonstrations, coordinates=case.grid.mdp.coordinates)


def _listed(posterior: Posterior, grid: GridWorld) -> list[Headline]:
    top = [g for g in top_candidates(posterior, 6) if posterior.expected_shares[g] > 0.02]
    return [{"cell": (posterior.candidates.points[g] + 1).tolist(), "share": posterior.expected_shares[g]} for g in top]


if __name__ == "__main__":
    run("fig_4_2", experiment)
